"""The machine builder's texts for the errors of NC programs (#ERROR): a file of lines `number text`.

    ; comment
    100 clamping pressure too low
    455 part is not in its place

Errors without a text are told by their number. The values of an error follow its text, each with its meaning.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import zip_longest
from pathlib import Path
from typing import Protocol

LARGEST_FILE = 1_000_000  # bytes
NUMBERS = range(1, 1001)  # programming manual line 15352
_LIMIT_VALUE = 1  # meaning of a value without PM

MEANINGS = (
    "",  # the value has no meaning
    "limit value", "current value", "error value", "expected value", "corrected value", "logical axis number",
    "drive type", "logical control element number", "state", "transition", "sender", "class", "instance",
    "identification number", "state", "ring number", "block number", "lower limit value", "upper limit value",
    "initial value", "final value",
)  # fmt: skip
"""Of the values of an error, by the number of PM (line 15368)."""


class ErrorTextsError(ValueError):
    """The file cannot be used; the text says why and in which line."""


class _UserError(Protocol):
    """What is told of an error of a program."""

    @property
    def number(self) -> int: ...
    @property
    def multiple(self) -> int: ...
    @property
    def values(self) -> tuple[float | str, ...]: ...
    @property
    def meanings(self) -> tuple[int, ...]: ...
    @property
    def further(self) -> tuple[float, ...]: ...
    @property
    def text(self) -> str: ...


class _Described(Protocol):
    @property
    def error_texts(self) -> str | None: ...


def load_error_texts(path: Path) -> dict[int, str]:
    """The texts of a file by number. Raises ErrorTextsError."""
    try:
        with path.open("rb") as file:
            data = file.read(LARGEST_FILE + 1)
    except OSError as error:
        raise ErrorTextsError(error.strerror or str(error)) from None
    if len(data) > LARGEST_FILE:
        raise ErrorTextsError(f"it is larger than {LARGEST_FILE} bytes")
    texts: dict[int, str] = {}
    for count, raw in enumerate(data.decode("utf-8-sig", "replace").splitlines(), 1):
        line = raw.strip()
        if not line or line.startswith(";"):
            continue
        number, _, text = line.partition(" ")
        if not (number.isascii() and number.isdigit() and int(number) in NUMBERS):
            raise ErrorTextsError(f"line {count} does not begin with a number from 1 to 1000")
        if int(number) in texts:
            raise ErrorTextsError(f"line {count}: number {number} stands twice")
        texts[int(number)] = text.strip()
    return texts


class ErrorTexts:
    """Makes the text of an error."""

    def __init__(self, texts: Mapping[int, str]) -> None:
        self._texts = dict(texts)

    @classmethod
    def of(cls, machine: _Described) -> ErrorTexts:
        """Those that the machine description names. Raises ErrorTextsError if the file went wrong since it was loaded."""
        return cls(load_error_texts(Path(machine.error_texts)) if machine.error_texts else {})

    def describe(self, error: _UserError) -> str:
        """`user error 455/10: part is not in its place; current value 5, error value 4.999`."""
        if error.text:
            return error.text
        name = f"user error {error.number}" + (f"/{error.multiple}" if error.multiple else "")
        text = self._texts.get(error.number, "")
        told = [f"{name}: {text}" if text else name, ", ".join(_values(error))]
        if error.further:
            told.append("further " + ", ".join(f"{value:g}" for value in error.further))
        return "; ".join(part for part in told if part)


def _values(error: _UserError) -> Iterator[str]:
    meanings = error.meanings[: len(error.values)]
    for value, meaning in zip_longest(error.values, meanings, fillvalue=_LIMIT_VALUE):
        name = MEANINGS[int(meaning)] if 0 <= int(meaning) < len(MEANINGS) else f"meaning {meaning}"
        if name:
            yield f"{name} {value if isinstance(value, str) else f'{value:g}'}"
