"""What the jobs of a block mean: values in mm, degrees and seconds, and where the path waits for them (manual, line 25484).

Internal units, or those of P-CHAN-00182, always metric:

                   internal                        P-CHAN-00182 = 1
    position       0.1 µm, 0.0001 degrees          mm, degrees
    velocity       µm/s, 0.001 degrees/s           mm/s, degrees/s
    acceleration   mm/s², degrees/s²               the same
    jerk           mm/s³, degrees/s³               the same
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from runtime.cnc.blocks import AxisJob, AxisJobWait
from runtime.cnc.decoder.isg.registry import STATEMENTS, StatementCall
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import CompiledBlock, Values
from runtime.cnc.language.isg.functions import round_half_up
from runtime.diagnostics.catalogue import axis_jobs as errors
from runtime.hli.axis_jobs import Job
from runtime.hli.layout import AxisFunction, Direction
from runtime.hli.units import LENGTH, SPEED

if TYPE_CHECKING:
    from runtime.cnc.decoder.execution import Execution

ID_LIMIT = 2**31 - 1
_WAITS = ("WAITSYN", "WAIT_SYN")
_POSITION_LIMIT = (2**31 - 1) * LENGTH  # what the interface of the axis can show
_VALUE_LIMIT = 1e12


def give_jobs(x: Execution, block: CompiledBlock, values: Values) -> None:
    """The jobs of a block, in front of its motion. Raises LineError."""
    x.block_waits_for_jobs = False
    for slots in block.jobs:
        STATEMENTS[slots.statement.syntax.name].handler(x, StatementCall(slots, values))


def wait_for_jobs(x: Execution) -> None:
    """At the end of a block the path waits for the jobs that are marked so (WaitSyn, P-CHAN-00359)."""
    if x.block_waits_for_jobs:
        x.emit(AxisJobWait(x.source))


def wait_for_id(x: Execution, number: float, column: int) -> None:
    """#WAIT MC_STATUS: for the job that was programmed last with this id. Raises LineError."""
    if number not in x.job_ids:
        raise LineError(errors.JOB_ID, column, id=f"{number:.9g}")
    x.emit(AxisJobWait(x.source, round_half_up(number)))


class JobCall:
    """A job as it is written, on its way into the stream; every value is checked. Raises LineError."""

    def __init__(self, x: Execution, call: StatementCall, function: str) -> None:
        self._x, self._call, self._function = x, call, function
        argument = call.argument("AX")
        assert argument is not None
        self.axis = x.setup.other_axes[argument.index]
        self._length = 1.0 if x.setup.job_units else LENGTH
        self._speed = 1.0 if x.setup.job_units else SPEED

    def put_out(self, function: AxisFunction, **values: float | int | Direction) -> None:
        """The job with its dynamics, at this place of the path."""
        x, call = self._x, self._call
        job = Job(
            function,
            acceleration=self._dynamic("ACCELERATION"),
            deceleration=self._dynamic("DECELERATION"),
            jerk=self._dynamic("JERK"),
            **values,  # type: ignore[arg-type]
        )
        number = -1
        if call.given("ID"):
            number = self.whole("ID", range(ID_LIMIT + 1), f"a whole number from 0 to {ID_LIMIT}")
            x.job_ids.add(number)
        waits = x.setup.jobs_wait or any(call.given(key) for key in _WAITS)
        x.block_waits_for_jobs |= waits
        x.emit(AxisJob(x.source, self.axis.index, job, number, waits))

    def way(self, key: str) -> float:
        """A position, distance or phase in mm or degrees."""
        value = self._number(key)
        if not abs(value * self._length) <= _POSITION_LIMIT:
            raise self.error(key, value, f"at most {_POSITION_LIMIT / self._length:.9g} in either direction")
        return value * self._length

    def velocity(self, key: str = "VELOCITY") -> float:
        """In mm/s or degrees/s."""
        value = self._number(key)
        if not 0.0 < value <= _VALUE_LIMIT:
            raise self.error(key, value, "above 0")
        return value * self._speed

    def direction(self, *allowed: Direction) -> Direction:
        """One of the directions that the job knows."""
        shown = ", ".join(f"{direction.value} ({direction.name.lower()})" for direction in allowed)
        return Direction(self.whole("DIRECTION", allowed, shown))

    def whole(self, key: str, allowed: range | tuple[int, ...], shown: str) -> int:
        """A whole number of those that are allowed."""
        value = self._number(key)
        if value != math.floor(value) or int(value) not in allowed:
            raise self.error(key, value, shown)
        return int(value)

    def ratio(self, key: str, short: str, *, zero: bool) -> float:
        """Numerator or denominator, by its long or its short name."""
        given = [name for name in (key, short) if self._call.given(name)]
        if len(given) != 1:
            what = f"{key} or {short}"
            raise self._call.error(errors.JOB_RATIO, function=self._function, what=what)
        value = self._number(given[0])
        if not abs(value) <= _VALUE_LIMIT or (value == 0.0 and not zero):
            raise self.error(given[0], value, "a number" if zero else "not 0")
        return value

    def master(self) -> int:
        """Logical number of the axis that is followed."""
        setup = self._x.setup
        numbers = dict(zip(setup.axes, setup.log_axes, strict=False))
        numbers |= {axis.name: axis.log_axis for axis in setup.other_axes}
        argument = self._call.argument("MASTER")
        assert argument is not None
        if argument.value is None:
            number = numbers.get(argument.text, 0)
        else:
            number = self.whole("MASTER", tuple(numbers.values()), self._known(numbers))
        if number == self.axis.log_axis:
            raise self.error("MASTER", number, "another axis than the slave")
        return number

    def _known(self, numbers: dict[str, int]) -> str:
        return ", ".join(f"{number} ({name})" for name, number in numbers.items())

    def _dynamic(self, key: str) -> float | None:
        """An acceleration or jerk; not above 0 is that of the axis."""
        value = self._call.number(key)
        if value is None or value <= 0.0:
            return None
        if not value <= _VALUE_LIMIT:
            raise self.error(key, value, f"at most {_VALUE_LIMIT:g}")
        return value

    def _number(self, key: str) -> float:
        return self._call.needed(key)

    def error(self, key: str, value: float, allowed: str) -> LineError:
        """A value that the job does not take."""
        return self._call.error(
            errors.JOB_INPUT, key, function=self._function, key=key.title(), value=value, range=allowed
        )

    def given(self, key: str) -> bool:
        """The job has this input."""
        return self._call.given(key)
