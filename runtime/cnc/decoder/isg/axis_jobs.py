"""PLCopen jobs of axes outside of the channel, and waiting for them (programming manual 25484–25993)."""

from __future__ import annotations

from collections.abc import Callable

from runtime.cnc.decoder.axis_jobs import JobCall, wait_for_id
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, StatementHandler, statement
from runtime.cnc.language.isg.job_brackets import job_name
from runtime.cnc.language.isg.syntax import Form, Key, KeyKind
from runtime.diagnostics.catalogue import language as catalogue
from runtime.hli.layout import AxisFunction, Direction

_SLOWING = (Key("DECELERATION"), Key("JERK"))
_DYNAMICS = (Key("ACCELERATION"), *_SLOWING)
_DYNAMICS_TEXT = "[Acceleration=..] [Deceleration=..] [Jerk=..] "
_SYNCH = (Key("ID"), Key("WAITSYN", KeyKind.FLAG), Key("WAIT_SYN", KeyKind.FLAG))
_ACTUAL_VALUES = 128
_PHASE_COMPENSATION = 256
_ANY_WAY = tuple(Direction)


def _job(
    function: str, spec: str, inputs: str, keys: tuple[Key, ...]
) -> Callable[[Callable[[JobCall], None]], StatementHandler]:
    """Register a job; `inputs` as the reference shows them."""
    name = job_name(function)

    def register(put_out: Callable[[JobCall], None]) -> StatementHandler:
        def handler(x: Execution, call: StatementCall) -> None:
            put_out(JobCall(x, call, function))

        handler.__doc__ = put_out.__doc__
        shown = " ".join(f"<axis>[{function} {inputs}[Id=..] [WaitSyn]]".split())
        return statement(name, spec, syntax=shown, form=Form.KEYS, keys=(*keys, *_SYNCH), prefix="")(handler)

    return register


@_job("MC_Home", "isg.plcopen.mc-home", "", ())
def home(job: JobCall) -> None:
    """Homing, as it is configured for the axis."""
    job.put_out(AxisFunction.HOME)


@_job(
    "MC_MoveAbsolute",
    "isg.plcopen.mc-moveabsolute",
    f"Position=.. Velocity=.. {_DYNAMICS_TEXT} Direction=.. ",
    (Key("POSITION", needed=True), Key("VELOCITY", needed=True), *_DYNAMICS, Key("DIRECTION", needed=True)),
)
def move_absolute(job: JobCall) -> None:
    """Moves to a position; direction 1 positive, 2 shortest, 3 negative, 4 current."""
    job.put_out(
        AxisFunction.MOVE_ABSOLUTE,
        position=job.way("POSITION"),
        velocity=job.velocity(),
        direction=job.direction(*_ANY_WAY),
    )


_DISTANCE = (Key("DISTANCE", needed=True), Key("VELOCITY", needed=True), *_DYNAMICS)


@_job("MC_MoveAdditive", "isg.plcopen.mc-moveadditive", f"Distance=.. Velocity=.. {_DYNAMICS_TEXT}", _DISTANCE)
def move_additive(job: JobCall) -> None:
    """Moves by a distance from the target of the job under way."""
    job.put_out(AxisFunction.MOVE_ADDITIVE, position=job.way("DISTANCE"), velocity=job.velocity())


@_job("MC_MoveRelative", "isg.plcopen.mc-moverelative", f"Distance=.. Velocity=.. {_DYNAMICS_TEXT}", _DISTANCE)
def move_relative(job: JobCall) -> None:
    """Moves by a distance from where the axis is."""
    job.put_out(AxisFunction.MOVE_RELATIVE, position=job.way("DISTANCE"), velocity=job.velocity())


@_job(
    "MC_MoveSuperImposed",
    "isg.plcopen.mc-movesuperimposed",
    f"Distance=.. VelocityDiff=.. {_DYNAMICS_TEXT}",
    (Key("DISTANCE", needed=True), Key("VELOCITYDIFF", needed=True), *_DYNAMICS),
)
def move_superimposed(job: JobCall) -> None:
    """Moves by a distance on top of the motion under way."""
    job.put_out(AxisFunction.MOVE_SUPERIMPOSED, position=job.way("DISTANCE"), velocity=job.velocity("VELOCITYDIFF"))


@_job(
    "MC_MoveVelocity",
    "isg.plcopen.mc-movevelocity",
    f"Velocity=.. {_DYNAMICS_TEXT} Direction=.. ",
    (Key("VELOCITY", needed=True), *_DYNAMICS, Key("DIRECTION", needed=True)),
)
def move_velocity(job: JobCall) -> None:
    """Moves without end; direction 1 positive, 3 negative, 4 current."""
    direction = job.direction(Direction.POSITIVE, Direction.NEGATIVE, Direction.CURRENT)
    job.put_out(AxisFunction.MOVE_VELOCITY, velocity=job.velocity(), direction=direction)


@_job("MC_Stop", "isg.plcopen.mc-stop", "[Deceleration=..] [Jerk=..] ", _SLOWING)
def stop(job: JobCall) -> None:
    """Brings the axis to rest, whatever moves it."""
    job.put_out(AxisFunction.STOP)


@_job(
    "MC_GearIn",
    "isg.plcopen.mc-gearin",
    f"Master=.. RatioNumerator=.. RatioDenominator=.. {_DYNAMICS_TEXT} Mode=.. [PhaseShift=..] ",
    (
        Key("MASTER", KeyKind.MACHINE_AXIS, needed=True),
        *(Key(name) for name in ("RATIONUMERATOR", "RATIODENOMINATOR", "RN", "RD", "PHASESHIFT")),
        *_DYNAMICS,
        Key("MODE", needed=True),
    ),
)
def gear_in(job: JobCall) -> None:
    """Follows the velocity of a master, with a ratio; mode 0 commanded, 128 actual values. RN, RD are short forms."""
    mode = job.whole("MODE", range(512), "0 or 128")
    if mode & _PHASE_COMPENSATION:
        raise job.unsupported(
            "MODE", "automatic phase compensation (mode 256) of MC_GearIn", "bring the axes into phase before"
        )
    if mode not in (0, _ACTUAL_VALUES):
        raise job.error("MODE", mode, "0 or 128")
    job.put_out(
        AxisFunction.GEAR_IN,
        master=job.master(),
        numerator=job.ratio("RATIONUMERATOR", "RN", zero=True),
        denominator=job.ratio("RATIODENOMINATOR", "RD", zero=False),
        mode=mode,
    )


@_job("MC_GearOut", "isg.plcopen.mc-gearout", "", ())
def gear_out(job: JobCall) -> None:
    """Ends the gear; the axis goes on with the velocity that it has."""
    job.put_out(AxisFunction.GEAR_OUT)


@_job(
    "MC_Phasing",
    "isg.plcopen.mc-phasing",
    f"Master=.. PhaseShift=.. Velocity=.. {_DYNAMICS_TEXT}",
    (
        Key("MASTER", KeyKind.MACHINE_AXIS, needed=True),
        Key("PHASESHIFT", needed=True),
        Key("VELOCITY", needed=True),
        *_DYNAMICS,
    ),
)
def phasing(job: JobCall) -> None:
    """Shifts the slave against its master, on top of the gear."""
    job.put_out(AxisFunction.PHASING, master=job.master(), position=job.way("PHASESHIFT"), velocity=job.velocity())


@_job(
    "MC_TouchProbe",
    "isg.plcopen.mc-touchprobe",
    "Channel=.. [Mode=..] ",
    (Key("CHANNEL", needed=True), Key("MODE")),
)
def touch_probe(job: JobCall) -> None:
    """Not available in this version."""
    raise job.unsupported(
        "CHANNEL",
        "MC_TouchProbe of a program",
        "let the PLC program probe (MC_TouchProbe) and tell the position in V.E",
    )


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
