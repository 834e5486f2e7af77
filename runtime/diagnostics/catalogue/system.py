"""Errors of the runtime: processes, clock, watchdogs, files."""

from runtime.diagnostics.errors import ErrorEntry, Reaction, Severity


def _hint(number: int, text: str, remedy: str) -> ErrorEntry:
    """Something that the host refuses or lacks: told, and the run goes on."""
    return ErrorEntry(number, text, Severity.WARNING, Reaction.NONE, remedy)


COMMAND_MISSING = ErrorEntry(
    305001,
    "The sub-command {command!r} is not part of this installation ({reason})",
    remedy="Install the whole distribution tandem-cnc again.",
)
OPTION_NOT_AVAILABLE = ErrorEntry(
    305002,
    "The option {option} is not available: {reason}",
    remedy="Leave the option out.",
)
FILE_FAILED = ErrorEntry(
    305003,
    "The file cannot be opened: {reason}",
    remedy="Does its folder exist, and may this user write to it?",
)

# what a cycle process asks of the host, runtime.scheduler.realtime
NO_PRIORITY = _hint(
    305010,
    "No real-time priority {priority}: {reason}",
    "Give the user LimitRTPRIO=99 (systemd) or `rtprio 99` in /etc/security/limits.d.",
)
NO_MEMORY_LOCK = _hint(
    305011,
    "Memory is not locked: {reason}",
    "Give the user LimitMEMLOCK=infinity (systemd) or `memlock unlimited` in /etc/security/limits.d.",
)
NO_AFFINITY = _hint(
    305012,
    "Not pinned to processor {cpu}: {reason}",
    "Set cycle.cpu of the machine description to one of the processors {available}.",
)
NO_TIMER_SLACK = _hint(305013, "Timer slack stays as it is: {reason}", "Timers may fire up to 50 µs late.")
NO_CPU_LATENCY = _hint(
    305014,
    "Processors may fall into deep sleep: /dev/cpu_dma_latency: {reason}",
    "Give the user write access to /dev/cpu_dma_latency, or limit C-states with processor.max_cstate=1.",
)

# compiled kernels, runtime.kernel_cache
KERNELS_NOT_KEPT = _hint(
    305015,
    "Compiled kernels cannot be kept, no folder of these can be written: {places}; every start compiles them",
    "Set NUMBA_CACHE_DIR to a folder that this user may write to.",
)

# retained data, runtime.scheduler.retained
RETAINED_BROKEN = _hint(
    305020,
    "Retained data in {file} is damaged ({reason}); the copy before it is used",
    "Check positions and zero offsets before the first move; the damaged file is kept as {kept}.",
)
RETAINED_LOST = ErrorEntry(
    305021,
    "Retained data in {file} is damaged ({reason}), and there is no copy: positions and zero offsets are lost",
    remedy="Reference the axes and enter the zero offsets again; the damaged file is kept as {kept}.",
)
RETAINED_NOT_WRITTEN = ErrorEntry(
    305022,
    "Retained data cannot be written to {file}: {reason}; {advice}",
    reaction=Reaction.NONE,
    remedy="Until then a restart brings back what was written last. The runtime tries again by itself; the alarm goes when it "
    "has written. state_directory in the machine description says where.",
)

# service process
PROCESS_NOT_STARTED = ErrorEntry(
    305023,
    "The host cannot start the process {process}: {reason}; it is tried again every second",
    Severity.ERROR,
    Reaction.NONE,
    remedy="Give the host memory or processes to spare (free -m; TasksMax=, MemoryMax= of the service), then reset the channel.",
)
CLOCK_STEPPED = ErrorEntry(
    305024,
    "The wall clock was set by {seconds:+.1f} s: time stamps before and after this line do not fit together",
    Severity.WARNING,
    Reaction.NONE,
    remedy="Nothing moves by this clock. Keep it in step (NTP, PTP), so that the times of alarms can be compared.",
)

# runtime.monitoring
METRICS_PORT = ErrorEntry(
    305030,
    "The metrics endpoint cannot be opened at {host}:{port}: {reason}",
    Severity.WARNING,
    Reaction.NONE,
    remedy="Choose another metrics.port in the machine description, or end the program that uses this one.",
)
NO_TRACE = ErrorEntry(
    305040,
    "no trace that can be compared: {reason}",
    remedy="Give folders that `tandem simulate --trace FOLDER` has written for the same machine.",
)
