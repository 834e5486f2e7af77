"""Random string expressions with their values (programming manual lines 1637–1753).

Positions count from 1, the count of characters stands in front of the position. Only what the manual tells: all parts lie within
their strings.
"""

from __future__ import annotations

from dataclasses import dataclass

from hypothesis import strategies as st

from tests.cnc.language.oracle.expressions import Term

_CHARACTERS = "abcXYZ019 .,:+-*/<>=!?_#$%&()[];"


@dataclass(frozen=True, slots=True)
class Text:
    """A string expression and its value."""

    text: str
    value: str


def literal(value: str) -> Text:
    """A string between quotation marks."""
    return Text(f'"{value}"', value)


def joined(left: Text, right: Text) -> Text:
    return Text(f"{left.text} + {right.text}", left.value + right.value)


def left(of: Text, count: int) -> Text:
    return Text(f"LEFT[{of.text}, {count}]", of.value[:count])


def middle(of: Text, count: int, position: int) -> Text:
    return Text(f"MID[{of.text}, {count}, {position}]", of.value[position - 1 : position - 1 + count])


def right(of: Text, count: int) -> Text:
    return Text(f"RIGHT[{of.text}, {count}]", of.value[len(of.value) - count :])


def deleted(of: Text, count: int, position: int) -> Text:
    value = of.value[: position - 1] + of.value[position - 1 + count :]
    return Text(f"DELETE[{of.text}, {count}, {position}]", value)


def inserted(of: Text, other: Text, position: int) -> Text:
    """Behind the character at `position`."""
    value = of.value[:position] + other.value + of.value[position:]
    return Text(f"INSERT[{of.text}, {other.text}, {position}]", value)


def replaced(of: Text, other: Text, count: int, position: int) -> Text:
    value = of.value[: position - 1] + other.value + of.value[position - 1 + count :]
    return Text(f"REPLACE[{of.text}, {other.text}, {count}, {position}]", value)


def from_integer(number: int) -> Text:
    return Text(f"INT_TO_STR[{number}]", str(number))


def length(of: Text) -> Term:
    return Term(f"LEN[{of.text}]", float(len(of.value)))


def found(of: Text, other: Text) -> Term:
    """The position of the first match, 0 for none; `other` is not empty."""
    return Term(f"FIND[{of.text}, {other.text}]", float(of.value.find(other.value) + 1))


def character(of: Text, position: int | None) -> Term:
    """The value of a character; 0 for an empty string without a position."""
    if position is None:
        return Term(f"ORD[{of.text}]", float(ord(of.value[0])) if of.value else 0.0)
    return Term(f"ORD[{of.text}, {position}]", float(ord(of.value[position - 1])))


def to_integer(number: int) -> Term:
    return Term(f'STR_TO_INT["{number}"]', float(number))


def to_real(hundredths: int) -> Term:
    text = f"{hundredths / 100:.2f}"
    return Term(f'STR_TO_REAL["{text}"]', float(text))


def there_and_back(quarters: int) -> Term:
    """A number through its text; two decimals are the least that REAL_TO_STR may give."""
    return Term(f"STR_TO_REAL[REAL_TO_STR[{quarters / 4}]]", quarters / 4)


COMPARISONS = ("==", "!=", "<", "<=", ">", ">=")


def compared(operator: str, first: Text, second: Text) -> Term:
    """1 or 0, as a condition: case-sensitive, in the order of the characters."""
    a, b = first.value, second.value
    value = {"==": a == b, "!=": a != b, "<": a < b, "<=": a <= b, ">": a > b, ">=": a >= b}[operator]
    return Term(f"{first.text} {operator} {second.text}", float(value))


_words = st.text(st.sampled_from(_CHARACTERS), max_size=8).map(literal)


@st.composite
def _operation(draw: st.DrawFn, inner: st.SearchStrategy[Text]) -> Text:
    of = draw(inner)
    size = len(of.value)
    position = draw(st.integers(1, max(size, 1)))
    count = draw(st.integers(0, max(size - position + 1, 0)))
    if size == 0:
        return joined(of, draw(inner))
    match draw(st.integers(0, 6)):
        case 0:
            return joined(of, draw(inner))
        case 1:
            return left(of, count)
        case 2:
            return middle(of, count, position)
        case 3:
            return right(of, count)
        case 4:
            return deleted(of, count, position)
        case 5:
            return inserted(of, draw(inner), position)
        case _:
            return replaced(of, draw(inner), count, position)


strings = st.recursive(
    st.one_of(_words, st.integers(-99999, 99999).map(from_integer)), lambda inner: _operation(inner), max_leaves=5
)


@st.composite
def _questions(draw: st.DrawFn) -> Term:
    of = draw(strings)
    match draw(st.integers(0, 6)):
        case 0:
            return length(of)
        case 1:
            return character(of, None)
        case 2 if of.value:
            return character(of, draw(st.integers(1, len(of.value))))
        case 3:
            return to_integer(draw(st.integers(-99999, 99999)))
        case 4:
            return to_real(draw(st.integers(-99999, 99999)))
        case 5:
            return there_and_back(draw(st.integers(-9999, 9999)))
        case _:
            other = draw(strings.filter(lambda text: text.value != ""))
            return found(of, other)


questions = _questions()
comparisons = st.builds(compared, st.sampled_from(COMPARISONS), strings, strings)
