"""The base class of PLC programs."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterator, Mapping
from typing import Any, ClassVar, Generic, TypeVar

from runtime.diagnostics.catalogue import plc as catalogue
from runtime.hli.technology import Kind
from runtime.plc_logic.areas import AxisPort, ChannelPort, SpindlePort
from runtime.plc_logic.cycle_time import now_ns
from runtime.plc_logic.errors import PlcError
from runtime.plc_logic.external import ExternalStructure
from runtime.plc_logic.handlers import Key
from runtime.plc_logic.image import Io
from runtime.plc_logic.reports import AlarmChange, Reports

T = TypeVar("T")


class ByName(Mapping[str, T], Generic[T]):
    """Areas by their names; a wrong name raises PlcError, which tells the right ones."""

    def __init__(self, kind: str, areas: dict[str, T]) -> None:
        self._kind = kind
        self._areas = areas

    def __getitem__(self, name: str) -> T:
        area = self._areas.get(name)
        if area is None:
            near = difflib.get_close_matches(name, self._areas, n=3) or list(self._areas)
            raise PlcError(catalogue.PLC_NAME, kind=self._kind, name=name, known=", ".join(near) or "none")
        return area

    def __iter__(self) -> Iterator[str]:
        return iter(self._areas)

    def __len__(self) -> int:
        return len(self._areas)


class Program:
    """A PLC program: derive from it, and name the class in the machine description.

    In every PLC cycle the inputs are read, the handlers of the technology functions that wait are called, the tasks that
    are due, then `cycle`, and the outputs are written. So `cycle` has the last word: interlocks belong there.
    """

    io: Io
    external: ExternalStructure  # V.E: what is shared with the NC programs
    channels: list[ChannelPort]
    axes: ByName[AxisPort]  # spindles included
    spindles: ByName[SpindlePort]
    time: float  # s since the start of the runtime
    cycle_time: float  # s since the PLC cycle before; 0 in the first

    handlers: ClassVar[dict[Key, str]] = {}  # technology function -> name of the method that carries it out
    _reports: Reports
    _retained: dict[str, Any]
    _saved: Callable[[], bool]

    def __init_subclass__(cls) -> None:
        """Collect the handlers: those of the bases, then the class' own."""
        own: dict[Key, str] = {}
        for name, member in vars(cls).items():
            for key in getattr(member, "handles", ()):
                if key in own:
                    raise PlcError(
                        catalogue.PLC_TWO_HANDLERS,
                        program=cls.__name__,
                        first=own[key],
                        second=name,
                        function=_spell(key),
                    )
                own[key] = name
        cls.handlers = {key: name for base in reversed(cls.__bases__) for key, name in _handlers_of(base).items()} | own

    # ------------------------------------------------------------------ what the user writes

    def setup(self) -> None:
        """Called once before the first cycle."""

    def cycle(self) -> None:
        """Called in every PLC cycle, after the handlers."""

    def on_reset(self) -> None:
        """A channel reset has withdrawn the technology functions that were under way."""

    # ------------------------------------------------------------------ what the user calls

    @property
    def channel(self) -> ChannelPort:
        """The first channel."""
        return self.channels[0]

    def alarm(self, text: str, *, acknowledge: bool = False) -> None:
        """An alarm stands as long as this is called in every cycle; the history gets one line. It stops nothing by
        itself. With `acknowledge` it stands on until `acknowledge_alarms` or a reset as well."""
        self._reports.report(catalogue.PLC_ALARM, text, acknowledge=acknowledge)

    def warning(self, text: str) -> None:
        """The same as a warning."""
        self._reports.report(catalogue.PLC_WARNING, text)

    def message(self, text: str) -> None:
        """The same as a message."""
        self._reports.report(catalogue.PLC_MESSAGE, text)

    def acknowledge_alarms(self) -> None:
        """The operator has seen them: those whose cause is gone go."""
        self._reports.acknowledge()

    @property
    def alarms(self) -> list[str]:
        """Texts of the alarms, warnings and messages that stand."""
        return self._reports.standing

    @property
    def unacknowledged(self) -> list[str]:
        """Texts of the alarms that wait for an acknowledgement."""
        return self._reports.unacknowledged

    @property
    def alarm_history(self) -> tuple[AlarmChange, ...]:
        """What came, went and was acknowledged since the start of the PLC, oldest first."""
        return tuple(self._reports.history)

    @property
    def retained_saved(self) -> bool:
        """What the cycles before have done to retained variables is on the disk; a power loss cannot take it back."""
        return self._saved()

    # ------------------------------------------------------------------ steps of a sequence (handlers that are
    # generators)

    def wait(self, seconds: float) -> Iterator[None]:
        """`yield from self.wait(0.1)`: go on after this time."""
        end_ns = now_ns() + round(seconds * 1e9)
        while now_ns() < end_ns:
            yield

    def until(self, condition: Callable[[], bool], seconds: float, alarm: str) -> Iterator[None]:
        """`yield from self.until(lambda: self.io.tool_unlocked, 2.0, "tool does not unlock")`: go on when the condition
        holds; if that takes longer than `seconds`, the alarm stands until it does."""
        end_ns = now_ns() + round(seconds * 1e9)
        while not condition():
            if now_ns() >= end_ns:
                self.alarm(alarm)
            yield


def _handlers_of(base: type) -> dict[Key, str]:
    return base.handlers if issubclass(base, Program) else {}


def _spell(key: Key) -> str:
    kind, number = key
    return f"{Kind(kind).name}{'' if number is None else number}"
