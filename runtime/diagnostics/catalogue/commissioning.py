"""Errors of commissioning: layer setting services, objects by name, one drive by hand."""

from runtime.diagnostics.errors import ErrorEntry

LSS_NO_NODE = ErrorEntry(
    303100,
    "no answer to the layer setting services (LSS) from {whom}",
    remedy="check supply, cable and bit rate; nodes with switches for node id and bit rate often have no LSS",
    source="CiA 305",
)
LSS_SEVERAL = ErrorEntry(
    303101,
    "more than one node answers: all of them would get the same settings",
    remedy="name the node by its identity (tandem bus scan shows it), or connect only this one",
    source="CiA 305",
)
LSS_REFUSED = ErrorEntry(
    303102,
    "the node refuses the setting: {meaning}",
    remedy="the manual of the device tells what it can be set to",
    source="CiA 305",
)
LSS_BITRATE = ErrorEntry(
    303103,
    "there is no bit rate of {bitrate} bit/s in the layer setting services",
    remedy="choose one of {known}",
    source="CiA 305, bit timing table",
)
NODE_ID_TAKEN = ErrorEntry(
    303104,
    "node id {node} is taken by another node",
    remedy="choose a free one; tandem bus scan shows the nodes",
)
OBJECT_UNKNOWN = ErrorEntry(
    303110,
    "no object is meant by {object}: {reason}",
    remedy='write the object as 0x6064 or 0x60C2:1, or its name in the EDS file; "tandem drive objects" lists them',
)
OBJECT_VALUE = ErrorEntry(
    303111,
    "{value} cannot be written to object {object}: {reason}",
    remedy="the EDS file and the manual of the device tell what the object takes",
)
NO_SUCH_DRIVE = ErrorEntry(
    303112,
    "{axis} is no axis with a drive of {machine}",
    remedy="the axes with drives are {known}",
)
DRIVE_NOT_ENABLED = ErrorEntry(
    303113,
    "the drive of axis {axis} does not get enabled within {seconds:g} s, it stays in {state}",
    remedy="check safe torque off, the power supply and the limit switches of the drive, and its error code (tandem drive state)",
)
DRIVE_AWAY = ErrorEntry(
    303114,
    "axis {axis} is {error:.3f} away from its set-point, more than its following error of {limit:g}: it was stopped",
    remedy="check that the axis can move, the sign and the increments_per_unit of its drive, and its gains",
)
JOG_LIMIT = ErrorEntry(
    303115,
    "{what} of {value:g} is outside of 0 to {limit:g}, what axis {axis} may do in {unit}",
    remedy="the axis' velocity and travel in the machine description are the limits",
)
DCF_UNREADABLE = ErrorEntry(
    303120,
    "the configuration file {file} cannot be used: {reason}",
    remedy="write it anew with the tool of the device",
    source="CiA 306, CiA 302-3",
)
DCF_VALUE = ErrorEntry(
    303121,
    "the configuration file {file} cannot be used for object {object}: {reason}",
    remedy="correct the value of the object, or take it out of the file and set it with the tool of the device",
    source="CiA 306",
)
