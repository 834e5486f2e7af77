"""Errors of the CANopen bus, its nodes and the CiA 402 drives.

Entries from 303030 on happen while the machine runs: the cycle gets them as `DriveEvent`, and their text is filled
with `owner` ("axis X" or "I/O node"), `node`, `code` and the code's `meaning` (runtime.fieldbus.events).
"""

from runtime.diagnostics.errors import ErrorEntry, Reaction, Severity

# -- opening the bus -------------------------------------------------------------------------------------------------
BUS_MISSING = ErrorEntry(
    303001,
    "CAN interface {channel} does not exist",
    remedy="check fieldbus.bus.channel; `ip link show type can` lists the interfaces of this computer",
)
BUS_DOWN = ErrorEntry(
    303002,
    "CAN interface {channel} is down",
    remedy="bring it up: ip link set {channel} up type can bitrate {bitrate}",
)
BUS_PERMISSION = ErrorEntry(
    303003,
    "no permission to open the {interface} bus {channel}",
    remedy="SocketCAN needs CAP_NET_RAW in some containers; check the security settings of the service",
)
BUS_UNSUPPORTED = ErrorEntry(
    303004,
    "{interface} is not available on this computer: {reason}",
    remedy="load the CAN modules of the kernel (modprobe can_raw), or choose another fieldbus.bus.interface",
)
BUS_NO_MULTICAST = ErrorEntry(
    303005,
    "multicast group {channel} cannot be reached: {reason}",
    remedy="fieldbus.bus.channel must be a multicast address (224.0.0.0/4). With options.hop_limit 0 the group stays on "
    "this computer and needs the loopback interface only (ip link set lo up); otherwise it needs a route.",
)
BUS_OPEN_FAILED = ErrorEntry(
    303006,
    "the {interface} bus {channel} cannot be opened: {reason}",
    remedy="check fieldbus.bus in the machine description",
)
BUS_BAD_OPTION = ErrorEntry(
    303007,
    "the {interface} bus {channel} does not take the options {options}: {reason}",
    remedy="fieldbus.bus.options goes to python-can as it is; see its documentation of the interface",
)
BUS_NO_FD = ErrorEntry(
    303008,
    "CAN interface {channel} does not take frames of CAN FD: {reason}",
    remedy="ip link set {channel} down; ip link set {channel} up type can bitrate {bitrate} dbitrate 4000000 fd on; "
    "if the card has no CAN FD, set fd of the bus to false",
)
CANOPEN_FD = ErrorEntry(
    303009,
    "node {node} ({owner}) is a device of CANopen FD (CiA 1301): it speaks USDO, and this runtime the SDO of CiA 301",
    remedy="set the device to CiA 301, if it can be; else use one that speaks it",
)

# -- what the machine description asks for, and cannot be ------------------------------------------------------------
EDS_UNREADABLE = ErrorEntry(
    303010,
    "EDS file {file} of node {node} ({owner}) cannot be read: {reason}",
    remedy="name the EDS file of the device in the machine description, or leave it out for a simulated one",
)
EDS_OBJECT_MISSING = ErrorEntry(
    303011,
    "the EDS of node {node} ({owner}) has no object {object}, which is needed for {purpose}",
    remedy="use the EDS file that belongs to the device's firmware",
)
STARTUP_OBJECT = ErrorEntry(
    303012,
    "start-up write {object} = {value} of node {node} ({owner}) cannot be made: {reason}",
    remedy='write the object as "0x6085" or "0x60C2:1", with a value that fits its type',
)
TOO_MANY_BITS = ErrorEntry(
    303013,
    "I/O node {node} has {bits} {direction}, {limit} fit",
    remedy="divide them among several nodes",
)
CYCLE_NOT_REPRESENTABLE = ErrorEntry(
    303014,
    "a cycle of {period_us} µs cannot be given to the drives as interpolation period (1 to 255 times a power of ten)",
    remedy="choose a cycle like 1 ms, 2 ms, 500 µs",
)
BUS_TOO_SLOW = ErrorEntry(
    303015,
    "the frames of one cycle take {needed} µs of the bus at {bitrate} bit/s, {excess} µs more than the cycle of {period} µs",
    remedy="choose a longer cycle or a higher bit rate, or divide the nodes",
)
WRONG_CONFIGURATION = ErrorEntry(
    303016,
    "the configuration stored in node {node} ({owner}) is of date and time {actual} (object 0x1020), expected is {expected}",
    remedy="store the right parameters in the device with its own tool, or correct configuration",
    source="CiA 302-2, verify configuration",
)
# -- boot ------------------------------------------------------------------------------------------------------------
OTHER_MASTER = ErrorEntry(
    303020,
    "another CANopen master is active on the bus {channel}",
    remedy="end the other one, or give this machine a bus of its own",
)
NODE_TAKEN = ErrorEntry(
    303019,
    "node {node} is already on the bus {channel}: it cannot be simulated there",
    remedy="end the machine that it belongs to, or give this one a bus of its own",
)
NODE_MISSING = ErrorEntry(
    303021,
    "no answer on the bus within {seconds:g} s from {nodes}",
    remedy="check supply, cable, terminators, node id and bit rate of the named nodes",
)
WRONG_DEVICE_TYPE = ErrorEntry(
    303022,
    "node {node} ({owner}) is of device profile {actual}, expected is {expected}",
    remedy="check node ids: a drive must be CiA 402, an I/O node CiA 401",
)
WRONG_VENDOR = ErrorEntry(
    303023,
    "node {node} ({owner}) is of vendor 0x{actual:X}, the machine description expects 0x{expected:X}",
    remedy="check that the right device is connected, or correct vendor_id",
)
WRONG_PRODUCT = ErrorEntry(
    303024,
    "node {node} ({owner}) is product 0x{actual:X}, the machine description expects 0x{expected:X}",
    remedy="check that the right device is connected, or correct product_code",
)
MODE_UNSUPPORTED = ErrorEntry(
    303025,
    "the drive of {owner}, node {node}, does not know the {mode} mode (object 0x6502 is 0x{supported:X})",
    remedy="use a drive that has it, or name another `mode` in the machine description (older drives: interpolated_position)",
)
SDO_ABORTED = ErrorEntry(
    303026,
    "node {node} ({owner}) refuses to {access} object {object}: {meaning} (0x{code:08X})",
    remedy="check the EDS file and the start-up list of the node",
)
SDO_NO_ANSWER = ErrorEntry(
    303027,
    "node {node} ({owner}) does not answer when asked to {access} object {object}: {reason}",
    remedy="the node booted, then fell silent: check its supply and the wiring",
)
NODE_NOT_OPERATIONAL = ErrorEntry(
    303028,
    "node {node} ({owner}) did not become operational, its NMT state is {state}",
    remedy="look at the node's own diagnosis",
)

# -- in operation ----------------------------------------------------------------------------------------------------
# What befalls one node stops the others on the path, within their limits. Only a bus that is gone, or a set-point that is
# no number, leaves the axes to the ramps of their drives.
DRIVE_FAULT = ErrorEntry(
    303030,
    "the drive of {owner} (node {node}) is in fault: {meaning} (0x{code:04X})",
    reaction=Reaction.STOP_ON_PATH,
    remedy="remove the cause and acknowledge the fault (reset)",
)
EMERGENCY = ErrorEntry(
    303031,
    "node {node} ({owner}) reports: {meaning} (0x{code:04X})",
    severity=Severity.WARNING,
    reaction=Reaction.NONE,
    remedy="the manual of the device explains the code",
    source="CiA 301, EMCY",
)
# A node that is lost comes back by itself (runtime.fieldbus.rejoin): it is told, and waits for the acknowledgement.
HEARTBEAT_LOST = ErrorEntry(
    303032,
    "heartbeat of node {node} ({owner}) is lost",
    severity=Severity.FATAL,
    reaction=Reaction.STOP_ON_PATH,
    remedy="check supply and cable of the node, then acknowledge (reset)",
    source="CiA 301, heartbeat consumer",
)
NODE_RESTARTED = ErrorEntry(
    303033,
    "node {node} ({owner}) restarted by itself",
    severity=Severity.FATAL,
    reaction=Reaction.STOP_ON_PATH,
    remedy="check the supply of the node, then acknowledge (reset)",
)
NODE_LEFT_OPERATIONAL = ErrorEntry(
    303034,
    "node {node} ({owner}) left the operational state, its NMT state is {meaning}",
    severity=Severity.FATAL,
    reaction=Reaction.STOP_ON_PATH,
    remedy="see the alarms before this one, then acknowledge (reset)",
)
PROCESS_DATA_LOST = ErrorEntry(
    303035,
    "node {node} ({owner}) sends no process data any more",
    severity=Severity.FATAL,
    reaction=Reaction.STOP_ON_PATH,
    remedy="check the bus load and the node, then acknowledge (reset)",
)
DRIVE_DISABLED = ErrorEntry(
    303036,
    "the drive of {owner} (node {node}) left the enabled state by itself, it is now in {meaning}",
    reaction=Reaction.STOP_ON_PATH,
    remedy="check safe torque off, limit switches and supply of the drive; withdraw the enable and give it again",
)
SETPOINT_INVALID = ErrorEntry(
    303037,
    "the set-point of {owner} (node {node}) is no finite number; the drive brakes by itself",
    severity=Severity.FATAL,
    reaction=Reaction.QUICK_STOP,
    remedy="this is a defect of the runtime: keep the flight recorder and report it",
)
BUS_GONE = ErrorEntry(
    303040,
    "the bus{bus} is gone: {meaning}",
    severity=Severity.FATAL,
    reaction=Reaction.QUICK_STOP,
    remedy="check the CAN adapter and the cable, then acknowledge (reset)",
)
BUS_OFF = ErrorEntry(
    303041,
    "the CAN controller switched itself off the bus{bus} (bus off)",
    severity=Severity.FATAL,
    reaction=Reaction.QUICK_STOP,
    remedy="check terminators, cable and bit rate, then acknowledge (reset)",
)
# One of several buses is gone: the drives of the others still follow, so the path is braked as for a node that is lost.
ONE_BUS_GONE = ErrorEntry(
    303060,
    "the bus{bus} is gone: {meaning}; the axes on other buses brake on the path",
    severity=Severity.FATAL,
    reaction=Reaction.STOP_ON_PATH,
    remedy="check the CAN adapter and the cable, then acknowledge (reset)",
)
ONE_BUS_OFF = ErrorEntry(
    303061,
    "the CAN controller switched itself off the bus{bus} (bus off); the axes on other buses brake on the path",
    severity=Severity.FATAL,
    reaction=Reaction.STOP_ON_PATH,
    remedy="check terminators, cable and bit rate, then acknowledge (reset)",
)
NODE_DOUBLE = ErrorEntry(
    303063,
    "more than one node answers with node id {node} ({owner})",
    remedy="give each node an id of its own: by its switches, or by tandem bus lss with only one of them connected",
    source="CiA 301, boot-up",
)
FOREIGN_SYNC = ErrorEntry(
    303064,
    "somebody else sends SYNC on the bus{bus}: the drives take set-points over at wrong times",
    severity=Severity.FATAL,
    reaction=Reaction.STOP_ON_PATH,
    remedy="end the other master, and configure no node as SYNC producer (bit 30 of object 0x1005), then reset",
    source="CiA 301, SYNC",
)
BUS_FLOODED = ErrorEntry(
    303065,
    "more frames come from the bus{bus} than a cycle can take, for longer than the heartbeat timeout: nobody can be watched",
    severity=Severity.FATAL,
    reaction=Reaction.STOP_ON_PATH,
    remedy="find the node that sends without end (candump shows its identifier), then acknowledge (reset)",
)
BUS_WAITS = ErrorEntry(
    303062,
    "the bus{bus} came back {code} times by itself; now it stays off until it is acknowledged",
    severity=Severity.WARNING,
    reaction=Reaction.NONE,
    remedy="remove the cause, then acknowledge (reset): the bus is tried again (recovery, recovery_count of the bus)",
)
BUS_OVERLOADED = ErrorEntry(
    303042,
    "the frames of one cycle need {code} % of the bus{bus}",
    severity=Severity.WARNING,
    reaction=Reaction.NONE,
    remedy="choose a longer cycle, or a higher bit rate",
)
NODE_REJOINED = ErrorEntry(
    303043,
    "node {node} ({owner}) is back in operation{meaning}",
    severity=Severity.MESSAGE,
    reaction=Reaction.NONE,
    remedy="acknowledge (reset), then the program can be started again",
    source="CiA 302-2, boot slave",
)
REJOIN_REFUSED = ErrorEntry(
    303044,
    "node {node} ({owner}) is back, but cannot be taken into operation: {meaning}",
    reaction=Reaction.NONE,
    remedy="the reason says what to do; it is tried again every two seconds",
)
NODE_ABSENT = ErrorEntry(
    303045,
    "node {node} ({owner}) is not on the bus; it is optional",
    severity=Severity.WARNING,
    reaction=Reaction.NONE,
    remedy="connect it: it is taken into operation while the machine runs",
)
BUS_BACK = ErrorEntry(
    303046,
    "the bus{bus} works again; its nodes are taken into operation",
    severity=Severity.MESSAGE,
    reaction=Reaction.NONE,
    remedy="acknowledge (reset) when all nodes are back",
)
SETPOINT_JUMP = ErrorEntry(
    303047,
    "the set-point of {owner} (node {node}) jumps: it goes further in one cycle than the axis may; the drive brakes by itself",
    severity=Severity.FATAL,
    reaction=Reaction.QUICK_STOP,
    remedy="this is a defect of the runtime: keep the flight recorder and report it",
)
MODE_NOT_SHOWN = ErrorEntry(
    303048,
    "the drive of {owner} (node {node}) does not go into the mode of operation {code} (0x6060); it shows none of it (0x6061)",
    reaction=Reaction.STOP_ON_PATH,
    remedy="the manual of the drive tells which modes it has, and whether it changes them while it is enabled",
    source="IEC 61800-7-201, modes of operation",
)
GANTRY_SKEWED = ErrorEntry(
    303049,
    "the two ends of {owner} (second drive: node {node}) are {meaning} apart",
    reaction=Reaction.STOP_ON_PATH,
    remedy="find what holds one end back; set the axis square, then acknowledge (reset)",
)
ANALOGUE_OUT_OF_RANGE = ErrorEntry(
    303050,
    "{owner} (node {node}): the analogue input {meaning}, outside of its range",
    severity=Severity.WARNING,
    reaction=Reaction.NONE,
    remedy="look for a broken wire or a sensor that fails; the PLC program sees that the input is not valid",
)
UNITS_DIFFER = ErrorEntry(
    303017,
    "node {node} ({owner}) converts its increments otherwise than described: {object} is {actual}, expected is {expected}",
    remedy="correct `transmission` and `increments_per_unit`, or let it write the objects (transmission.objects: write)",
    source="IEC 61800-7-201, factor group",
)
UNITS_NOT_WHOLE = ErrorEntry(
    303018,
    "the feed of node {node} ({owner}) cannot be written: {feed:g} times {increments:g} increments is no ratio of whole numbers",
    remedy="choose `increments_per_unit` so that a revolution of the shaft is a whole number of increments",
)
TOO_MANY_PDOS = ErrorEntry(
    303029,
    "node {node} ({owner}) cannot exchange all that is asked for: {reason}",
    remedy="shorten `process_data` and `modes` of the drive, or the analogue values of the I/O node, or divide them among buses",
)
