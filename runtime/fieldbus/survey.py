"""From a scan of the bus to the beginning of a machine description: who is there, what it exchanges, in which units it counts.

What no node knows (velocities, accelerations, the pitch of a screw) is left to fill in as `<...>`; the loader refuses it by name
until somebody has.
"""

from __future__ import annotations

import configparser
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from runtime.config.machine import Bus
from runtime.fieldbus import eds_text
from runtime.fieldbus.commissioning import Commissioning, FoundNode, read_number
from runtime.fieldbus.network import PumpedSdoClient
from runtime.fieldbus.pdo import INVALID, Direction, object_name

ENCODER: Final = 0x608F  # increments, motor revolutions
GEAR: Final = 0x6091  # motor revolutions, shaft revolutions
FEED: Final = 0x6092  # feed, shaft revolutions
POSITION_UNIT: Final = 0x60A8  # prefix, unit (CiA 303-2)
MAX_PROFILE_VELOCITY: Final = 0x607F
MAX_MOTOR_SPEED: Final = 0x6080  # 1/min
SUPPORTED_MODES: Final = 0x6502
INPUTS: Final = 0x6000
OUTPUTS: Final = 0x6200

METRE: Final = 0x01
DEGREE: Final = 0x41
CYCLIC_MODES: Final = {8: "cyclic position", 9: "cyclic velocity", 10: "cyclic torque"}
NAMES: Final = "XYZABCUVW"


@dataclass(frozen=True, slots=True)
class Factors:
    """The factor group of a drive: what it counts per revolution. None is what the drive does not tell."""

    encoder: tuple[int, int] | None = None  # increments per motor revolutions
    gear: tuple[int, int] | None = None  # motor revolutions per shaft revolutions
    feed: tuple[int, int] | None = None  # counts of the position per shaft revolutions
    unit: int | None = None  # object 0x60A8

    def per_unit(self) -> tuple[float, str] | None:
        """Counts of the position (0x6064) per mm or per degree, if the drive says in which unit it counts."""
        if self.unit is None:
            return None
        prefix, unit = self.unit >> 24 & 0xFF, self.unit >> 16 & 0xFF
        exponent = prefix - 256 if prefix > 127 else prefix
        if unit == METRE:
            return 10.0 ** (-3 - exponent), "mm"
        if unit == DEGREE:
            return 10.0**-exponent, "degree"
        return None

    def per_turn(self) -> float | None:
        """Counts of the position (0x6064) per turn of the shaft behind the gear."""
        if self.feed is not None:
            return self.feed[0] / self.feed[1]
        if self.encoder is not None:  # no feed constant: it counts the encoder
            motor_turns = 1.0 if self.gear is None else self.gear[0] / self.gear[1]
            return self.encoder[0] / self.encoder[1] * motor_turns
        return None


@dataclass(frozen=True, slots=True)
class Survey:
    """A node, and what its objects tell beyond its identity."""

    node: FoundNode
    factors: Factors = Factors()
    modes: int | None = None
    max_velocity: int | None = None  # counts/s
    max_motor_speed: int | None = None  # 1/min
    inputs: int = 0  # bits
    outputs: int = 0
    mapping: Mapping[str, tuple[str, ...]] = field(default_factory=dict)  # "RPDO 1" -> objects
    eds: str | None = None  # file that describes it


def survey(looking: Commissioning, found: Sequence[FoundNode], eds_files: Sequence[EdsFile] = ()) -> list[Survey]:
    """Ask every node that was found. Raises can.CanError."""
    surveys = []
    for node in found:
        with looking.asking(node.node) as client:
            surveys.append(_ask(client, node, eds_files))
    return surveys


def _limit(value: int | None) -> int | None:
    """A limit that is not set is the greatest number."""
    return None if value == 0xFFFF_FFFF else value


def _ask(client: PumpedSdoClient, node: FoundNode, eds_files: Sequence[EdsFile]) -> Survey:
    def pair(index: int) -> tuple[int, int] | None:
        first, second = read_number(client, index, 1), read_number(client, index, 2)
        # 1:1 is what an object says that nobody has ever set; of a gear it says nothing either
        return (first, second) if first and second and (first, second) != (1, 1) else None

    drive = node.device_type & 0xFFFF == 402
    io = node.device_type & 0xFFFF == 401
    return Survey(
        node=node,
        factors=Factors(pair(ENCODER), pair(GEAR), pair(FEED), read_number(client, POSITION_UNIT))
        if drive
        else Factors(),
        modes=read_number(client, SUPPORTED_MODES) if drive else None,
        max_velocity=_limit(read_number(client, MAX_PROFILE_VELOCITY)) if drive else None,
        max_motor_speed=read_number(client, MAX_MOTOR_SPEED) if drive else None,
        inputs=8 * (read_number(client, INPUTS) or 0) if io else 0,
        outputs=8 * (read_number(client, OUTPUTS) or 0) if io else 0,
        mapping=dict(_mapping(client)),
        eds=next((file.path for file in sorted(eds_files, key=lambda file: -file.fits(node)) if file.fits(node)), None),
    )


def _mapping(client: PumpedSdoClient) -> Iterator[tuple[str, tuple[str, ...]]]:
    """The PDOs that are switched on."""
    for direction, name in ((Direction.RECEIVE, "RPDO"), (Direction.TRANSMIT, "TPDO")):
        communication, mapping, _ = direction.value
        for number in range(4):
            cob_id = read_number(client, communication + number, 1)
            if cob_id is None or cob_id & INVALID:
                continue
            count = read_number(client, mapping + number) or 0
            entries = [read_number(client, mapping + number, sub) or 0 for sub in range(1, min(count, 8) + 1)]
            yield f"{name} {number + 1}", tuple(object_name(entry >> 16, entry >> 8 & 0xFF) for entry in entries)


@dataclass(frozen=True, slots=True)
class EdsFile:
    """An EDS or DCF file, and which device it says that it describes."""

    path: str
    vendor: int | None
    product: int | None
    revision: int | None

    def fits(self, node: FoundNode) -> int:
        """0: another device; 1: the device, of another revision; 2: just this one."""
        if self.vendor is None or (self.vendor, self.product) != (node.vendor, node.product):
            return 0
        return 2 if self.revision == node.revision else 1


def eds_files(folder: Path) -> list[EdsFile]:
    """The EDS and DCF files of a folder; what cannot be read as one is left out. Raises OSError."""
    found = []
    for path in sorted(folder.iterdir()):
        if path.suffix.lower() not in (".eds", ".dcf"):
            continue
        parser = configparser.RawConfigParser(strict=False)
        try:
            parser.read_string(eds_text.normalise(eds_text.decode(path.read_bytes())))
        except (configparser.Error, ValueError):
            continue

        def number(key: str, parser: configparser.RawConfigParser = parser) -> int | None:
            try:
                return int(parser.get("DeviceInfo", key, fallback=""), 0)
            except ValueError:
                return None

        found.append(EdsFile(str(path), number("VendorNumber"), number("ProductNumber"), number("RevisionNumber")))
    return found


# -- the description -------------------------------------------------------------------------------------------------


def describe(surveys: Sequence[Survey], bus: Bus, pitches: Mapping[int, float], folder: Path) -> str:
    """The YAML text; EDS files are named as seen from `folder`. `pitches`: node id → mm or degrees per turn of the shaft."""
    drives = [s for s in surveys if s.node.device_type & 0xFFFF == 402]
    ios = [s for s in surveys if s.node.device_type & 0xFFFF == 401]
    others = [s for s in surveys if s not in drives and s not in ios]
    names = [NAMES[k] if k < len(NAMES) else f"Q{k}" for k in range(len(drives))]
    lines = [
        "# From a scan of the bus. What stands in angle brackets no node can know: fill it in, the rest can stay.",
        "name: <name of the machine>",
        "cycle:",
        "  period: 1 ms",
    ]
    if drives:
        lines.append("axes: # in the order of the node ids; rename them as they move")
    for name, drive in zip(names, drives, strict=True):
        lines += _axis(name, 1 + names.index(name), drive, pitches.get(drive.node.node), folder)
    if drives:
        lines += ["channels:", "  - name: channel 1", f"    axes: [{', '.join(names[:8])}] # without spindles"]
    lines += [
        "fieldbus:",
        "  bus:",
        f"    interface: {bus.interface}",
        f'    channel: "{bus.channel}"',
        f"    bitrate: {bus.bitrate}",
    ]
    # the bus on which the nodes were found, with whatever else its description says; JSON is YAML
    further = bus.model_dump(mode="json", exclude_defaults=True, exclude={"interface", "channel", "bitrate"})
    lines += [f"    {key}: {json.dumps(value)}" for key, value in further.items()]
    if ios:
        lines.append("  io: # a name for each bit that is used, in their order")
    for io in ios:
        lines += _io(io, folder)
    for other in others:
        lines.append(
            f"# node {other.node.node} is no drive and no I/O node: {_title(other.node)}, {other.node.profile}"
        )
    return "\n".join(lines) + "\n"


def _title(node: FoundNode) -> str:
    return " ".join(" ".join((node.name, node.firmware)).split()) or "without a name"


def _axis(name: str, number: int, drive: Survey, pitch: float | None, folder: Path) -> Iterator[str]:
    node = drive.node
    yield f"  - name: {name} # {_title(node)}"
    if drive.modes is not None:
        known = [text for mode, text in CYCLIC_MODES.items() if drive.modes >> mode - 1 & 1]
        yield f"    # it has {', '.join(known) or 'NO CYCLIC MODE, which the runtime needs'} (0x6502 is 0x{drive.modes:X})"
    yield from (f"    # {pdo} as found: {', '.join(objects)}" for pdo, objects in drive.mapping.items())
    yield "    type: linear # or rotary, spindle"
    yield f"    log_axis: {number}"
    per_unit, remarks = _increments(drive, pitch)
    yield from (f"    # {remark}" for remark in remarks)
    yield "    # position_min: 0 mm # software limits"
    yield "    # position_max: 0 mm"
    yield "    velocity: <m/min>"
    yield "    acceleration: <m/s^2>"
    yield "    jerk: <m/s^3>"
    yield "    drive:"
    yield f"      node: {node.node}"
    yield f"      increments_per_unit: {per_unit}"
    yield from _device(drive, folder, "      ", product=True)


def _increments(drive: Survey, pitch: float | None) -> tuple[str, list[str]]:
    """`increments_per_unit` as it is written, and what is known about it."""
    factors, remarks = drive.factors, []
    if factors.encoder:
        remarks.append(f"encoder: {factors.encoder[0]} increments in {factors.encoder[1]} turns of the motor (0x608F)")
    if factors.gear:
        remarks.append(f"gear: {factors.gear[0]} turns of the motor for {factors.gear[1]} of the shaft (0x6091)")
    if factors.feed:
        remarks.append(f"feed constant: {factors.feed[0]} counts in {factors.feed[1]} turns of the shaft (0x6092)")
    told, per_turn = factors.per_unit(), factors.per_turn()
    if told is not None:
        written = f"{told[0]:.15g} # per {told[1]}: the drive tells its unit (0x60A8 is 0x{factors.unit:08X})"
        scale = told[0]
    elif per_turn is not None and pitch is not None:
        scale = per_turn / pitch
        written = f"{scale:.15g} # {per_turn:.15g} counts per turn, {pitch:g} mm or degrees per turn"
    elif per_turn is not None:
        return f"<{per_turn:.15g} divided by the mm or degrees per turn of the shaft>", remarks
    else:
        return "<increments per mm or degree>", remarks
    if drive.max_velocity:
        remarks.append(f"the drive allows {drive.max_velocity / scale:g} mm/s or degrees/s (0x607F)")
    if drive.max_motor_speed:
        remarks.append(f"the motor allows {drive.max_motor_speed} turns per minute (0x6080)")
    return written, remarks


def _io(io: Survey, folder: Path) -> Iterator[str]:
    yield f"    - node: {io.node.node} # {_title(io.node)}: {io.inputs} inputs, {io.outputs} outputs"
    yield from _device(io, folder, "      ", product=False)
    if io.inputs:
        yield f"      inputs: [<{io.inputs} names at most>]"
    if io.outputs:
        yield f"      outputs: [<{io.outputs} names at most>]"


def _device(device: Survey, folder: Path, indent: str, *, product: bool) -> Iterator[str]:
    node = device.node
    if device.eds is not None:
        yield f'{indent}eds: "{os.path.relpath(device.eds, folder)}"'
    else:
        yield f"{indent}# eds: file.eds # no file of this device was given"
    if node.vendor is not None:
        yield f"{indent}vendor_id: 0x{node.vendor:X}"
    if product and node.product is not None:
        yield f"{indent}product_code: 0x{node.product:X}"
    if node.serial is not None:
        yield f"{indent}# revision 0x{node.revision or 0:X}, serial number 0x{node.serial:X}"
