"""Variables of the manual that this version does not have: what is written with them is told as such, and not as unknown.

A name stands for itself and everything below it (V.G.WZ for V.G.WZ[1].R). The text says what it belongs to.
"""

from __future__ import annotations

import re

_STEM = re.compile(r"[.\[]")

KNOWN = {
    # tools (programming manual lines 21099–21177)
    "V.G.WZ[].GOBJECT": "graphic objects of tools",
    "V.G.WZ[].LINKPOINT": "link points of tools",
    "V.G.WZ_AKT.GOBJECT": "graphic objects of tools",
    "V.G.WZ_AKT.LINKPOINT": "link points of tools",
    "V.G.LIMIT.KIN": "limits of the tool centre point",
    # coordinate systems and kinematics (lines 21190–21314, 21453–21458)
    "V.G.BCS_COUNT_DEF": "coordinate systems",
    "V.G.BCS_COUNT_FREE_DEF": "coordinate systems",
    "V.G.BCS_COUNT_ACTIVE": "coordinate systems",
    "V.G.ACS_COUNT_DEF": "coordinate systems",
    "V.G.ACS_COUNT_FREE_DEF": "coordinate systems",
    "V.G.ACS_COUNT_ACTIVE": "coordinate systems",
    "V.G.CS_COUNT_DEF": "coordinate systems",
    "V.G.CS_COUNT_FREE_DEF": "coordinate systems",
    "V.G.CS_COUNT_ACTIVE": "coordinate systems",
    "V.G.COORD_SYS_BCS_COUNT_DEF": "coordinate systems",
    "V.G.COORD_SYS_ACS_COUNT_DEF": "coordinate systems",
    "V.G.COORD_SYS_CS_COUNT_DEF": "coordinate systems",
    "V.G.COORD_SYS_COUNT_ALL_DEF": "coordinate systems",
    "V.G.COORD_SYS_COUNT_ALL_ACTIVE": "coordinate systems",
    "V.G.KIN": "kinematics",
    "V.G.KIN_STEP": "kinematics",
    "V.G.KIN_ID": "kinematics",
    "V.G.KIN_TYPE": "kinematics",
    "V.G.KIN_ID_STEP": "kinematics",
    "V.G.KIN_TYPE_STEP": "kinematics",
    "V.G.TOTAL_KIN_OFFSET": "kinematics",
    "V.G.TRAFO_PCS": "kinematics",
    "V.G.TRAFO_PCS_ID": "kinematics",
    "V.G.TRAFO_PCS_TYPE": "kinematics",
    "V.G.TRACK_CS": "dynamic coordinate systems",
    "V.G.RETRACT_APPR_CS": "electrode retraction",
    "V.A.RETRACT_ACS_POS": "electrode retraction",
    "V.A.RETRACT_APPR_START_MCS_POS": "electrode retraction",
    "V.A.WCS": "#WCS TO MCS",
    "V.A.MCS": "#MCS TO WCS",
    "V.A.TRANSFORM": "#TRANSFORM",
    # state of the machine that the decoder is not told (lines 21212–21248, 21421–21423, 21460–21497)
    "V.G.CLAMP_LIST_INVOKE": "clamp positions",
    "V.G.SIGNAL_READ": "#SIGNAL READ",
    "V.G.CHAN_LIST_INVOKE": "loading of lists",
    "V.G.VE_VAR_LIST_INVOKE": "loading of lists",
    "V.G.ZERO_POINT_LIST_INVOKE": "loading of lists",
    "V.G.SPEED_LIMIT": "speed limit look-ahead",
    "V.G.MAX_NC_BLOCKS_AHEAD": "limits of the decoding ahead",
    "V.G.MAX_MOTION_BLOCKS_AHEAD": "limits of the decoding ahead",
    "V.G.MAX_TIME_AHEAD": "limits of the decoding ahead",
    "V.G.RW": "edge banding",
    # axes (lines 21659–21704)
    "V.A.ENCODER2_VALUE": "second encoders",
    "V.A.ANTR_TYP": "drive types",
    "V.A.TORQUE_NOM": "drive data",
}


def purpose_of(path: str) -> str:
    """What a variable of the manual belongs to, "" if the manual has none of this name."""
    for end in [match.start() for match in _STEM.finditer(path)] + [len(path)]:
        purpose = KNOWN.get(path[:end])
        if purpose is not None:
            return purpose
    return ""
