"""Micro-joints: where functions are put out that are moved back on the path, what stops them, and the feed of the joint."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.cnc.blocks import (
    Arc,
    Block,
    BlockEnd,
    DynamicsChange,
    Floats,
    Line,
    Polyline,
    Polynomials,
    Synch,
    TechnologyFunction,
    Wait,
)
from runtime.cnc.decoder.setup import DecoderSetup
from runtime.cnc.dynamic_settings import NO_LIMITS
from runtime.cnc.path_preparation import MicroJoints, MicroJointSettings, PathError, smooth
from runtime.cnc.path_preparation.element_lengths import MOTIONS, element_ends, element_lengths
from runtime.diagnostics.catalogue import machine
from runtime.diagnostics.catalogue import technology as T  # noqa: N812
from runtime.diagnostics.errors import Problem
from tests.cnc.decoder.programs import SETUP as PLAIN
from tests.cnc.decoder.programs import decode, problems
from tests.cnc.interpolator.driving import limits

JOINTS = MicroJointSettings()
PLACE = st.floats(-20.0, 20.0)
TYPES = {100: Synch.MOS, 200: Synch.MVS_SVS, 300: Synch.MVS_SNS, 400: Synch.MNS_SNS, 500: Synch.MOS_TS, 26: Synch.MOS}
SETUP = replace(PLAIN, micro_joints=True, m_synch={**PLAIN.m_synch, **TYPES}, h_synch={20: Synch.MOS}, feed=1000.0)


class Prepared:
    """A program behind the stage; `out`: way along the path at which each function is put out."""

    def __init__(
        self, text: str, settings: MicroJointSettings = JOINTS, setup: DecoderSetup = SETUP, *, smoothed: bool = False
    ) -> None:
        run = decode(f"%T\n{text}\nM30\n", setup)
        assert run.problem is None, run.problem.explained()
        blocks = run.blocks
        if smoothed:
            blocks = list(smooth(iter(blocks), limits(250.0, 2000.0, 50_000.0, 0.0, 3)))
        self.plain = blocks
        self.warnings: list[Problem] = []
        self.blocks: list[Block] = list(MicroJoints(settings, self.warnings)(iter(blocks)))

    @property
    def out(self) -> dict[int, float]:
        way, found = 0.0, {}
        for block in self.blocks:
            if isinstance(block, MOTIONS):
                way += float(element_lengths(block).sum())
            elif isinstance(block, TechnologyFunction):
                assert block.lead == 0.0
                found[block.number] = way
        return found

    @property
    def motions(self) -> list[Line | Arc | Polyline | Polynomials]:
        return [block for block in self.blocks if isinstance(block, MOTIONS)]

    def shown(self) -> list[str]:
        """Lines by their end in X and Y, functions, waits, ends of blocks."""
        shown = []
        for block in self.blocks:
            if isinstance(block, TechnologyFunction):
                shown.append(f"M{block.number}")
            elif isinstance(block, Wait):
                shown.append("wait")
            elif isinstance(block, BlockEnd):
                shown.append("end")
            elif isinstance(block, MOTIONS):
                shown += [f"{end[0]:g} {end[1]:g}" for end in element_ends(block)]
        return shown


def lead(number: int, way: float, synch: int | None = None) -> str:
    kind = "" if synch is None else f"V.G.M_FCT[{number}].SYNCH = {synch}\n"
    return f"V.G.M_FCT[{number}].PRE_OUTP_PATH = {way}\n{kind}"


@pytest.mark.spec("cut.microjoint.pre-output", "chan.mh.microjoint")
def test_a_bridge_stays_between_a_function_moved_back_and_one_at_its_place() -> None:
    found = Prepared(lead(500, 0.05) + "G00 G90 X0 Y0\nG01 F5000\nY7\nM500 M26\nY10\nX14\nX20")
    assert found.out[500] == pytest.approx(6.95)
    assert found.out[26] == pytest.approx(7.0)
    line = next(block for block in found.motions if isinstance(block, Line) and block.end[1] == pytest.approx(6.95))
    assert line.feed == 5000.0
    assert line.end_pcs[1] == pytest.approx(6.95)


@pytest.mark.spec("cut.microjoint.pre-output", "chan.mh.microjoint")
def test_the_lead_counts_along_the_path_over_blocks_and_directions() -> None:
    found = Prepared(lead(100, 12.0) + "G01 X10 F500\nY5\nG02 X15 Y0 I0 J-5\nG01 X20\nM100\nX30")
    quarter = math.pi * 5.0 / 2.0
    assert found.out[100] == pytest.approx(10.0 + 5.0 + quarter + 5.0 - 12.0)
    arcs = [block for block in found.motions if isinstance(block, Arc)]
    assert sum(arc.radius * math.radians(abs(arc.angle)) for arc in arcs) == pytest.approx(quarter)
    inside = Prepared(lead(100, 6.0) + "G01 X10 F500\nY5\nG02 X15 Y0 I0 J-5\nG01 X20\nM100\nX30")
    first, second = (block for block in inside.motions if isinstance(block, Arc))
    assert math.radians(abs(second.angle)) * 5.0 == pytest.approx(1.0)
    assert first.end == pytest.approx(second.start)
    assert np.hypot(first.end[0] - 10.0, first.end[1]) == pytest.approx(5.0)


@pytest.mark.spec("cut.microjoint.pre-output")
@pytest.mark.parametrize("way", [6.0, 10.0, 10.3])
def test_a_corner_that_contouring_has_rounded_is_cut_where_the_way_says(way: float) -> None:
    text = lead(100, way) + "G261 G01 X10 F500\nY10\nM100 M26\nX20\nX30"
    found = Prepared(text, smoothed=True)
    assert any(isinstance(block, Polynomials) for block in found.motions)
    assert found.out[26] - found.out[100] == pytest.approx(way, abs=1e-4)
    before, after = points(found.plain), points(found.blocks)
    assert len(after) >= len(before)
    for place in before:
        assert np.abs(after - place).max(axis=1).min() < 1e-6


@pytest.mark.spec("cut.microjoint.reference-position", "chan.mh.microjoint")
@pytest.mark.parametrize(("number", "place", "waits"), [(100, 15.0, 0), (200, 15.0, 1), (500, 15.0, 0), (400, 55.0, 1)])
def test_the_lead_counts_from_the_begin_of_the_block_and_of_mns_sns_from_its_end(
    number: int, place: float, waits: int
) -> None:
    found = Prepared(lead(number, 25.0) + f"G01 X10 F5000\nX20\nX30\nX40\nM{number} X80\nX0")
    assert found.out[number] == pytest.approx(place)
    shown = found.shown()
    at = shown.index(f"M{number}")
    assert (shown[at + 1] == "wait") is bool(waits)
    assert shown.count("wait") == waits, "nothing is waited for where the function was programmed"
    assert shown[at - 1] == f"{place:g} 0", "cut there"


@pytest.mark.spec("cut.microjoint.reference-position")
def test_mvs_sns_waits_at_the_end_of_the_block_that_was_cut_and_at_a_border_at_once() -> None:
    cut = Prepared(lead(300, 25.0) + "G01 X10 F5000\nX20 E100\nX30\nX40\nM300 X80").shown()
    assert cut[cut.index("M300") - 1 : cut.index("M300") + 4] == ["15 0", "M300", "20 0", "wait", "end"]
    border = Prepared(lead(300, 20.0) + "G01 X10 F5000\nX20 E100\nX30\nX40\nM300 X80").shown()
    at = border.index("M300")
    assert border[at - 2 : at + 3] == ["20 0", "end", "M300", "wait", "30 0"]


@pytest.mark.spec("cut.microjoint.parameterisation")
def test_several_functions_of_a_block_keep_their_own_leads() -> None:
    text = lead(100, 11.0) + lead(200, 12.0) + lead(400, 23.0) + "V.G.H_FCT[20].PRE_OUTP_PATH = 4\n"
    found = Prepared(text + "G01 X100 F500\nX200 M100 M200 H20 M400\nX300")
    assert (found.out[100], found.out[200], found.out[20]) == pytest.approx((89.0, 88.0, 96.0))
    assert found.out[400] == pytest.approx(177.0)


@pytest.mark.spec("cut.microjoint.parameterisation", "cut.microjoint.enable", "chan.mh.microjoint")
def test_leads_of_the_lists_are_tenths_of_a_micrometre_and_the_type_stays() -> None:
    setup = replace(SETUP, m_ahead={100: 50_000}, h_ahead={20: 20_000})
    found = Prepared("G01 X10 F500\nM100 H20\nX20", setup=setup)
    assert (found.out[100], found.out[20]) == pytest.approx((5.0, 8.0))
    read = decode(
        "%T\nV.G.M_FCT[200].PRE_OUTP_PATH = 3\nP1=V.G.M_FCT[200].SYNCH P2=V.G.M_FCT[200].PRE_OUTP_PATH\nM30\n", SETUP
    )
    assert read.problem is None
    assert read.parameters == {1: 2.0, 2: 3.0}


BLOCKS = "G91\n" + "".join(f"Y1 (block {k})\n" for k in range(30))


@pytest.mark.spec("cut.microjoint.lookahead-limit", "chan.mh.microjoint-lookahead")
@pytest.mark.parametrize("dressed", ["", " E100"])
def test_a_function_comes_back_over_so_many_blocks_at_most(dressed: str) -> None:
    """Plain blocks are a run of moves, those with an end feed are single lines."""
    blocks = BLOCKS.replace(" (", f"{dressed} (")
    found = Prepared(lead(100, 28.6) + f"G01 F1000\n{blocks}M100 M26")
    assert found.out[100] == pytest.approx(20.0)
    assert found.out[26] == pytest.approx(30.0)
    assert [problem.entry for problem in found.warnings] == [T.JOINT_SHORT]
    more = Prepared(lead(100, 28.6) + f"G01 F1000\n{blocks}M100 M26", replace(JOINTS, blocks=30))
    assert more.out[100] == pytest.approx(1.4)
    assert not more.warnings


@pytest.mark.spec("chan.mh.microjoint-lookahead")
def test_with_a_distance_fewer_blocks_are_kept_but_a_lead_within_it_is_always_possible() -> None:
    text = "G01 F1000 G91\n" + "Y1 E500\n" * 8 + "M100 M26"
    assert Prepared(lead(100, 3.5) + text, replace(JOINTS, most=3.5)).out[100] == pytest.approx(4.5)
    assert Prepared(lead(100, 6.5) + text, replace(JOINTS, most=3.5)).out[100] == pytest.approx(4.0)


@pytest.mark.spec("cut.microjoint.flush-limit")
@pytest.mark.parametrize("barrier", ["#FLUSH", "#FLUSH WAIT", "M00"])
def test_a_function_comes_back_to_a_flush_at_most(barrier: str) -> None:
    found = Prepared(lead(100, 8.6) + f"G01 F1000 G91\nY1\nY1\nY1\n{barrier}\nY1\nY1\nM100 M26")
    assert found.out[100] == pytest.approx(3.0)
    assert found.out[26] == pytest.approx(5.0)


@pytest.mark.spec("cut.microjoint.overlap")
def test_functions_come_back_to_the_place_of_the_one_before_at_most() -> None:
    text = lead(100, 5.0) + lead(200, 23.0) + lead(500, 31.0)
    found = Prepared(text + "G01 G90 F10000\nX10\nM100 M26\nX30\nM200 M26\nX40\nM500 M26")
    assert (found.out[100], found.out[200], found.out[500]) == pytest.approx((5.0, 10.0, 30.0))


@pytest.mark.spec("cut.microjoint.mvs-sns")
@pytest.mark.parametrize("number", [100, 300])
def test_nothing_comes_into_a_block_that_is_waited_at_the_end_of(number: int) -> None:
    text = "V.G.M_FCT[12].PRE_OUTP_PATH = 0\n" + lead(number, 6.0)
    found = Prepared(text + f"G01 F1000\nX10 M12\nX15\nM{number} X20")
    assert found.out[12] == 0.0
    assert found.out[number] == pytest.approx(10.0)
    alone = Prepared(text + f"G01 F1000\nX10\nM12\nX15\nM{number} X20")
    assert alone.out[number] == pytest.approx(9.0), "behind a function without motion nothing is waited for any more"


@pytest.mark.spec("cut.microjoint.mvs-sns")
def test_mns_sns_with_a_lead_beside_one_without() -> None:
    types = replace(SETUP, m_synch={**SETUP.m_synch, 201: Synch.MNS_SNS})
    found = Prepared(lead(400, 25.6) + "G01 F10000\nX10\nX30 M400 M201\nX40", setup=types)
    assert found.out[400] == pytest.approx(4.4)
    assert found.out[201] == pytest.approx(30.0)


@pytest.mark.spec("cut.microjoint.tolerance")
def test_a_place_that_is_missed_by_more_than_the_tolerance_ends_the_program() -> None:
    text = lead(100, 6.0) + "G01 F1000\nX5\nM100\nX10"
    with pytest.raises(PathError) as caught:
        Prepared(text, replace(JOINTS, tolerance=0.5))
    (problem,) = caught.value.problems
    assert problem.entry is machine.PRE_OUTPUT_LATE
    assert problem.entry.id == 120815
    assert "1.0000 mm" in problem.text
    within = Prepared(text, replace(JOINTS, tolerance=1.5))
    assert within.out[100] == 0.0
    assert not within.warnings


@pytest.mark.spec("cut.microjoint.feed")
def test_the_feed_of_a_joint_holds_from_the_output_to_the_programmed_place() -> None:
    text = "#CHANNEL SET [M_PRE_OUTPUT E=20 F=5000]\n" + lead(100, 8.0)
    found = Prepared(text + "G01 F100\nG91 Y1\nY5\nY5 F70\nM100\nY3\nM100\nY1")
    feeds = [
        (float(element_ends(m)[-1][1]), float(np.atleast_1d(getattr(m, "feeds", getattr(m, "feed", 0.0)))[-1]))
        for m in found.motions
    ]
    assert feeds[:4] == [(1.0, 100.0), (3.0, 100.0), (6.0, 5000.0), (11.0, 5000.0)]
    assert all(feed == 70.0 for _, feed in feeds[4:]), "for one joint only"
    before = next(m for m in found.motions if float(element_ends(m)[-1][1]) == 3.0)
    assert isinstance(before, Line)
    assert before.end_feed == 20.0


@pytest.mark.spec("cut.microjoint.feed")
def test_at_a_border_the_block_before_ends_with_the_feed_of_the_joint() -> None:
    found = Prepared("#CHANNEL SET [M_PRE_OUTPUT E=20]\n" + lead(100, 5.0) + "G01 F100\nG91 Y1\nY5\nM100\nY3")
    before = next(m for m in found.motions if float(element_ends(m)[-1][1]) == 1.0)
    assert isinstance(before, Line)
    assert before.end_feed == 20.0
    shown = found.shown()
    assert shown[shown.index("0 1") + 1 : shown.index("0 1") + 3] == ["end", "M100"]


@pytest.mark.spec("cut.microjoint.feed")
def test_limits_along_the_path_are_lifted_in_the_joint_only() -> None:
    text = "#VECTOR LIMIT ON [VEL=600]\n#CHANNEL SET [M_PRE_OUTPUT VECTOR_LIMIT_OFF]\n" + lead(100, 8.0)
    found = Prepared(text + "G01 F1000 X5\nX10\nX20\nM100 M26\nX30")
    seen = []
    vector = NO_LIMITS
    for block in found.blocks:
        if isinstance(block, DynamicsChange):
            vector = block.settings.feed.vector
        elif isinstance(block, MOTIONS):
            seen += [(float(end[0]), vector == NO_LIMITS) for end in element_ends(block)]
    assert seen == [(5.0, False), (10.0, False), (12.0, False), (20.0, True), (30.0, False)]


@pytest.mark.parametrize(
    ("text", "entry"),
    [
        ("#CHANNEL SET [M_PRE_OUTPUT F=0]", T.JOINT_FEED),
        ("#CHANNEL SET [M_PRE_OUTPUT E=-1]", T.JOINT_FEED),
        (lead(100, 1.0, 0x20) + "G01 X1 F1 M100", T.JOINT_BARRED),
    ],
)
@pytest.mark.spec("cut.microjoint.feed")
def test_what_is_refused(text: str, entry: object) -> None:
    assert [problem.entry for problem in problems(f"%T\n{text}\nM30\n", SETUP)] == [entry]


@pytest.mark.spec("cut.microjoint.enable")
def test_functions_of_an_axis_and_channels_without_micro_joints_are_refused() -> None:
    text = "%T\nG01 X1 F1 M100\nM30\n"
    off = replace(SETUP, micro_joints=False, m_ahead={100: 1})
    assert [problem.entry for problem in problems(text, off)] == [T.MICRO_JOINT]
    axis = replace(SETUP, m_ahead={100: 1}, m_area={100: 0})
    assert [problem.entry for problem in problems(text, axis)] == [T.JOINT_BARRED]
    useless = "%T\n#CHANNEL SET [M_PRE_OUTPUT F=5]\nM30\n"
    assert [problem.entry for problem in problems(useless, off)] == [T.JOINT_FEED_USELESS]


@given(
    st.lists(st.tuples(PLACE, PLACE, st.sampled_from(["", " E50", " M26"])), min_size=1, max_size=8),
    st.floats(0.001, 60.0),
    st.sampled_from([100, 200, 300, 400]),
)
@settings(deadline=None)
def test_whatever_is_cut_the_path_stays_the_same(legs: list[tuple[float, float, str]], way: float, number: int) -> None:
    """The same places in the same order, with one more; the function lies where its lead says, or at the begin."""
    blocks = "".join(f"G01 X{x:.3f} Y{y:.3f}{more}\n" for x, y, more in legs)
    found = Prepared(f"{lead(number, round(way, 3))}{blocks}M{number}\nX0", replace(JOINTS, blocks=20))
    plain = points(found.plain)
    cut = points(found.blocks)
    assert length(cut) == pytest.approx(length(plain), abs=1e-6)
    for place in plain:
        assert np.abs(cut - place).max(axis=1).min() < 1e-9
    at = next(i for i, b in enumerate(found.plain) if isinstance(b, TechnologyFunction) and b.number == number)
    total = length(points(found.plain[:at]))
    assert found.out[number] == pytest.approx(max(total - round(way, 3), 0.0), abs=1e-5)


def points(blocks: list[Block]) -> Floats:
    ends = [element_ends(block) for block in blocks if isinstance(block, MOTIONS)]
    return np.vstack([np.zeros((1, 3)), *ends])


def length(path: Floats) -> float:
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
