"""What becomes of a synchronisation type when the path is not driven forward from block to block (channel parameters 1854–1855).

    direction            with its flag                    without
    ──────────────────   ──────────────────────────────   ───────────
    FORWARD              the type                         the type
    BACKWARD             BWD_SYNCH: MVS_SVS               MOS
    SIMULATED_FORWARD    FWD_SYNCH: the type              MOS
    SIMULATED            FWD_SYNCH: the type              MOS

Where the path is driven again, spindles without the flag get no orders: driven backward over M5 nobody wants them to stand, and
behind it they do what they did. Driven for the first time in simulated motion they get them: the program goes on with them.

Backward the blocks run from their end to their start: waiting after the motion would be waiting at the wrong end, so whatever
the type is, the path stands before it goes on into the block before.
"""

from __future__ import annotations

from enum import Enum, auto

from runtime.cnc.blocks import Synch


class Travel(Enum):
    """How the path is driven."""

    FORWARD = auto()
    BACKWARD = auto()
    SIMULATED_FORWARD = auto()  # along the path again to where it was driven backward from
    SIMULATED = auto()  # forward for the first time, in simulated motion


def synch_in(synch: Synch, travel: Travel) -> Synch:
    """The type, with its flags, that counts for a function while the path is driven like this."""
    if travel is Travel.FORWARD or synch < 0:
        return synch
    if travel in (Travel.SIMULATED_FORWARD, Travel.SIMULATED) and synch & Synch.FWD_SYNCH:
        return synch
    if travel is Travel.BACKWARD and synch & Synch.BWD_SYNCH:
        return synch.flags | Synch.MVS_SVS
    return synch.flags | (Synch.NO_SYNCH if synch.kind == Synch.NO_SYNCH else Synch.MOS)


def reaches_spindle(synch: Synch, travel: Travel) -> bool:
    """Whether a spindle gets its order while the path is driven like this."""
    if travel in (Travel.FORWARD, Travel.SIMULATED):
        return True
    return bool(synch & (Synch.BWD_SYNCH if travel is Travel.BACKWARD else Synch.FWD_SYNCH))
