"""Plain text of CANopen's codes: emergency error codes, SDO abort codes, NMT states.

Emergency codes are those of CiA 301 (communication) and of IEC 61800-7-201 / CiA 402 (drives), where 0x603F
uses the same.
"""

from __future__ import annotations

from typing import Final

from canopen.sdo.exceptions import SdoAbortedError

EMERGENCY_TEXTS: Final[dict[int, str]] = {
    0x0000: "no error",
    0x1000: "generic error",
    0x2000: "current",
    0x2110: "short circuit or earth leakage at the input",
    0x2120: "earth leakage at the input",
    0x2130: "short circuit at the input",
    0x2211: "internal over-current 1",
    0x2212: "internal over-current 2",
    0x2213: "over-current in the ramp",
    0x2214: "over-current in the sequence",
    0x2220: "continuous over-current in the device",
    0x2230: "short circuit or earth leakage in the device",
    0x2240: "earth leakage in the device",
    0x2250: "short circuit in the device",
    0x2310: "continuous over-current at the motor",
    0x2320: "short circuit or earth leakage at the motor",
    0x2330: "earth leakage at the motor",
    0x2340: "short circuit at the motor",
    0x2350: "overload (I²t, thermal state)",
    0x2351: "overload warning",
    0x3000: "voltage",
    0x3110: "mains over-voltage",
    0x3120: "mains under-voltage",
    0x3130: "mains phase failure",
    0x3140: "mains frequency",
    0x3210: "DC link over-voltage",
    0x3220: "DC link under-voltage",
    0x3230: "load error",
    0x3310: "output over-voltage",
    0x3320: "armature circuit",
    0x3330: "field circuit",
    0x4000: "temperature",
    0x4110: "ambient temperature too high",
    0x4120: "ambient temperature too low",
    0x4210: "device too hot",
    0x4220: "device too cold",
    0x4310: "drive too hot",
    0x4320: "drive too cold",
    0x4410: "supply too hot",
    0x5000: "device hardware",
    0x5100: "supply of the control electronics",
    0x5112: "24 V supply of the control electronics",
    0x5113: "5 V supply of the control electronics",
    0x5200: "control electronics",
    0x5210: "measurement circuit",
    0x5300: "operating unit",
    0x5400: "power section",
    0x5410: "output stages",
    0x5420: "brake chopper",
    0x5430: "input stages",
    0x5440: "contactors",
    0x5450: "fuses",
    0x5500: "data storage",
    0x5510: "working memory",
    0x5520: "program memory",
    0x5530: "non-volatile memory",
    0x6000: "device software",
    0x6010: "software reset by the watchdog",
    0x6100: "internal software",
    0x6200: "user software",
    0x6310: "loss of parameters",
    0x6320: "parameter error",
    0x7000: "additional modules",
    0x7100: "power of additional modules",
    0x7110: "brake chopper",
    0x7120: "motor",
    0x7121: "motor blocked",
    0x7122: "motor error or wrong commutation",
    0x7200: "measurement circuit of additional modules",
    0x7300: "sensor",
    0x7301: "tacho fault",
    0x7303: "resolver 1 fault",
    0x7305: "incremental encoder 1 fault",
    0x7306: "incremental encoder 2 fault",
    0x7310: "speed sensor",
    0x7320: "position sensor",
    0x7400: "computation circuit",
    0x7500: "communication of additional modules",
    0x7600: "external data storage",
    0x8000: "monitoring",
    0x8100: "communication",
    0x8110: "CAN overrun, messages lost",
    0x8120: "CAN in error passive mode",
    0x8130: "heartbeat of the master lost",
    0x8140: "recovered from bus off",
    0x8150: "CAN identifier collision",
    0x8200: "protocol error",
    0x8210: "PDO not processed, it is too short",
    0x8220: "PDO too long",
    0x8240: "SYNC of unexpected length",
    0x8250: "RPDO missing",
    0x8300: "torque control",
    0x8311: "excess torque",
    0x8312: "difficult start-up",
    0x8313: "standstill torque",
    0x8321: "insufficient torque",
    0x8400: "velocity control",
    0x8500: "position control",
    0x8600: "positioning",
    0x8611: "following error too large",
    0x8612: "reference limit",
    0x8700: "synchronisation with the bus",
    0x8900: "process data monitoring",
    0x9000: "external error",
    0xF000: "additional functions",
    0xF001: "deceleration",
    0xFF00: "device specific",
}

NMT_STATES: Final[dict[int, str]] = {0: "boot-up", 4: "stopped", 5: "operational", 127: "pre-operational"}


def emergency_text(code: int) -> str:
    """What an emergency code means; a code of no entry gets the text of its family (last digits zero)."""
    for mask in (0xFFFF, 0xFFF0, 0xFF00, 0xF000):
        if (text := EMERGENCY_TEXTS.get(code & mask)) is not None and (code & mask or not code):
            return text
    return "error reset" if not code & 0xFF00 else "unknown error"


def nmt_state_text(state: int) -> str:
    """Name of an NMT state as it stands in a heartbeat."""
    return NMT_STATES.get(state, f"unknown ({state})")


def abort_text(code: int) -> str:
    """Plain text of an abort code of CiA 301."""
    text: str = SdoAbortedError.CODES.get(code, "unknown reason")
    return text[:1].lower() + text[1:]
