"""An external tool management: who asks for tools and who has them, over the interface.

    decoder                              unit                          PLC program
    ask: request, flag := 1              ─────▶  waits
                                                 taken        ◀─────   take: copies, flag := 0
    poll: answer, flag := 0              ◀─────  answered     ◀─────   give or refuse: answer, flag := 1

Only a request for data is answered. An answer carries the number of its request: one that comes after a reset, or after the time
to answer is over, is thrown away. Values here are mm, degrees, rev/min and degrees/s^2.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntEnum

from runtime.hli.layout import Channel, ToolData, ToolIdentity, ToolLifeReport
from runtime.hli.memory import get_text, put_text
from runtime.hli.units import INT32, LENGTH, REV_PER_MIN, to_int32

REPORTS = 16  # of tool life, that wait for the PLC
_MASK = 0xFFFFFFFF


class RequestKind(IntEnum):
    DATA = 1  # answered by the data of the tool, or a refusal
    PREPARE = 2  # it comes next
    SAVE = 3  # its free values have changed


@dataclass(frozen=True, slots=True)
class Identity:
    """What names a tool; 0 stands for no sister and no variant."""

    basic: int
    sister: int = 0
    variant: int = 0


@dataclass(frozen=True, slots=True)
class ManagedTool:
    """The data of a tool as the management gives them."""

    id: Identity
    radius: float = 0.0
    length: float = 0.0
    offsets: Sequence[float] = ()  # by channel index of the axis
    valid: bool = True
    type: int = 0
    sub_type: int = 0
    cutter_position: int = 0
    tool_fixed: bool = False
    kin_id: int = 0
    spindle: int = 0
    min_speed: float = 0.0
    max_speed: float = 0.0
    max_acceleration: float = 0.0
    parameters: Sequence[float] = ()
    kin_parameters: Sequence[float] = ()


@dataclass(frozen=True, slots=True)
class ToolAnswered:
    """What came to a request: the tool, or why it is refused."""

    tool: ManagedTool | None
    reason: str = ""


@dataclass(slots=True)
class _Asked:
    kind: RequestKind
    id: Identity
    parameters: Sequence[float]
    sequence: int


class ToolRequests:
    """The decoder's side of one channel. Bounded: an announcement replaces one that nobody has taken."""

    def __init__(self, channel: Channel) -> None:
        self._channel = channel
        self._unit = channel.tool_management
        self._waiting: deque[_Asked] = deque()
        self._sequence = int(self._unit.request_r.sequence)
        self._answer: tuple[int, ToolAnswered] | None = None

    @property
    def present(self) -> bool:
        """A PLC is there to answer."""
        return bool(self._channel.plc_present_w)

    def ask(self, kind: RequestKind, tool: Identity, parameters: Sequence[float] = ()) -> int:
        """Ask for a tool, announce it, or hand over its free values; the number of the request."""
        if kind is RequestKind.PREPARE:
            self._waiting = deque(asked for asked in self._waiting if asked.kind is not RequestKind.PREPARE)
        self._sequence = (self._sequence + 1) & _MASK
        self._waiting.append(_Asked(kind, tool, parameters, self._sequence))
        self.hand_over()
        return self._sequence

    def hand_over(self) -> None:
        """Put the next request out if the one before has been taken."""
        unit = self._unit
        if not self.present:
            self._waiting.clear()
            unit.request_semaphor_rw = False
        if not self._waiting or unit.request_semaphor_rw:
            return
        asked = self._waiting.popleft()
        request = unit.request_r
        request.kind, request.sequence = asked.kind, asked.sequence
        _put_id(request.id, asked.id)
        _put_numbers(request.parameters, asked.parameters)
        unit.request_semaphor_rw = True

    def answered(self, number: int) -> ToolAnswered | None:
        """The answer to a request, None as long as there is none."""
        self.hand_over()
        unit = self._unit
        if unit.answer_semaphor_rw:
            answer = unit.answer_w
            told = (
                ToolAnswered(None, get_text(answer, "reason")) if answer.refused else ToolAnswered(_tool(answer.data))
            )
            self._answer = (int(answer.sequence), told)
            unit.answer_semaphor_rw = False
        if self._answer is None or self._answer[0] != number:
            return None
        return self._answer[1]

    def forget(self) -> None:
        """Withdraw what was not taken: the program is over."""
        self._waiting.clear()
        self._unit.request_semaphor_rw = False


@dataclass(slots=True)
class ToolOrder:
    """A request as the PLC program finds it."""

    kind: RequestKind
    id: Identity
    parameters: list[float]
    sequence: int


class ToolStore:
    """The PLC's side of one channel: takes requests and answers them."""

    def __init__(self, channel: Channel) -> None:
        self._unit = channel.tool_management
        self._life = channel.tool_life

    def take(self) -> ToolOrder | None:
        """The request that waits; None if there is none, or it was withdrawn while it was read."""
        unit = self._unit
        if not unit.request_semaphor_rw:
            return None
        request = unit.request_r
        kind, sequence = int(request.kind), int(request.sequence)
        if kind not in tuple(RequestKind):
            unit.request_semaphor_rw = False
            return None
        order = ToolOrder(RequestKind(kind), _id(request.id), list(request.parameters), sequence)
        if not unit.request_semaphor_rw or request.sequence != sequence:
            return None
        unit.request_semaphor_rw = False
        return order

    def give(self, order: ToolOrder, tool: ManagedTool) -> None:
        """Answer a request for data."""
        answer = self._unit.answer_w
        _put_tool(answer.data, tool)
        answer.refused = False
        self._answer(order)

    def refuse(self, order: ToolOrder, reason: str) -> None:
        """The tool cannot be had: the program ends with this reason."""
        put_text(self._unit.answer_w, "reason", reason)
        self._unit.answer_w.refused = True
        self._answer(order)

    def _answer(self, order: ToolOrder) -> None:
        self._unit.answer_w.sequence = order.sequence
        self._unit.answer_semaphor_rw = True

    def take_life(self) -> ToolLife | None:
        """The report of tool life that waits."""
        unit = self._life
        if not unit.report_semaphor_rw:
            return None
        report = unit.report_r
        life = ToolLife(_id(report.id), report.time_ms / 1000.0, report.distance * LENGTH)
        unit.report_semaphor_rw = False
        return life


@dataclass(frozen=True, slots=True)
class ToolLife:
    """How long (s) and how far (mm) a tool was in use since the report before."""

    id: Identity
    time: float
    distance: float


@dataclass(slots=True)
class ToolLifePort:
    """The cycle's side: reports one after the other; `lost` are those that found no room."""

    channel: Channel
    lost: int = 0
    _waiting: deque[ToolLife] = field(default_factory=deque)
    _sequence: int = 0

    def put(self, life: ToolLife) -> None:
        """Report; without a PLC nobody wants to know."""
        if not self.channel.plc_present_w:
            return
        if len(self._waiting) >= REPORTS:
            self.lost += 1
            return
        self._waiting.append(life)

    def step(self) -> None:
        """Once per cycle: hand over the next report."""
        if not self._waiting:
            return
        unit = self.channel.tool_life
        if unit.report_semaphor_rw:
            if not self.channel.plc_present_w:
                self._waiting.clear()
                unit.report_semaphor_rw = False
            return
        life = self._waiting.popleft()
        report: ToolLifeReport = unit.report_r
        _put_id(report.id, life.id)
        report.time_ms = min(round(life.time * 1000.0), _MASK)
        report.distance = round(life.distance / LENGTH)
        self._sequence = (self._sequence + 1) & _MASK
        report.sequence = self._sequence
        unit.report_semaphor_rw = True


# ---------------------------------------------------------------------------------------------------- whole numbers


def _put_id(target: ToolIdentity, tool: Identity) -> None:
    target.basic, target.sister, target.variant = tool.basic, tool.sister, tool.variant
    target.sister_valid, target.variant_valid = tool.sister != 0, tool.variant != 0


def _id(source: ToolIdentity) -> Identity:
    sister = int(source.sister) if source.sister_valid else 0
    return Identity(int(source.basic), sister, int(source.variant) if source.variant_valid else 0)


def _put_numbers(target: Sequence[float], values: Sequence[float]) -> None:
    for i in range(len(target)):
        target[i] = values[i] if i < len(values) else 0.0  # type: ignore[index]


def _put_tool(data: ToolData, tool: ManagedTool) -> None:
    _put_id(data.id, tool.id)
    data.valid, data.tool_fixed, data.type, data.sub_type = tool.valid, tool.tool_fixed, tool.type, tool.sub_type
    data.cutter_position, data.kin_id, data.spindle = tool.cutter_position, tool.kin_id, tool.spindle
    data.radius, data.length = to_int32(tool.radius, LENGTH), to_int32(tool.length, LENGTH)
    for i in range(len(data.offsets)):
        data.offsets[i] = to_int32(tool.offsets[i], LENGTH) if i < len(tool.offsets) else 0
    data.min_speed, data.max_speed = to_int32(tool.min_speed, REV_PER_MIN), to_int32(tool.max_speed, REV_PER_MIN)
    data.max_acceleration = min(max(round(tool.max_acceleration), 0), INT32)
    _put_numbers(data.parameters, tool.parameters)
    _put_numbers(data.kin_parameters, tool.kin_parameters)


def _tool(data: ToolData) -> ManagedTool:
    return ManagedTool(
        id=_id(data.id),
        radius=data.radius * LENGTH,
        length=data.length * LENGTH,
        offsets=tuple(offset * LENGTH for offset in data.offsets),
        valid=bool(data.valid),
        type=int(data.type),
        sub_type=int(data.sub_type),
        cutter_position=int(data.cutter_position),
        tool_fixed=bool(data.tool_fixed),
        kin_id=int(data.kin_id),
        spindle=int(data.spindle),
        min_speed=data.min_speed * REV_PER_MIN,
        max_speed=data.max_speed * REV_PER_MIN,
        max_acceleration=float(data.max_acceleration),
        parameters=tuple(data.parameters),
        kin_parameters=tuple(data.kin_parameters),
    )
