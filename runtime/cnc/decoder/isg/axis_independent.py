"""<axis>[INDP_SYN ..], <axis>[INDP_ASYN ..] and #WAIT INDP: axes of the channel that move by themselves (manual 29533–29772)."""

from __future__ import annotations

import math

from runtime.cnc.blocks import IndependentMotion, Technology
from runtime.cnc.decoder.additions import expect_no_line
from runtime.cnc.decoder.couplings import expect_uncoupled
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.independent import ALLOWED, EXACT_AT_WAIT, speed_for, wait_for
from runtime.cnc.decoder.isg.axis_commands import axis_command
from runtime.cnc.decoder.isg.registry import StatementCall, statement
from runtime.cnc.decoder.modal import Motion
from runtime.cnc.decoder.modulo import modulo_end
from runtime.cnc.decoder.motion import POSITION_LIMIT
from runtime.cnc.decoder.own_motions import OwnFunction, OwnMotion
from runtime.cnc.decoder.radius_compensation import expect_none
from runtime.cnc.decoder.setup import AxisDynamics
from runtime.cnc.decoder.systems import expect_unrotated
from runtime.cnc.dynamic_settings import Slope
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.syntax import Form, Key, KeyKind
from runtime.diagnostics.catalogue import axes as errors
from runtime.diagnostics.catalogue import language as catalogue

_MOST = 1e9  # mm/s and so on: as much as the axis can
_SPEEDS = ("FEED", "TIME", "FEED_MAX_WEIGHT")
_UNSUPPORTED = {
    "G100": "a measuring run of an own motion",
    "DRY_RUN": "the dry run of an own motion",
}
_SLOPES = tuple(slope.name for slope in Slope)
_SIN2 = 2.0 / math.pi  # of its greatest jerk is the mean of a sin² ramp
_KEYS = (
    *(Key(name, KeyKind.FLAG) for name in ("G90", "G91", "G00", "G0", "G01", "G1", "INCL_OFFSETS", "G100", "DRY_RUN")),
    *(Key(name) for name in ("POS", *_SPEEDS, "ACC_WEIGHT", "RAPID_ACC_WEIGHT", "SLOPE_PROFIL")),
    Key("SLOPE_TYPE", KeyKind.WORD, words=_SLOPES),
    Key("M", many=True),
    Key("H", many=True),
)
_SYNTAX = (
    "[G90|G91] [G00|G01] POS=.. [FEED=..|TIME=..|FEED_MAX_WEIGHT=..] [ACC_WEIGHT=..] [RAPID_ACC_WEIGHT=..] "
    "[SLOPE_TYPE=..] [INCL_OFFSETS] [M..] [H..]"
)


def _own_motion(keyword: str, spec: str, *, waits: bool) -> None:
    @axis_command(
        keyword,
        spec,
        "isg.posax.general-restrictions",
        "isg.posax.indp-mh",
        "isg.posax.indp-incl-offsets",
        syntax=(f"{keyword} {_SYNTAX}",),
        keys=_KEYS,
        alone=False,
    )
    def command(x: Execution, call: StatementCall, axis: int) -> None:
        """POS is a machine position without offsets, unless INCL_OFFSETS asks for them."""
        for key, what in _UNSUPPORTED.items():
            if call.given(key):
                raise call.error(errors.INDEPENDENT_UNSUPPORTED, key, what=what)
        if any(one.axis == axis for one in x.independent.of_block) or axis in x.axis_words:
            raise call.error(catalogue.WORD_TWICE, address=x.setup.axes[axis])
        moves = call.given("POS")
        motion = _motion(x, call, axis) if moves else None
        if not moves and any(call.given(key) for key in _SPEEDS):
            raise call.error(
                catalogue.KEY_MISSING, key="POS", statement=f"<axis>[{keyword}]", syntax=call.syntax.syntax[0]
            )
        functions = _functions(x, call, asynchronous_motion=moves and not waits)
        if motion is None and not functions:
            raise call.error(
                catalogue.KEY_MISSING, key="POS", statement=f"<axis>[{keyword}]", syntax=call.syntax.syntax[0]
            )
        x.independent.of_block.append(OwnMotion(axis, call.column, motion, waits, functions))


_own_motion("INDP_SYN", "isg.posax.indp-syn", waits=True)
_own_motion("INDP_ASYN", "isg.posax.indp-asyn", waits=False)


def _motion(x: Execution, call: StatementCall, axis: int) -> IndependentMotion:
    """The motion, with target and dynamics in machine units. The axis rests where the decoder has it, or is waited for."""
    name = x.setup.axes[axis]
    expect_none(x, f"{name}[INDP_..]", call.column)
    expect_no_line(x)
    expect_unrotated(x, axis, "an own motion", call.column)
    expect_uncoupled(x, f"{name}[INDP_..]", call.column)
    if x.modal.contouring or x.smoothing.spline_on or x.smoothing.hsc_on:
        raise call.error(errors.INDEPENDENT_BARRED, axis=name, what="contouring, splines or HSC are selected")
    wait_for(x, [axis])
    place = x.coordinates.position[axis]
    target = _target(x, call, axis, place)
    if not abs(target) <= POSITION_LIMIT and axis not in x.modulo.ranges:
        raise call.error(catalogue.POSITION_RANGE, "POS", value=target, axis=name, limit=POSITION_LIMIT)
    return IndependentMotion(x.source, axis, target, *_dynamics(x, call, axis, place, target))


def _one_of(call: StatementCall, first: tuple[str, ...], second: tuple[str, ...], default: bool) -> bool:
    """Whether a key of the second kind holds. Raises LineError where both do."""
    a, b = (any(call.given(key) for key in keys) for keys in (first, second))
    if a and b:
        raise call.error(catalogue.KEY_TWICE, second[0], key=f"{first[0]}, {second[0]}", statement="<axis>[INDP_..]")
    return b if a or b else default


def _target(x: Execution, call: StatementCall, axis: int, place: float) -> float:
    value = x.axis_value(axis, call.needed("POS"))
    c = x.coordinates
    with_offsets = call.given("INCL_OFFSETS")
    if _one_of(call, ("G90",), ("G91",), x.modal.incremental):
        return place + value * (c.gain[axis] if with_offsets else 1.0)
    end = value * c.gain[axis] + c.shift[axis] if with_offsets else value + c.turns[axis]
    return modulo_end(place, end, x.modulo.size(axis), 0) if axis in x.modulo.ranges else end


def _dynamics(x: Execution, call: StatementCall, axis: int, place: float, target: float) -> tuple[float, float, float]:
    """Velocity, acceleration and jerk, in mm or degrees, and seconds."""
    name = x.setup.axes[axis]
    given = [key for key in _SPEEDS if call.given(key)]
    if len(given) > 1:
        raise call.error(catalogue.KEY_TWICE, given[1], key=", ".join(given), statement="<axis>[INDP_..]")
    rapid = not _one_of(call, ("G00", "G0"), ("G01", "G1"), bool(given) or x.modal.motion is not Motion.RAPID)
    limits = x.setup.axis_dynamics
    can = limits[axis] if limits else AxisDynamics(_MOST, _MOST, _MOST)
    weight = call.number("RAPID_ACC_WEIGHT" if rapid else "ACC_WEIGHT", 100.0)
    assert weight is not None
    if not 0.0 < weight <= 100.0:
        key = "RAPID_ACC_WEIGHT" if rapid else "ACC_WEIGHT"
        raise call.error(
            errors.INDEPENDENT_VALUE, key, axis=name, key=key, value=weight, allowed="above 0, at most 100"
        )
    share = weight / 100.0
    can = AxisDynamics(can.velocity, can.acceleration * share, can.jerk * share * _jerk_share(x, call, name))
    velocity = can.velocity
    if not rapid and not given:
        raise call.error(errors.INDEPENDENT_FEED, axis=name)
    if given and not rapid:
        velocity = _velocity(x, call, axis, given[0], can, place, target)
    return min(velocity, can.velocity), can.acceleration, can.jerk


def _jerk_share(x: Execution, call: StatementCall, name: str) -> float:
    """What a slope leaves of the jerk; without one that of the channel holds (P-CHAN-00071). None exceeds what the axis can."""
    slope, number = x.setup.dynamics.slope, call.number("SLOPE_PROFIL")
    if number is not None:
        if number not in list(Slope):
            raise call.error(
                errors.INDEPENDENT_VALUE, "SLOPE_PROFIL", axis=name, key="SLOPE_PROFIL", value=number, allowed="0 to 3"
            )
        slope = Slope(int(number))
    if call.given("SLOPE_TYPE"):
        slope = Slope[call.text("SLOPE_TYPE") or ""]
    return _SIN2 if slope is Slope.SIN2 else 1.0


def _velocity(
    x: Execution, call: StatementCall, axis: int, key: str, can: AxisDynamics, place: float, target: float
) -> float:
    value = call.needed(key)
    top = 100.0 if key == "FEED_MAX_WEIGHT" else math.inf
    if not 0.0 < value < top:
        allowed = "above 0 and below 100" if key == "FEED_MAX_WEIGHT" else "above 0"
        raise call.error(errors.INDEPENDENT_VALUE, key, axis=x.setup.axes[axis], key=key, value=value, allowed=allowed)
    if key == "FEED":
        return x.axis_value(axis, value) * (x.setup.feed_factor if x.setup.linear[axis] else 1.0) / 60.0
    if key == "FEED_MAX_WEIGHT":
        return can.velocity * value / 100.0
    return speed_for(value, abs(target - place), can)


def _functions(x: Execution, call: StatementCall, *, asynchronous_motion: bool) -> tuple[OwnFunction, ...]:
    """M and H of the bracket; only those types are allowed that have a place beside an own motion."""
    found = []
    for argument, value in call:
        if argument.name not in ("M", "H"):
            continue
        kind = Technology.M if argument.name == "M" else Technology.H
        number = round_half_up(value)
        known = x.memory.m_synch if kind is Technology.M else x.memory.h_synch
        if number not in known:
            entry = catalogue.M_UNDEFINED if kind is Technology.M else catalogue.H_UNDEFINED
            raise call.error(entry, argument.name, number=number)
        synch = known[number].kind
        late = synch in ALLOWED[3:] and asynchronous_motion
        if synch not in ALLOWED or late:
            shown = f"{argument.name}{number} ({synch.name})"
            where = (
                "beside the motion of INDP_ASYN, whose end nobody waits for"
                if late
                else "in the bracket of an own motion"
            )
            raise call.error(errors.INDEPENDENT_SYNCH, argument.name, function=shown, where=where)
        found.append(OwnFunction(kind, number, argument.column))
    return tuple(found)


@statement("WAIT INDP", "isg.posax.wait-indp", syntax="#WAIT INDP [<axis> {,<axis>}]", form=Form.AXIS_BRACKET)
def wait_for_axes(x: Execution, call: StatementCall) -> None:
    """The path waits until the own motions of these axes have come to their targets."""
    wait_for(x, call.axes(), exact=x.setup.independent_exact_stop == EXACT_AT_WAIT)


@statement("WAIT INDP ALL", "isg.posax.wait-indp")
def wait_for_all(x: Execution, call: StatementCall) -> None:
    """The same, for all that move."""
    wait_for(x, tuple(x.independent.running), exact=x.setup.independent_exact_stop == EXACT_AT_WAIT)
