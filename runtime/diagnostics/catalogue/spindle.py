"""Errors of turning functions, threads and tapping."""

from runtime.diagnostics.errors import ErrorEntry, Reaction, Severity

_THREAD = "programming manual, line 23300"
_G63 = "programming manual, line 23553"
_G331 = "programming manual, line 23626"

SPINDLE_NEEDED = ErrorEntry(
    313000,
    "{what} needs a main spindle that the control moves itself: {reason}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    source="programming manual, line 22232",
)
BESIDE = ErrorEntry(
    313001,
    "{word} cannot stand beside {motion}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="put it into a block of its own, in front of {motion} or behind it",
)
THREAD_PITCH = ErrorEntry(
    313002,
    "G33: the pitch {letter} is {value:.9g}; it has to be above 0",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="the hand of a thread follows from the sense of the spindle and of the motion",
    source=_THREAD,
)
THREAD_PITCH_MISSING = ErrorEntry(
    313003,
    "G33 has no pitch",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="I, J or K in mm per revolution, for X, Y or Z; it holds until the end of the program",
    source=_THREAD,
)
PITCH_AXIS = ErrorEntry(
    313004,
    "{motion}: the pitch {letter} belongs to {axis}, which {what}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="I belongs to X, J to Y, K to Z",
    source=_G331,
)
PITCH_TWICE = ErrorEntry(
    313005, "{motion} takes one pitch, not {letters}", reaction=Reaction.STOP_AT_BLOCK_END, source=_THREAD
)
SPINDLE_STANDS = ErrorEntry(
    313006,
    "G33: the main spindle {name} does not turn",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="M3 or M4 with a speed in front of it",
    source=_THREAD,
)
SPINDLE_TURNS = ErrorEntry(
    313007,
    "{motion}: the main spindle {name} turns",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="M5 or M19 in front of it",
    source=_G63,
)
TOO_FAST = ErrorEntry(
    313008,
    "{motion}: {what} cannot follow {speed:.9g} rev/min of {name}; possible are {limit:.9g}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="a lower speed of the spindle",
    source=_G331,
)
OFFSET_RANGE = ErrorEntry(
    313009,
    "{name}.OFFSET is {value:.9g}; it has to be at least 0 and less than 360 degrees",
    reaction=Reaction.STOP_AT_BLOCK_END,
    source=_THREAD,
)
TAPPING_ZERO = ErrorEntry(
    313010,
    "{motion} with {word} of 0",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="{motion} turns the spindle by what F, S and the pitch say",
    source=_G63,
)
TAPPING_SPINDLE = ErrorEntry(
    313011,
    "{word} of the main spindle {name} while it follows the path in {motion}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="G00, G01, G02 or G03 ends tapping",
    source=_G63,
)
TAPPING_FEED_MODE = ErrorEntry(
    313012,
    "G63 with G{mode}: F has to be a feed per minute",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="G94 in front of it; or G331 with a pitch",
    source=_G63,
)
RETRACT_PITCH = ErrorEntry(
    313013,
    "G332 with the pitch {value:.9g}: the hole was tapped with {before:.9g}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="leave the pitch out",
    source=_G331,
)
TAPPING_PITCH_MISSING = ErrorEntry(
    313014,
    "{motion} has no pitch",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="I, J or K in mm per revolution; below 0 for a left-hand thread",
    source=_G331,
)
TURN_VALUE = ErrorEntry(
    313015,
    "#TURN: {key} is {value:.9g}; possible is {range}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    source="programming manual, line 18360",
)
FACE_AXIS = ErrorEntry(
    313016,
    "{what} needs exactly one axis for facing in the plane G{plane}: there are {count}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="`turning: facing` of an axis in the machine description; G18 for X and Z",
    source="programming manual, line 23006",
)
CUTTING_SPEED = ErrorEntry(
    313017,
    "G{number}: {value:.9g} has to be above 0",
    reaction=Reaction.STOP_AT_BLOCK_END,
    source="programming manual, line 23209",
)
PSET_DIAMETER = ErrorEntry(
    313018,
    "#{name} while G51 is active",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="G52 in front of it",
    source="programming manual, line 12895",
)
TURNING_LINEAR = ErrorEntry(
    313019,
    "Axis {axis}: `turning` belongs to a linear axis, its type is {type}",
    remedy="Take `turning` away, or correct the type.",
)
MAIN_SPINDLE_ABSENT = ErrorEntry(
    313020,
    "Channel {channel}: its main spindle {axis} is optional, and the machine does not have it",
    remedy="Make another spindle the main one (main_spindle_ax_nr), or describe the axis.",
    source="channel parameters, line 3985",
)
# told by the cycle
THREAD_NOT_FOLLOWED = ErrorEntry(
    313100,
    "the path cannot follow the spindle {spindle} at {speed:.6g} rev/min: {what}. Possible are {limit:.6g}",
    Severity.ERROR,
    Reaction.STOP_ON_PATH,
    "Nothing of the thread was cut. A lower speed, or lower its override.",
)
THREAD_TOO_SHORT = ErrorEntry(
    313101,
    "a thread of {length:.6g} mm is too short for spindle {spindle} at {speed:.6g} rev/min: the axes need {needed:.6g} mm to "
    "begin and to end it",
    Severity.ERROR,
    Reaction.STOP_ON_PATH,
    "Nothing of the thread was cut. A lower speed, or a longer way in front of the thread and behind it.",
)
THREAD_LOST = ErrorEntry(
    313102,
    "in a thread the path is {off:.3g} mm off where the angle of spindle {spindle} has it",
    Severity.ERROR,
    Reaction.STOP_ON_PATH,
    "The spindle has changed its speed faster than the axes can. The path stops; the thread is spoilt.",
)
TAPPING_LOST = ErrorEntry(
    313103,
    "in tapping the spindle {spindle} is {off:.4g} degrees off where the path has it",
    Severity.ERROR,
    Reaction.STOP_ON_PATH,
    "The path stops with the tap in the hole. See to the drive of the spindle; turn the tap out with G63 or G332.",
)
SECTION_LONG = ErrorEntry(
    313104,
    "a chain of threads of more than {count} elements cannot be seen to its end before it begins",
    Severity.ERROR,
    Reaction.STOP_ON_PATH,
    "Nothing of the thread was cut. Fewer blocks in the chain.",
)
