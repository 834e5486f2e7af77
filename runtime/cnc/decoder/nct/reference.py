"""The reference of the NCT dialect as rows, made from the registrations."""

from __future__ import annotations

from runtime.cnc.decoder.nct import codes  # noqa: F401 - registers the dialect
from runtime.cnc.decoder.nct.registry import G_CODES, M_CODES, WORDS, system_variables
from runtime.cnc.decoder.reference_row import Row
from runtime.cnc.language.nct.addresses import ADDRESSES
from runtime.cnc.language.nct.words import Control

CONTROL = [
    Row("GOTO", "GOTO n", "block", "goes on at the block with the number n"),
    Row(
        "IF", "IF [<condition>] GOTO n | IF [<condition>] THEN <words or assignment>", "block", "if the condition holds"
    ),
    Row("WHILE", "WHILE [<condition>] DO m … END m", "block", "as long as the condition holds; m is 1, 2 or 3"),
    Row("DO", "DO m … END m", "block", "again and again"),
    Row("END", "END m", "block", "the end of the loop m"),
]
assert {row.name for row in CONTROL} == {control.value for control in Control}


def g_codes() -> list[Row]:
    """The G codes by number."""
    return [
        Row(code.name, _syntax(code.name, code.takes, code.axes), "modal" if code.modal else "block", code.meaning)
        for _, code in sorted(G_CODES.items())
    ]


def _syntax(name: str, takes: frozenset[str], axes: bool) -> str:
    return " ".join([name, *(["<axes>"] if axes else []), *(f"{address}_" for address in sorted(takes))])


def m_codes() -> list[Row]:
    """The M codes that the control acts on itself."""
    return [
        Row(f"M{number:02d}", _syntax(f"M{number:02d}", code.takes, False), "block", code.meaning)
        for number, code in sorted(M_CODES.items())
    ]


def words() -> list[Row]:
    """The addresses; those with a meaning of their own with it."""
    rows = [Row("/", "/n", "block", "the block is left out while skip switch n (1 to 9) is on")]
    for name, address in ADDRESSES.items():
        known = WORDS.get(name)
        limits = f"{address.least:g} … {address.most:g}"
        meaning = known.meaning if known is not None else address.meaning
        syntax = known.syntax if known is not None else f"{name}_"
        rows.append(Row(name, syntax, "modal" if known is not None else "block", f"{meaning} ({limits})"))
    return rows


def variables() -> list[Row]:
    """The system variables."""
    return [
        Row(
            f"#{v.first}" if v.first == v.last else f"#{v.first}…#{v.last}",
            "read and write" if v.read and v.write else "read" if v.read else "write",
            "",
            v.meaning,
        )
        for v in system_variables()
    ]
