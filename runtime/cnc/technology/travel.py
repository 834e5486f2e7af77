"""What becomes of a synchronisation type when the path is not driven forward from block to block (channel parameters 1854–1855).

    direction            with its flag                    without
    ──────────────────   ──────────────────────────────   ───────────
    FORWARD              the type                         the type
    BACKWARD             BWD_SYNCH: MVS_SVS               NO_SYNCH
    SIMULATED_FORWARD    FWD_SYNCH: the type              NO_SYNCH

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


def synch_in(synch: Synch, travel: Travel) -> Synch:
    """The type, with its flags, that counts for a function while the path is driven like this."""
    if travel is Travel.FORWARD or synch < 0:
        return synch
    if travel is Travel.BACKWARD:
        return synch.flags | (Synch.MVS_SVS if synch & Synch.BWD_SYNCH else Synch.NO_SYNCH)
    return synch if synch & Synch.FWD_SYNCH else synch.flags
