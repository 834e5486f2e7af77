"""ISG list files of channel parameters: lines of text → keys and values with their places.

    # comment                        from "#" to the end of the line; ";" does the same
    m_synch[12]   MVS_SVS   remark   name, blanks, value; what follows the value is a remark
    start_init_prog_file_mode  AUTOMATIC | MDI
    path[0].dir   "/my programs"     a text with blanks stands in quotes
    makro_def[4].nc_code  P5 = P2 + 3  # an NC code is all the rest of the line, up to a comment

Every parameter has a line of its own, with all of its indices; there are no includes and no blocks (manual lines 544–560,
2238–2248, 4465–4773). In an NC code "#" begins a comment only with a blank in front and a blank or "#" behind, and ";"
begins none: # functions and texts of the program are meant to stay whole.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from runtime.config.channel.key import Key, parse_key
from runtime.config.channel.parameter import ChannelParameter
from runtime.config.channel.values import words_of
from runtime.diagnostics.catalogue import configuration as errors
from runtime.diagnostics.errors import Place, Problem

LARGEST_LIST = 1_000_000  # bytes
_LINE = re.compile(r"\s*(?P<key>[^\s#;]+)(?P<gap>\s*)(?P<rest>.*?)\s*\Z")
_QUOTED = re.compile(r'"([^"]*)"\s*(.*)\Z')
_COMMENT = re.compile(r"\s*[#;].*\Z")
_CODE = re.compile(r'(?:"[^"]*"|(?!(?:(?<=\s)|\A)#(?:[\s#]|\Z)).)*')  # text in quotes is no comment


@dataclass(frozen=True, slots=True)
class ListLine:
    """A line with a parameter; `rest` is all behind the name."""

    key: Key
    rest: str
    key_place: Place
    place: Place  # of the value


@dataclass(frozen=True, slots=True)
class ListText:
    """A list file that has been read: its lines, and what is wrong in others."""

    lines: tuple[ListLine, ...]
    problems: tuple[Problem, ...]


def read_list(path: Path) -> ListText:
    """The lines of a list file. Raises OSError; a text that is no UTF-8 is taken as Latin-1, as older lists are."""
    with path.open("rb") as file:
        data = file.read(LARGEST_LIST + 1)
    if len(data) > LARGEST_LIST:
        raise OSError(f"it is larger than {LARGEST_LIST} bytes")
    if b"\0" in data:
        raise OSError("it is no text")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    return parse_list(text, str(path))


def parse_list(text: str, file: str = "-") -> ListText:
    """The lines of a list; `file` is the name for messages."""
    lines: list[ListLine] = []
    problems: list[Problem] = []
    for number, line in enumerate(re.split(r"\r\n|\n|\r", text), start=1):
        match = _LINE.match(line)
        if match is None:  # empty, or a comment
            continue
        key_place = Place(file, number, match.start("key") + 1, line)
        key = parse_key(match["key"])
        if key is None:
            problems.append(Problem(errors.LIST_KEY, {"key": match["key"]}, key_place))
            continue
        lines.append(ListLine(key, match["rest"], key_place, Place(file, number, match.start("rest") + 1, line)))
    return ListText(tuple(lines), tuple(problems))


def value_text(parameter: ChannelParameter, line: ListLine) -> str | Problem:
    """The text of the value in a line, without remark and comment; "" if there is none."""
    rest = line.rest
    if parameter.kind == "CODE":
        return _without_comment(rest)
    quoted = _QUOTED.match(rest)
    if quoted is not None:
        return quoted[1]
    rest = _COMMENT.sub("", rest)
    if parameter.kind in ("FLAGS", "SYNCH"):
        return _joined(parameter, rest, line)
    return rest.split(maxsplit=1)[0] if rest else ""


def _without_comment(code: str) -> str:
    match = _CODE.match(code)
    return match[0].rstrip() if match else ""


def _joined(parameter: ChannelParameter, rest: str, line: ListLine) -> str | Problem:
    """Words joined by "|" in front of the remark; a remark that begins with one more word lacks its "|"."""
    match = re.match(r"[^\s|]*(?:\s*\|\s*[^\s|]*)*", rest)
    value = match[0].strip() if match else ""
    remark = rest[len(value) :].split()
    if remark and remark[0] in words_of(parameter) and not value[:1].isdigit():
        return Problem(errors.LIST_BAR_MISSING, {"value": value, "word": remark[0]}, line.place)
    return value
