"""Errors of measuring: what a program asks of a probe, and what the probe does."""

from runtime.diagnostics.errors import ErrorEntry, Reaction, Severity


def _entry(number: int, text: str, remedy: str, source: str = "") -> ErrorEntry:
    return ErrorEntry(number, text, reaction=Reaction.STOP_AT_BLOCK_END, remedy=remedy, source=source)


def _running(number: int, text: str, remedy: str, source: str = "") -> ErrorEntry:
    return ErrorEntry(number, text, reaction=Reaction.STOP_ON_PATH, remedy=remedy, source=source)


# ids of the manual
DEFLECTED = _running(
    50052,
    "axis {axis}: the probe is deflected already where the measuring run begins",
    "move it free, or allow it with P-CHAN-00312",
    "channel parameters line 2970",
)
NO_WAY = _entry(
    50067,
    "the measuring block moves no axis",
    "program a target that is not where the axes stand, or allow it with P-CHAN-00313",
    "channel parameters line 2981",
)
LIMIT_WITHOUT_SIGNAL = _running(
    50706,
    "the measuring run has come to a software limit without a signal of the probe",
    "check the place of the workpiece and the probe",
    "channel parameters line 2912",
)

# ids of our own
AXES_MISSING = _entry(314000, "G100 without axes", "name the axes that measure, with their targets")
NOT_MEASURING = _entry(
    314001,
    "axis {axis} does not measure",
    "describe its probe under `measuring` of the axis, or leave it out of the block",
    "programming manual line 3308",
)
BARRED = _entry(
    314002,
    "no measuring run while {what} is active",
    "end it before",
    "programming manual line 3289",
)
BESIDE = _entry(314003, "{what} cannot stand in a measuring block", "put it into a block of its own")
ONE_AXIS = _entry(
    314004,
    "measuring type 2 takes one axis, not {count}",
    "measure axis by axis, or choose another type with #MEAS MODE",
    "programming manual line 3367",
)
MAIN_AXES_ONLY = _entry(
    314005,
    "axis {axis} is no main axis: measuring type 4 takes the main axes only",
    "leave it out, or choose another type with #MEAS MODE",
    "programming manual line 3494",
)
TYPE_UNKNOWN = _entry(314006, "{value:g} is no type of measuring", "1 to 7", "programming manual line 3240")
TYPE_UNSUPPORTED = _entry(
    314007,
    "measuring type {value} is none of this block",
    "types 1, 2, 3 and 4 are those of G100, type 5 is that of G310; others are not available in this version",
)
FEED_MISSING = _entry(
    314008,
    "axis {axis} has no measuring feed, which type 2 needs",
    "give it as `feed` under `measuring` of the axis (P-AXIS-00215)",
    "programming manual line 3369",
)
SOURCE_UNSUPPORTED = _entry(314009, "{what} is not available in this version", "leave it out")
PROBE_UNKNOWN = _entry(
    314010,
    "axis {axis}: its drive does not exchange the {edge} edge of its touch probe {number}",
    "name it in `process_data` of the drive",
)
KEYS_TOGETHER = _entry(
    314011,
    "{key} belongs to an axis: AX or AXNR has to stand before it",
    "name the axes",
    "programming manual line 12674",
)
G106_ALONE = _entry(
    314012,
    "G106 belongs to G100 in measuring type 3",
    "choose the type with #MEAS MODE [3], or leave G106 out",
    "programming manual line 3457",
)
NOT_MEASURED = _entry(
    314013,
    "axis {axis} has no measured value that could be taken into its coordinates",
    "measure it before",
    "programming manual line 3627",
)
NO_OFFSET = _entry(
    314014,
    "no measuring offset of axis {axis} is in its coordinates",
    "leave the axis out of G102",
    "programming manual line 3661",
)
TURNED = _entry(
    314016,
    "axis {axis} was measured in a rotated coordinate system: its offset is none of an axis of the machine",
    "take the measured values into the program instead (V.A.MEAS.PCS.VALUE)",
)
NO_PCS_VALUE = ErrorEntry(
    314015,
    "axis {axis} has no measured value, so the measured point in programmed coordinates is not known",
    severity=Severity.WARNING,
    reaction=Reaction.NONE,
    remedy="measure all axes of the rotated plane or system, or see P-CHAN-00440",
    source="channel parameters line 8531",
)
NO_SIGNAL = _running(
    314020,
    "axis {axis}: the measuring run has come to its end without a signal of the probe",
    "check the place of the workpiece and the probe; #MEAS [ERR_NO_SIGNAL=0] lets the program go on",
    "programming manual line 3390",
)
NOT_READY = _running(
    314021,
    "axis {axis}: its probe is not ready: {what}",
    "check objects 0x60B8 and 0x60B9 of the drive; the PLC has to claim the units probing_signal and probing_time",
)
PROBE_BUSY = _running(
    314022,
    "axis {axis}: its touch probe waits for a job of the PLC",
    "wait for MC_TouchProbe, or abort it with MC_AbortTrigger",
)
STAMP_OUTSIDE = _running(
    314023,
    "axis {axis}: the time stamp of the probe signal lies {late:.3f} s before this cycle, which is not known any more",
    "the stamp is time_ns_r of the head of the interface at the edge; hand it over within 50 cycles",
)
