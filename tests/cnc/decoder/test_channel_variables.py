"""V.G. variables that tell the state of the channel: cycles, contour rotation, modes, flags, functions of the machine."""

from __future__ import annotations

from dataclasses import replace

import pytest

from runtime.diagnostics.catalogue import language as C  # noqa: N812 - a table of constants
from tests.cnc.decoder.programs import SETUP, decode
from tests.cnc.decoder.scripted_outside import Machine
from tests.cnc.decoder.test_variables import refused, values

# -- cycles --------------------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.var.g-cycle-parameters")
@pytest.mark.parametrize(
    ("call", "found"),
    [
        ("LL CYCLE [NAME=C @P1=5 @P200=1]", {1: 1, 2: 1, 3: 0, 4: 1, 5: 0, 6: 0, 7: 1}),
        ("L CYCLE [NAME=c.nc @P1=5 @P200=1]", {1: 1, 2: 1, 3: 0, 4: 1, 5: 0, 6: 0, 7: 1}),
        ("G800[5,,7]", {1: 1, 2: 1, 3: 0, 4: 0, 5: 0, 6: 0, 7: 1}),
        ("G80[5,,7]", {1: 1, 2: 1, 3: 0, 4: 0, 5: 0, 6: 0, 7: 1}),
    ],
)
def test_a_cycle_knows_what_it_is_and_what_it_was_given(call: str, found: dict[int, float]) -> None:
    """The subprogram that a cycle calls is no cycle itself, but sees the parameters of the cycle."""
    inner = "P6 = V.G.CYCLE_ACTIVE P7 = V.G.@P[1].VALID\nM17\n"
    body = "P1=V.G.CYCLE_ACTIVE P2=V.G.@P[1].VALID P3=V.G.@P[2].VALID P4=V.G.@P[200].VALID\nL s.nc\nM17\n"
    text = f"%L C\n{body}%M\n{call}\nP5 = V.G.CYCLE_ACTIVE\nM30"
    setup = replace(SETUP, g_programs={80: "c.nc", 800: "c.nc"})
    assert values(text, setup=setup, files={"c.nc": body, "s.nc": inner}) == found


@pytest.mark.spec("isg.var.g-cycle-parameters")
def test_validity_is_asked_in_cycles_only() -> None:
    setup = replace(SETUP, g_programs={800: "g.nc"})
    files = {"g.nc": "P2 = V.G.CYCLE_ACTIVE\nP1 = V.G.@P[1].VALID\nM17"}
    run = decode("G800\nM30", setup, files)  # a G function without values is no cycle
    assert run.parameters == {2: 0}
    assert run.problem is not None
    assert (run.problem.entry, run.problem.place.line) == (C.TRANSFER_OUTSIDE, 2)
    assert refused("P1 = V.G.@P[1].VALID") is C.TRANSFER_OUTSIDE
    for index in (0, 201):
        assert refused(f"%L C\nP1 = V.G.@P[{index}].VALID\nM17\n%M\nLL CYCLE [NAME=C]\nM30") is C.ARRAY_INDEX
    assert refused("V.G.CYCLE_ACTIVE = 1") is C.VARIABLE_READ_ONLY


@pytest.mark.spec("isg.var.g-cycle-changes-modal")
@pytest.mark.parametrize("configured", [False, True])
def test_changes_of_cycles_stay_for_a_stretch_of_the_program(configured: bool) -> None:
    """G functions, radius and feed; behind the stretch, and in the next program, the configuration holds again."""
    setup = replace(SETUP, keep_cycle_changes=configured)
    program = (
        "%L C\nG91 G18 R[@P1] F[@P1]\nM17\n%M\nG00 F100 R50\n"
        "P1=V.G.CYCLE_CHANGES_MODAL\nV.G.CYCLE_CHANGES_MODAL = TRUE\nP2=V.G.CYCLE_CHANGES_MODAL\n"
        "LL CYCLE [NAME=C @P1=7]\nP3=V.G.PROG_ABS P4=V.G.ACT_PLANE P5=V.G.FEEDRATE\nG90 G17\n"
        "V.G.CYCLE_CHANGES_MODAL = FALSE\nP6=V.G.CYCLE_CHANGES_MODAL\n"
        "LL CYCLE [NAME=C @P1=9]\nP7=V.G.PROG_ABS P8=V.G.ACT_PLANE P9=V.G.FEEDRATE\nM30"
    )
    run = decode(program, setup)
    assert run.problem is None, run.problem
    assert run.parameters == {1: configured, 2: 1, 3: 0, 4: 18, 5: 7, 6: 0, 7: 1, 8: 17, 9: 7}
    assert run.decoder.modal.radius == 7
    again = decode("P1=V.G.CYCLE_CHANGES_MODAL", setup, memory=run.decoder.execution.memory)
    assert again.parameters == {1: configured}


# -- contour rotation ----------------------------------------------------------------------------------------------

ROTATION = "P1=V.G.ROT_ACTIVE P2=V.G.ROT_ANGLE P3=V.G.ROT_CENTER1 P4=V.G.ROT_CENTER2"


@pytest.mark.spec("isg.add.rotation-variables")
@pytest.mark.parametrize(
    ("before", "found"),
    [
        ("", (0, 0, 0, 0)),
        ("#ROTATION ON [ANGLE=30 CENTER1=10 CENTER2=-4]", (1, 30, 10, -4)),
        ("#ROTATION ON [ANGLE=30 CENTER1=10 CENTER2=-4]\n#ROTATION OFF", (0, 0, 0, 0)),
        ("G70\n#ROTATION ON [ANGLE=30 CENTER1=10 CENTER2=-4]", (1, 30, 10, -4)),
        ("#ROTATION ON [ANGLE=30 CENTER1=25.4 CENTER2=0]\nG70", (1, 30, 1, 0)),
        ("G18\n#ROTATION ON [ANGLE=30 CENTER1=10 CENTER2=-4]", (1, 30, 10, -4)),
        ("G68 R45 X1 Y2", (1, 45, 1, 2)),
    ],
)
def test_the_contour_rotation_is_told(before: str, found: tuple[float, ...]) -> None:
    assert values(f"{before}\n{ROTATION}") == pytest.approx(dict(enumerate(found, 1)))


@pytest.mark.spec("isg.add.rotation-variables")
def test_a_rotation_goes_on_from_the_one_before() -> None:
    program = (
        "#ROTATION ON [ANGLE=55]\n#ROTATION ON [ANGLE=V.G.ROT_ANGLE+35]\nG00 X10\nP1=V.G.ROT_ACTIVE P2=V.G.ROT_ANGLE\n"
        "#ROTATION OFF\nM30"
    )
    run = decode(program)
    assert run.problem is None, run.problem
    assert run.ends[0] == pytest.approx([0, 10, 0], abs=1e-9)
    assert run.parameters == {1: 1, 2: 90}
    assert refused("V.G.ROT_ANGLE = 5") is C.VARIABLE_READ_ONLY


# -- state of the channel ------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.var.g-channel-state")
def test_the_channel_tells_its_state() -> None:
    setup = replace(SETUP, channel_number=3)
    program = (
        "P1=V.G.CNC_CHANNEL P2=V.G.EXECUTION_MODE P3=V.G.ACTIVE_MODE P4=V.G.TOOL_COMP P5=V.G.AKT_PLATZ\n"
        "P6=V.G.PROG_ABS P7=V.G.ACT_PLANE\nG91 G18\nP8=V.G.PROG_ABS P9=V.G.ACT_PLANE\n"
        "G90 G19\nP10=V.G.PROG_ABS P11=V.G.ACT_PLANE"
    )
    assert values(program, setup=setup) == {1: 3, 2: 0, 3: 2, 4: 0, 5: 0, 6: 1, 7: 17, 8: 0, 9: 18, 10: 1, 11: 19}


@pytest.mark.spec("isg.var.g-channel-state")
def test_counters_of_the_channel() -> None:
    """The cycle is the present one at each access; a timer keeps what its last READ has found."""
    machine = Machine()
    machine.counts = {127: 1500}
    program = (
        "P1=V.G.TIMER[127]\n#TIMER READ [ID=127]\nP2=V.G.TIMER[127] P3=V.G.TIMER[0]\nP4=V.G.IPO_COUNT\nP5=V.G.IPO_COUNT"
    )
    assert values(program, outside=machine) == {1: 0, 2: 1500, 3: 0, 4: 4712, 5: 4713}
    assert values("P1=V.G.IPO_COUNT") == {1: 0}  # no machine, no cycle
    assert refused("P1=V.G.TIMER[128]") is C.SET_INDEX


@pytest.mark.spec("isg.var.g-channel-state")
@pytest.mark.parametrize(
    "name",
    [
        "CNC_CHANNEL", "IPO_COUNT", "EXECUTION_MODE", "ACTIVE_MODE", "TOOL_COMP", "AKT_PLATZ", "TIMER[1]", "PROG_ABS",
        "ACT_PLANE",
    ],
)  # fmt: skip
def test_the_state_is_only_read(name: str) -> None:
    assert refused(f"V.G.{name} = 1") is C.VARIABLE_READ_ONLY


# -- functions that are active -------------------------------------------------------------------------------------


@pytest.mark.spec("isg.var.g-active-flags")
@pytest.mark.parametrize(
    ("flag", "on", "off"),
    [
        ("TRC_ACTIVE", "G41", "G40"),
        ("MCS_ACTIVE", "#MCS ON", "#MCS OFF"),
        ("MIRROR_ACTIVE", "G21", "G20"),
        ("MIRROR_ACTIVE", "G22", "G20"),
        ("MIRROR_ACTIVE", "G23", "G20"),
        ("MIRROR_ACTIVE", "G351 X-1", "G351 X1"),
        ("CIRCLE_CP_ABS", "G161", "G162"),
        ("HSC_ACTIVE", "#HSC ON", "#HSC OFF"),
        ("HSC_ACTIVE", "#HSC ON [BSPLINE]", "#HSC OFF"),
        ("HSC_ACTIVE", "#SPLINE ON", "G150"),
        ("SEGMENTATION_ACTIVE", "#SEGMENTATION ON ALL", "#SEGMENTATION OFF ALL"),
        ("CIRCLE_CPC_ACTIVE", "G165", "G164"),
        ("FILE_EXIST", '#FILE EXIST [PATH="here.nc"]', '#FILE EXIST [PATH="there.nc"]'),
    ],
)
def test_flags_follow_what_is_switched(flag: str, on: str, off: str) -> None:
    program = f"{on}\nP1=V.G.{flag}\n{off}\nP2=V.G.{flag}\n{on}\nP3=V.G.{flag}"
    assert values(program, files={"here.nc": "M17"}) == {1: 1, 2: 0, 3: 1}


@pytest.mark.spec("isg.var.g-active-flags")
def test_the_method_of_contouring() -> None:
    program = "P1 = V.G.CONT_MODE_ACTIVE\nG261\nP2 = V.G.CONT_MODE_ACTIVE\n"
    for number, method in enumerate(("DIST", "POS", "DIST_SOFT", "PTP"), 3):
        program += f"#CONTOUR MODE [{method}]\nP{number} = V.G.CONT_MODE_ACTIVE\n"
    assert values(f"{program}G260\nP7 = V.G.CONT_MODE_ACTIVE") == {1: 0, 2: 4, 3: 3, 4: 5, 5: 6, 6: 7, 7: 0}


@pytest.mark.spec("isg.var.g-link-rotation", "isg.var.g-active-flags")
@pytest.mark.parametrize(
    ("flag", "switches"),
    [
        ("TRAFO_ACTIVE", ("#TRAFO ON",)),
        ("OTC_ACTIVE", ("#OTC ON",)),
        ("CAXTRACK_ACTIVE", ("#CAXTRACK ON",)),
        ("LIFT_ACTIVE", ("G00 Z[LIFT POS=25]",)),
        ("STROKE_DEF_ACTIVE", ("#STROKE DEF BEGIN",)),
        ("PUNCH_ACTIVE", ("#PUNCH ON [LENGTH 5]",)),
        ("NIBBLE_ACTIVE", ("#NIBBLE ON [LENGTH 5]",)),
        ("EDM_ACTIVE", ("#EDM ON",)),
        ("FRICTION_ACTIVE", ("#FRICTION ON [X]",)),
        ("VECTOR_OFFSET_ACTIVE", ("#VECTOR OFFSET ON",)),
        ("GEAR_LINK_ACTIVE", ("#GEAR LINK ON [TARGETNR=5 AXNR1=6]",)),
        ("SINGUL_AVOID_ACTIVE", ("#SINGULARITY AVOIDANCE ON",)),
        ("BLOCK_SEARCH_ACTIVE", ()),
    ],
)
def test_what_cannot_be_switched_on_is_not_active(flag: str, switches: tuple[str, ...]) -> None:
    assert values(f"P1 = V.G.{flag}") == {1: 0}
    for switch in switches:
        assert refused(f"{switch}\nP1 = V.G.{flag}") in (C.STATEMENT_UNSUPPORTED, C.G_UNSUPPORTED, C.NOT_SUPPORTED)
    assert refused(f"V.G.{flag} = 1") is C.VARIABLE_READ_ONLY


@pytest.mark.spec("isg.var.g-link-rotation")
def test_there_are_five_groups_of_couplings() -> None:
    for group in (-1, 5):
        assert refused(f"P1 = V.G.AX_LINK_GROUP[{group}].ACTIVE") is C.SET_INDEX


@pytest.mark.spec("isg.var.g-link-rotation")
def test_rotation_is_told_beside_couplings() -> None:
    program = f"#ROTATION ON [ANGLE=-15.5 CENTER1=3 CENTER2=4]\n{ROTATION}\n#ROTATION OFF\nP5=V.G.ROT_ACTIVE"
    assert values(program) == {1: 1, 2: -15.5, 3: 3, 4: 4, 5: 0}
