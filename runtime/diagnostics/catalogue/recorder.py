"""Errors of the flight recorder and of replays: 311xxx."""

from runtime.diagnostics.errors import ErrorEntry, Reaction, Severity

NOT_A_RECORDING = ErrorEntry(
    311001,
    "{file} is no recording that can be read: {reason}",
    remedy="Give a file that `tandem record save` or the recorder itself has written, complete and of this version.",
)
OTHER_LAYOUT = ErrorEntry(
    311002,
    "The recording was made by a runtime with other memories ({what}): {found} instead of {expected}",
    remedy="Replay it with the version of the runtime that has recorded it ({version}).",
)
NO_BEGINNING = ErrorEntry(
    311003,
    "The recording holds no cycle from which it can be replayed",
    remedy="Save it again: a keyframe is recorded at the start and then in every recorder.keyframe_every.",
)
OTHER_SOURCES = ErrorEntry(
    311004,
    "The recording was made by other sources ({found} instead of {expected}): where they part may be what was changed",
    Severity.WARNING,
    Reaction.NONE,
    remedy="Replay it with the version of the runtime that has recorded it ({version}) to see what happened there.",
)
OTHER_PROCESSOR = ErrorEntry(
    311005,
    "The recording was made on another processor ({found}, here {expected}): the last bits of numbers may differ",
    Severity.WARNING,
    Reaction.NONE,
    remedy="Replay it on the computer that has recorded it, if it parts.",
)
NOT_WRITTEN = ErrorEntry(
    311006,
    "The recorder cannot write to {folder}: {reason}; the machine goes on, what happens now is not recorded",
    Severity.WARNING,
    Reaction.NONE,
    remedy="Make room on the disk, or give recorder.size less; the recorder tries again by itself.",
)
WRITES_AGAIN = ErrorEntry(
    311007,
    "The recorder writes to {folder} again; {lost} s are missing",
    Severity.MESSAGE,
    Reaction.NONE,
)
NOT_RECORDED = ErrorEntry(
    311008,
    "There is no recording in {folder}",
    remedy="Start the machine with recorder.enabled, or name the machine description with --config.",
)
SAVED = ErrorEntry(
    311009,
    "The recording of the last {seconds} s is saved as {file}",
    Severity.MESSAGE,
    Reaction.NONE,
)
NO_KEYFRAMES = ErrorEntry(
    311011,
    "The state of this machine cannot be recorded while it runs: the recording ends when its room is used up",
    Severity.WARNING,
    Reaction.NONE,
    remedy="Give recorder.size more, so that it reaches until the machine is started again; and report it: something in the "
    "runtime has a state that is too large.",
)
ROOM_USED_UP = ErrorEntry(
    311012,
    "The recorder has used up its room in {folder}, and since its last keyframe there was no time for another",
    Severity.WARNING,
    Reaction.NONE,
    remedy="It goes on with the next keyframe. Give recorder.size more, or set recorder.keyframes to always.",
)
