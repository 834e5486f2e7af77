"""V.G.: blocks, units, feed, circle and state of the channel (programming manual 21060–21093, 21212–21250)."""

from __future__ import annotations

from random import Random

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import Reader, variable
from runtime.cnc.decoder.memory import TIMERS
from runtime.cnc.decoder.modal import INCH, FeedMode
from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.isg.functions import round_half_up
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.version import version

_BLOCK = "isg.var.g-block-feed-circle"
_STATE = "isg.var.g-channel-state"
_VERSION = "isg.var.g-version-limits-signal"


def index_between(value: float, first: int, last: int, name: str) -> int:
    """A whole index of a variable; CalculationError outside first…last."""
    if not first - 0.5 <= value < last + 0.5:
        raise CalculationError(catalogue.SET_INDEX, name, value=value, first=first, last=last)
    return round_half_up(value)


# ---------------------------------------------------------------------------------------------------- blocks and units


@variable("V.G.BLOCK_NR", _BLOCK, "last programmed block number")
def block_number(x: Execution) -> float:
    return float(x.block_number)


@variable("V.G.MASS_MM", _BLOCK, "0 with mm, 1 with inch")
def inch(x: Execution) -> float:
    return float(x.modal.inch)


@variable("V.G.MASS_360", _BLOCK, "0: angles are degrees")
def other_angles(x: Execution) -> float:
    return 0.0


# ---------------------------------------------------------------------------------------------------- feed


@variable("V.G.FEEDRATE", _BLOCK, "last F word, 0 before the first one", unit="as programmed")
def feed(x: Execution) -> float:
    """F as it would be programmed now: unit and factor of the channel taken out again."""
    modal = x.modal
    if modal.feed is None:
        return 0.0
    value = modal.feed
    if modal.feed_mode is FeedMode.PER_MINUTE:
        value /= x.setup.feed_factor
    return value / INCH if modal.inch and modal.feed_mode in (FeedMode.PER_MINUTE, FeedMode.PER_REVOLUTION) else value


@variable("V.G.FEEDRATE_MODE", _BLOCK, "G number of the meaning of F: 93, 94, 95 or 194")
def feed_mode(x: Execution) -> float:
    return float(x.modal.feed_mode)


@variable("V.G.FEEDRATE_SCALE", _BLOCK, "what an F in mm/min is divided by to fit the channel: 1, or 1000 with m/min")
def feed_scale(x: Execution) -> float:
    return x.setup.feed_factor


# ---------------------------------------------------------------------------------------------------- circles


def _circle_centre(letter: str, axis: int) -> Reader:
    @variable(f"V.G.{letter}", _BLOCK, f"{letter} of the last circle, corrected", unit="mm, inch")
    def centre(x: Execution) -> float:
        return x.shown_length(x.circle[0][axis])

    return centre


for _axis, _letter in enumerate("IJK"):
    _circle_centre(_letter, _axis)


@variable("V.G.R", _BLOCK, "radius of the last circle", unit="mm, inch")
def circle_radius(x: Execution) -> float:
    return x.shown_length(x.circle[2])


@variable("V.G.MERR[]", _BLOCK, "how far the centre was moved in the axes of the plane, 0 and 1", unit="mm, inch")
def centre_moved(x: Execution, place: float) -> float:
    return x.shown_length(x.circle[1][index_between(place, 0, 1, "V.G.MERR")])


# ---------------------------------------------------------------------------------------------------- state


@variable("V.G.CNC_CHANNEL", _STATE, "number of the channel, from 1")
def channel_number(x: Execution) -> float:
    return float(x.setup.channel_number)


@variable("V.G.IPO_COUNT", _STATE, "cycles of the interpolator since the start of the control")
def interpolator_cycles(x: Execution) -> float:
    return float(x.outside.cycle())


@variable("V.G.EXECUTION_MODE", _STATE, "0: the program is executed; no other purpose can be ordered")
def execution_mode(x: Execution) -> float:
    return 0.0


@variable("V.G.ACTIVE_MODE", _STATE, "mode that the program was started in: 2 automatic, 3 MDI, 4 manual, 5 homing")
def operating_mode(x: Execution) -> float:
    return float(x.outside.operating_mode())


@variable("V.G.AKT_PLATZ", _STATE, "0: no clamp position is selected, this control has none")
def clamp_position(x: Execution) -> float:
    return 0.0


@variable("V.G.PROG_ABS", _STATE, "1 with G90, 0 with G91")
def absolute_dimension(x: Execution) -> float:
    return float(not x.modal.incremental)


@variable("V.G.ACT_PLANE", _STATE, "G number of the plane: 17, 18 or 19")
def plane(x: Execution) -> float:
    return float(x.modal.plane)


@variable("V.G.TIMER[]", _STATE, "count of a counter (0…127) at its last #TIMER READ", unit="ms")
def timer(x: Execution, number: float) -> float:
    return x.memory.timers[index_between(number, 0, TIMERS - 1, "V.G.TIMER")]


@variable("V.G.RANDOM", _VERSION, "a number from 0 to 1, another one at each access")
def random(x: Execution) -> float:
    """The same row of numbers in every run of a program, so that runs in virtual time can be compared."""
    if x.random is None:
        x.random = Random(x.frames[0].unit.name)
    return x.random.random()


# ---------------------------------------------------------------------------------------------------- version


def _version_part(name: str, part: int) -> None:
    @variable(f"V.G.CNC_VERSION.{name}", _VERSION, "version of this control")
    def read(x: Execution) -> float:
        return float(_own_version()[part])


def _own_version() -> tuple[int, int, int, int]:
    """Version of Tandem: major, minor, build, patch."""
    parts = [int(part) for part in version().split("+")[0].split(".")[:4] if part.isdigit()]
    major, minor, build, patch = (*parts, 0, 0, 0, 0)[:4]
    return major, minor, build, patch


for _part, _name in enumerate(("MAJOR", "MINOR", "BUILD", "PATCH")):
    _version_part(_name, _part)


@variable("V.G.CNC_RELEASE", _VERSION, "build number of this control")
def release(x: Execution) -> float:
    return float(_own_version()[2])


# ---------------------------------------------------------------------------------------------------- contour rotation

_ROTATION = "isg.var.g-link-rotation"


@variable("V.G.ROT_ACTIVE", _ROTATION, "1 while a contour rotation is active")
def rotated(x: Execution) -> float:
    return float(x.coordinates.rotation is not None)


@variable("V.G.ROT_ANGLE", _ROTATION, "angle of the contour rotation, 0 without one", unit="deg")
def rotation_angle(x: Execution) -> float:
    return x.coordinates.rotation.angle if x.coordinates.rotation is not None else 0.0


def _rotation_centre(number: int) -> None:
    @variable(
        f"V.G.ROT_CENTER{number}", _ROTATION, f"centre of the rotation, axis {number} of the plane", unit="mm, inch"
    )
    def read(x: Execution) -> float:
        rotation = x.coordinates.rotation
        return x.shown_length(rotation.centre[number - 1]) if rotation is not None else 0.0


_rotation_centre(1)
_rotation_centre(2)
