"""PLCopen jobs of axes outside of the channel, and waiting for them (programming manual 25484–25993).

A job is a row of `_JOBS`: how it is written, and what of the job each input is. `cnc/decoder/axis_jobs.py` reads the values.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from runtime.cnc.decoder.axis_jobs import JobCall, wait_for_id
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, StatementHandler, statement, variable
from runtime.cnc.language.isg.job_brackets import job_name
from runtime.cnc.language.isg.syntax import Form, Key, KeyKind
from runtime.diagnostics.catalogue import language as catalogue
from runtime.hli.layout import AxisFunction, Direction

_SYNCH = (Key("ID"), Key("WAITSYN", KeyKind.FLAG), Key("WAIT_SYN", KeyKind.FLAG))
_ACTUAL_VALUES, _PHASE_COMPENSATION = 128, 256
_MODES = (0, _ACTUAL_VALUES, _PHASE_COMPENSATION, _ACTUAL_VALUES | _PHASE_COMPENSATION)
_FALLING, _RISING = 1, 2

_Read = Callable[[JobCall, str], float | int | Direction]


@dataclass(frozen=True, slots=True)
class _Input:
    """`name` as the manual writes it, `field` of the job; `read` None: the dynamics, which every job has."""

    name: str
    field: str
    read: _Read | None = None
    needed: bool = True
    short: str = ""  # another name
    kind: KeyKind = KeyKind.NUMBER

    @property
    def keys(self) -> tuple[Key, ...]:
        if self.short:  # one of the two is needed: `read` sees to that
            return Key(self.name.upper(), self.kind), Key(self.short, self.kind)
        return (Key(self.name.upper(), self.kind, needed=self.needed),)

    @property
    def shown(self) -> str:
        return f"{self.name}=.. " if self.needed else f"[{self.name}=..] "


def _way(name: str, *, needed: bool = True) -> _Input:
    return _Input(name, "position", JobCall.way, needed)


def _speed(name: str = "Velocity") -> _Input:
    return _Input(name, "velocity", JobCall.velocity)


def _direction(*allowed: Direction) -> _Input:
    return _Input("Direction", "direction", lambda job, _: job.direction(*allowed))


def _master() -> _Input:
    return _Input("Master", "master", lambda job, _: job.master(), kind=KeyKind.MACHINE_AXIS)


def _ratio(name: str, field: str, short: str, *, zero: bool) -> _Input:
    return _Input(name, field, lambda job, key: job.ratio(key, short, zero=zero), short=short)


def _gear_mode(job: JobCall, key: str) -> int:
    mode = job.whole(key, _MODES, "0, 128 (actual values), with 256 beside it for automatic phase compensation")
    if job.given("PHASESHIFT") and not mode & _PHASE_COMPENSATION:
        raise job.error("PHASESHIFT", job.way("PHASESHIFT"), "given with automatic phase compensation (mode 256) only")
    return mode


_SLOWING = (_Input("Deceleration", "", needed=False), _Input("Jerk", "", needed=False))
_DYNAMICS = (_Input("Acceleration", "", needed=False), *_SLOWING)


@dataclass(frozen=True, slots=True)
class _Job:
    name: str
    function: AxisFunction
    inputs: tuple[_Input, ...]
    does: str


_JOBS = (
    _Job("MC_Home", AxisFunction.HOME, (), "Homing, as it is configured for the axis."),
    _Job(
        "MC_MoveAbsolute",
        AxisFunction.MOVE_ABSOLUTE,
        (_way("Position"), _speed(), *_DYNAMICS, _direction(*Direction)),
        "Moves to a position; direction 1 positive, 2 shortest, 3 negative, 4 current.",
    ),
    _Job(
        "MC_MoveAdditive",
        AxisFunction.MOVE_ADDITIVE,
        (_way("Distance"), _speed(), *_DYNAMICS),
        "Moves by a distance from the target of the job under way.",
    ),
    _Job(
        "MC_MoveRelative",
        AxisFunction.MOVE_RELATIVE,
        (_way("Distance"), _speed(), *_DYNAMICS),
        "Moves by a distance from where the axis is.",
    ),
    _Job(
        "MC_MoveSuperImposed",
        AxisFunction.MOVE_SUPERIMPOSED,
        (_way("Distance"), _speed("VelocityDiff"), *_DYNAMICS),
        "Moves by a distance on top of the motion under way.",
    ),
    _Job(
        "MC_MoveVelocity",
        AxisFunction.MOVE_VELOCITY,
        (_speed(), *_DYNAMICS, _direction(Direction.POSITIVE, Direction.NEGATIVE, Direction.CURRENT)),
        "Moves without end; direction 1 positive, 3 negative, 4 current.",
    ),
    _Job("MC_Stop", AxisFunction.STOP, _SLOWING, "Brings the axis to rest, whatever moves it."),
    _Job(
        "MC_GearIn",
        AxisFunction.GEAR_IN,
        (
            _master(),
            _ratio("RatioNumerator", "numerator", "RN", zero=True),
            _ratio("RatioDenominator", "denominator", "RD", zero=False),
            *_DYNAMICS,
            _Input("Mode", "mode", _gear_mode),
            _way("PhaseShift", needed=False),
        ),
        "Follows the velocity of a master, with a ratio; mode 0 commanded, 128 actual values, 256 beside it: and to PhaseShift "
        "beside ratio times the place of the master. RN, RD are short forms.",
    ),
    _Job("MC_GearOut", AxisFunction.GEAR_OUT, (), "Ends the gear; the axis goes on with the velocity that it has."),
    _Job(
        "MC_Phasing",
        AxisFunction.PHASING,
        (_master(), _way("PhaseShift"), _speed(), *_DYNAMICS),
        "Shifts the slave against its master, on top of the gear.",
    ),
    _Job(
        "MC_TouchProbe",
        AxisFunction.TOUCH_PROBE,
        (
            _Input("Channel", "master", lambda job, key: job.whole(key, range(1, 515), "a number from 1 to 514")),
            _Input(
                "Mode",
                "mode",
                lambda job, key: job.whole(key, (_FALLING, _RISING), "1 (falling) or 2 (rising)"),
                needed=False,
            ),
        ),
        "Records the position at the next edge of an input (513, 514: touch probe of the drive); mode 1 falling, 2 rising edge.",
    ),
)


def _handler(row: _Job) -> StatementHandler:
    """Puts a job of this kind out, with the values of its call."""
    preset = {"mode": _RISING} if row.function is AxisFunction.TOUCH_PROBE else {}

    def handler(x: Execution, call: StatementCall) -> None:
        job = JobCall(x, call, row.name)
        values: dict[str, float | int | Direction] = dict(preset)
        for given in row.inputs:
            key = given.name.upper()
            if given.read is not None and (given.needed or job.given(key)):
                values[given.field] = given.read(job, key)
        job.put_out(row.function, **values)

    handler.__doc__ = row.does
    return handler


for _row in _JOBS:
    statement(
        job_name(_row.name),
        f"isg.plcopen.{_row.name.lower().replace('_', '-')}",
        syntax=f"<axis>[{_row.name} {''.join(given.shown for given in _row.inputs)}[Id=..] [WaitSyn]]",
        form=Form.KEYS,
        keys=(*(key for given in _row.inputs for key in given.keys), *_SYNCH),
        prefix="",
    )(_handler(_row))


@statement(
    "WAIT MC_STATUS",
    "isg.plcopen.sync",
    syntax="#WAIT MC_STATUS SYN [ID=.. {ID=..}]",
    form=Form.KEYS,
    keys=(Key("ID", needed=True, many=True),),
    words=("SYN",),
)
def wait_for_jobs(x: Execution, call: StatementCall) -> None:
    """The path waits here for the jobs with these ids."""
    if not call.words():
        raise call.error(catalogue.KEY_MISSING, key="SYN", statement="#WAIT MC_STATUS", syntax=call.syntax.syntax[0])
    for argument, value in call:
        if argument.name == "ID":
            wait_for_id(x, value, argument.column)


# ---------------------------------------------------------------------------------------------------- what was probed


def _recorded(x: Execution, axis: int) -> float | None:
    return x.outside.probed(x.setup.other_axes[axis].index)


@variable(
    "V.A.MERF.<axis beside>",
    "isg.plcopen.mc-touchprobe",
    "1: the last MC_TouchProbe of the axis has its edge",
    flush=True,
)
def probe_is_done(x: Execution, axis: int) -> float:
    return float(_recorded(x, axis) is not None)


@variable(
    "V.A.MEAS.ACS.VALUE.<axis beside>",
    "isg.plcopen.mc-touchprobe",
    "its position, 0 without",
    unit="mm, deg",
    flush=True,
)
def probed_position(x: Execution, axis: int) -> float:
    return _recorded(x, axis) or 0.0
