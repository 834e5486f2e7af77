"""The words of the block in work with their values, and who has taken them."""

from __future__ import annotations

from collections.abc import Iterable

from runtime.cnc.language.errors import LineError
from runtime.cnc.language.motion_words import WordKind
from runtime.cnc.language.nct.compiler import Value
from runtime.cnc.language.nct.words import Word
from runtime.diagnostics.errors import ErrorEntry

_KINDS = {
    WordKind.RADIUS: "R",
    WordKind.FEED: "F",
    WordKind.SPEED: "S",
    WordKind.TOOL: "T",
    WordKind.TOOL_DATA: "D",
    WordKind.M: "M",
    WordKind.H: "H",
    WordKind.G: "G",
    WordKind.DWELL: "P",
}


class BlockWords:
    """Words of a block; a vacant value is as if its word was not there (manual line 6650).

    `number` and its like take an address for whoever asks. It is also the block that the decoder's geometry asks for columns.
    `axis_of` maps addresses to channel axis indices.
    """

    __slots__ = ("_axis_of", "_first", "_taken", "all", "axes", "claimed", "radius", "signs")

    def __init__(self, words: Iterable[tuple[Word, Value]], axis_of: dict[str, int]) -> None:
        self.all = [(word, value) for word, value in words if value is not None]
        self._axis_of = axis_of
        self._first: dict[str, tuple[Word, float]] = {}
        for word, value in self.all:
            self._first.setdefault(word.address, (word, value))
        self._taken: set[str] = set()
        self.claimed: frozenset[str] = frozenset()  # addresses that belong to other codes than the mover
        self.axes: tuple[tuple[int, int], ...] = tuple(
            (axis_of[word.address], 0) for word, _ in self.all if word.address in axis_of
        )
        self.radius = 0 if "R" in self._first else -1
        self.signs: tuple[tuple[int, str], ...] = ()

    def __contains__(self, address: str) -> bool:
        return address in self._first

    def number(self, address: str) -> float | None:
        """The value of an address as it is programmed (inch is not converted), None without; the address is taken."""
        self._taken.add(address)
        found = self._first.get(address)
        return None if found is None else found[1]

    def of_mover(self, address: str) -> float | None:
        """As `number`, for the mover of the block: None if the address belongs to another code of the block (P of M98)."""
        return None if address in self.claimed else self.number(address)

    def needed(self, address: str, entry: ErrorEntry, column: int, **values: object) -> float:
        """The value of an address that has to be there, else LineError with `entry` at `column`."""
        value = self.number(address)
        if value is None:
            raise LineError(entry, column, **values)
        return value

    def incremental(self, address: str) -> bool:
        """The operator I stands behind the address."""
        found = self._first.get(address)
        return found is not None and found[0].incremental

    def signed(self, address: str) -> bool:
        """The number behind the address is written with a minus sign."""
        found = self._first.get(address)
        return found is not None and found[0].signed

    def place(self, address: str) -> int:
        """Column of the first word of an address, 1 without."""
        found = self._first.get(address)
        return 1 if found is None else found[0].column

    def drop(self, word: Word) -> None:
        """The word is as if it was not there."""
        self.all = [pair for pair in self.all if pair[0] is not word]
        self._first = {}
        for other, value in self.all:
            self._first.setdefault(other.address, (other, value))

    def take(self, addresses: Iterable[str]) -> None:
        """These have done what they are there for."""
        self._taken.update(addresses)

    def take_all(self) -> None:
        """Every word of the block is an argument."""
        self._taken.update(self._first)

    @property
    def left(self) -> list[Word]:
        """First words of the addresses that nobody has taken."""
        return [word for address, (word, _) in self._first.items() if address not in self._taken]

    def column(self, kind: WordKind, index: int | None = None) -> int:
        """Column of the first word of this kind, 1 if there is none."""
        if kind is WordKind.AXIS:
            wanted = [word for word, _ in self.all if word.address in self._axis_of]
            if index is not None and index >= 0:
                wanted = [word for word in wanted if self._axis_of[word.address] == index]
            return wanted[0].column if wanted else 1
        if kind is WordKind.INTERPOLATION:
            letters = "IJK" if index is None else "IJK"[index]
            return next((word.column for word, _ in self.all if word.address in letters), 1)
        return self.place(_KINDS.get(kind, ""))
