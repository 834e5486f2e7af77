"""Measuring blocks as the decoder sees them: what they need, what they put out, and what the variables say behind them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from runtime.cnc.blocks import (
    Block,
    DynamicsChange,
    Flush,
    FlushKind,
    Line,
    Measurement,
    MeasurementEnd,
    PathRestart,
    Probe,
    ProbeSignal,
)
from runtime.cnc.decoder import ChannelMemory
from runtime.cnc.decoder.measuring_setup import AxisProbe, MeasuringChannel
from runtime.cnc.dynamic_settings import HoldUse
from runtime.cnc.tools.table import MemoryTools
from runtime.cnc.tools.tool import Tool
from runtime.diagnostics.catalogue import axes, language, radius
from runtime.diagnostics.catalogue import measuring as errors
from runtime.diagnostics.errors import ErrorEntry
from tests.cnc.decoder.programs import SETUP, decode
from tests.cnc.decoder.scripted_outside import Machine

DRIVE = AxisProbe(ProbeSignal.DRIVE, latched=frozenset({(1, True), (2, False)}))
INPUT = AxisProbe(ProbeSignal.INPUT, level=9)
FED = AxisProbe(ProbeSignal.PLC, feed=120.0)


def setup(*probes: AxisProbe | None, **channel: Any) -> Any:
    """X, Y, Z with these probes; the parameters of the channel."""
    given = (*probes, None, None, None)[:3]
    limits = channel.pop("limits", ((-50.0, 100.0),) * 3)
    numbers = channel.pop("log_axes", (1, 2, 3))
    return replace(SETUP, measuring=MeasuringChannel(given, **channel), position_limits=limits, log_axes=numbers)


class Probed(Machine):
    """The machine answers: the runs end where `ends` says, with what was `found`."""

    def __init__(self, ends: list[list[float]], found: list[dict[int, float]]) -> None:
        super().__init__()
        self.ends, self.found = ends, found
        self.run = -1

    def command_position(self) -> Any:
        return np.array(self.ends[self.run])

    def measured(self) -> dict[int, float]:
        self.run += 1
        return self.found[self.run]

    def manual_offsets(self) -> Any:
        return np.zeros(3)


def of(kind: type[Block], blocks: list[Block]) -> list[Any]:
    return [block for block in blocks if isinstance(block, kind)]


def refused(text: str, *probes: AxisProbe | None, **channel: Any) -> ErrorEntry | None:
    run = decode(f"G90 G01 F600\n{text}\nM30", setup(*(probes or (DRIVE, DRIVE, None)), **channel))
    return run.problem.entry if run.problem else None


@pytest.mark.spec("isg.g.measuring-framework")
def test_a_run_is_a_line_between_two_gates_and_the_decoder_waits_behind_it() -> None:
    run = decode("G90 G01 X1 F600\nN20 G100 X10 Y20 F200\nX5\nM30", setup(DRIVE, INPUT))
    assert run.problem is None
    wanted = (Measurement, MeasurementEnd, Flush, Line)
    kinds = [type(b) for b in run.blocks if isinstance(b, wanted) and b.source.line == 2]
    assert kinds == [Flush, Measurement, Line, MeasurementEnd, Flush]
    begin, end = of(Flush, run.blocks)
    assert (begin.kind, end.kind) == (FlushKind.CONTINUE, FlushKind.WAIT)
    (measurement,) = of(Measurement, run.blocks)
    assert measurement.probes == (
        Probe(0, ProbeSignal.DRIVE, 1, -1, True),
        Probe(1, ProbeSignal.INPUT, 1, 9, True),
    )
    line = next(b for b in of(Line, run.blocks) if b.source.line == 2)
    assert line.end.tolist() == [10.0, 20.0, 0.0]
    assert line.feed == 200.0
    assert not line.rapid


@pytest.mark.spec("isg.g.measure-type1", "isg.var.a-measuring")
def test_the_program_goes_on_where_the_path_stands() -> None:
    """The figure of the manual at line 3344: X10 Y10 is not come to, then X7 leads from where the run has ended."""
    machine = Probed([[8.2, 6.4, 0.0]], [{0: 8.0}])
    run = decode(
        "G90 G00 X0 Y0 Z0\nX5\nN30 G100 X10 Y10 F500\nP1=V.A.MERF.X P2=V.A.MERF.Y P3=V.A.MESS.X P4=V.A.MOFFS.X P5=V.A.MESS.Y\n"
        "P6=V.A.ABS.X P7=V.A.ABS.Y\nN40 G01 X7\nM30",
        setup(DRIVE, DRIVE),
        outside=machine,
    )
    assert run.problem is None
    assert run.parameters == {1: 1, 2: 0, 3: 8.0, 4: -2.0, 5: 0.0, 6: 8.2, 7: 6.4}
    last = of(Line, run.blocks)[-1]
    assert len(of(PathRestart, run.blocks)) == 1
    assert run.ends[-1] == [7.0, 6.4, 0.0]
    assert last is not None


@pytest.mark.spec("chan.meas.values", "isg.var.a-measuring")
def test_only_the_axes_of_the_block_are_updated_and_offsets_are_left_out_of_the_programmed_value() -> None:
    machine = Probed([[98.5, 0, 0], [98.5, 31, 0]], [{0: 98.0}, {0: 98.0, 1: 30.0}])
    run = decode(
        "N10 G90 G92 X50 G01 F100\nN20 G100 X50\nN30 G90 G92 X0\nP1=V.A.MESS.X P2=V.A.MOFFS.X P3=V.A.MEAS.PCS.VALUE.X\n"
        "N40 G100 Y40\nP4=V.A.MESS.X P5=V.A.MERF.X P6=V.A.MESS.Y P7=V.A.MEAS.ACS.VALUE.Y P8=V.A.MERF.Y P9=V.A.MEIN.X\nM30",
        setup(DRIVE, DRIVE),
        outside=machine,
    )
    assert run.problem is None
    assert run.parameters == {1: 98, 2: -2, 3: 48, 4: 98, 5: 1, 6: 30, 7: 30, 8: 1, 9: 0}


@pytest.mark.spec("chan.meas.values")
@pytest.mark.parametrize(("includes", "expected"), [(True, (8.0 + 1.5, 6.0 + 2.0)), (False, (8.0, 6.0))])
def test_the_ball_lies_in_the_direction_of_the_run(includes: bool, expected: tuple[float, float]) -> None:
    """A run along (3, 4): a ball of radius 2.5 adds (1.5, 2)."""
    machine = Probed([[9, 6.5, 0]], [{0: 8.0, 1: 6.0}])
    channel = setup(DRIVE, DRIVE, includes_ball=includes)
    run = decode(
        "D1\nG90 G01 F100\nG100 X30 Y40\nP1=V.A.MEAS.PCS.VALUE.X P2=V.A.MEAS.PCS.VALUE.Y P3=V.A.MESS.X\nM30",
        channel,
        outside=machine,
        memory=ChannelMemory(channel, MemoryTools((Tool(1, radius=2.5),))),
    )
    assert run.problem is None
    assert (run.parameters[1], run.parameters[2]) == pytest.approx(expected)
    assert run.parameters[3] == 8.0


@pytest.mark.spec("chan.meas.values")
@pytest.mark.parametrize(
    ("found", "command", "programmed"),
    [
        ({0: -1.0, 1: 20.0}, False, (20.0, 1.0)),
        ({1: 20.0}, False, (0.0, 0.0)),  # and a warning
        ({1: 20.0}, True, (20.0, 0.0)),
        ({}, True, (0.0, 0.0)),
    ],
)
def test_a_rotated_plane_needs_both_of_its_axes(
    found: dict[int, float], command: bool, programmed: tuple[float, float]
) -> None:
    """Rotated by 90 degrees programmed X is machine Y, and programmed Y is machine -X; Y alone moves."""
    run = decode(
        "G90 G01 F100\n#ROTATION ON [ANGLE 90]\nG100 X30\nP1=V.A.MEAS.PCS.VALUE.X P2=V.A.MEAS.PCS.VALUE.Y P3=V.A.MESS.Y\nM30",
        setup(DRIVE, DRIVE, command_counts=command),
        outside=Probed([[0, 21, 0]], [found]),
    )
    assert run.problem is None
    (measurement,) = of(Measurement, run.blocks)
    assert [probe.axis for probe in measurement.probes] == [0, 1]
    assert (run.parameters[1], run.parameters[2]) == pytest.approx(programmed, abs=1e-9)
    assert run.parameters[3] == found.get(1, 0.0)
    warned = [warning.entry for warning in run.decoder.warnings]
    assert warned.count(errors.NO_PCS_VALUE) == (1 if len(found) == 1 and not command else 0)


@pytest.mark.spec("isg.g.measuring-offset-g101-g102")
def test_g101_takes_the_offset_in_and_g102_takes_out_what_went_in() -> None:
    machine = Probed([[8, 0, 0], [8, 19, 0], [9.5, 19, 0]], [{0: 8.0}, {1: 19.5}, {0: 9.0}])
    run = decode(
        "G90 G01 F100\nG100 X10\nG100 Y20\nG101 X1 Y7\nP1=V.A.MEIN.X P2=V.A.MEIN.Y\nX0 Y0\nP3=V.A.ABS.X P4=V.A.ABS.Y\n"
        "G100 X10\nP5=V.A.MOFFS.X P6=V.A.MEIN.X\nG102 X1\nX0\nP7=V.A.ABS.X P8=V.A.ABS.Y P9=V.A.MEIN.X\nG102\n"
        "X0 Y0\nP10=V.A.ABS.Y\nM30",
        setup(DRIVE, DRIVE),
        outside=machine,
    )
    assert run.problem is None
    p = run.parameters
    assert (p[1], p[2], p[3], p[4]) == (-2.0, -3.5, -2.0, -3.5)
    assert (p[5], p[6]) == (9.0 - (10.0 - 2.0), -2.0)  # the target of the second run has the offset in it
    assert (p[7], p[8], p[9], p[10]) == (0.0, 19.0, 0.0, 0.0)


@pytest.mark.spec("isg.g.measuring-offset-g101-g102")
def test_offsets_of_axes_without_them_are_refused() -> None:
    assert refused("G101 X1") is errors.NOT_MEASURED
    assert refused("G102 X1") is errors.NO_OFFSET
    assert refused("G102") is None


@pytest.mark.spec("isg.var.g-active-flags", "isg.g.measuring-framework")
def test_the_type_is_chosen_and_goes_back_to_the_configured_one() -> None:
    text = "P1=V.G.MEAS_TYPE\n#MEAS MODE[2]\nP2=V.G.MEAS_TYPE\n#MEAS MODE\nP3=V.G.MEAS_TYPE\n"
    text += "#MEAS [TYPE=1]\nP4=V.G.MEAS_TYPE\nM30"
    run = decode(text, setup(DRIVE, type=3))
    assert run.problem is None
    assert run.parameters == {1: 3, 2: 2, 3: 3, 4: 1}
    assert refused("#MEAS MODE[9]") is errors.TYPE_UNKNOWN
    assert refused("#MEAS MODE[0]") is errors.TYPE_UNKNOWN
    assert refused("#MEAS MODE[1.5]") is errors.TYPE_UNKNOWN
    assert refused("#MEAS MODE[7]") is errors.TYPE_UNSUPPORTED
    assert refused("G100 X5", type=5) is errors.TYPE_UNSUPPORTED


@pytest.mark.spec("isg.g.measuring-framework")
@pytest.mark.parametrize(
    ("text", "entry"),
    [
        ("G100 X10 Z5", errors.NOT_MEASURING),
        ("G100 F100", errors.AXES_MISSING),
        ("G100 X0", errors.NO_WAY),
        ("G261\nG100 X10", errors.BARRED),
        ("#SPLINE ON\nG100 X10", errors.BARRED),
        ("#HSC ON\nG100 X10", errors.BARRED),
        ("G95 F1 S100 M3\nG100 X10", errors.BARRED),
        ("G41\nX5\nG100 X10", radius.FORBIDDEN),
        ("G100 X10 I5", errors.BESIDE),
        ("G100 X10 #RND=2", errors.BESIDE),
        ("G100 X10 E100", errors.BESIDE),
        ("G100 G106 X10", errors.G106_ALONE),
        ("#MEAS MODE[3]\nG106 X10", errors.G106_ALONE),
        ("#MEAS MODE[2]\nG100 X1 Y2", errors.ONE_AXIS),
        ("#MEAS MODE[2]\nG100 X1", errors.FEED_MISSING),
        ("#MEAS [SIMU_OFFSET=1]", errors.SOURCE_UNSUPPORTED),
        ("#MEAS [TRIGGER]", errors.SOURCE_UNSUPPORTED),
        ("#MEAS [AX=X G107]", errors.SOURCE_UNSUPPORTED),
        ("#MEAS [AX=X SIGNAL=FIXED_STOP]", errors.SOURCE_UNSUPPORTED),
        ("#MEAS [AX=X INPUT=3]", errors.SOURCE_UNSUPPORTED),
        ("#MEAS [AX=Z SIGNAL=PLC]", errors.NOT_MEASURING),
        ("#MEAS [AXNR=3 SIGNAL=PLC]", errors.NOT_MEASURING),
        ("#MEAS [AXNR=7 SIGNAL=PLC]", language.LOGICAL_AXIS),
        ("#MEAS [SIGNAL=PLC]", errors.KEYS_TOGETHER),
        ("#MEAS [ERR_NO_SIGNAL=2]", language.FLAG_VALUE),
        ("#MEAS [AX=X EDGE=NEG]\nG100 X10", errors.PROBE_UNKNOWN),
        ("G100 X[-90]", None),  # the software limits stand behind the decoder
    ],
)
def test_what_is_refused(text: str, entry: ErrorEntry | None) -> None:
    assert refused(text) is entry


@pytest.mark.spec("isg.g.measure-type4")
def test_type_4_takes_main_axes_only() -> None:
    wide = replace(
        setup(DRIVE, DRIVE, DRIVE),
        axes=("X", "Y", "Z", "A"),
        linear=(True,) * 4,
        position_limits=((None, None),) * 4,
        zero_offsets={},
        log_axes=(1, 2, 3, 4),
        measuring=MeasuringChannel((DRIVE,) * 4, type=4),
    )
    good = decode("G90 G01 F100\nG100 X1 Y1 Z1\nM30", wide, start=(0.0,) * 4)
    assert good.problem is None
    bad = decode("G90 G01 F100\nG100 X1 A1\nM30", wide, start=(0.0,) * 4)
    assert bad.problem is not None
    assert bad.problem.entry is errors.MAIN_AXES_ONLY
    coupled = decode("G90 G01 F100\n#AX LINK [1, A=X]\n#AX LINK ON [1]\nG100 Y1\nM30", wide, start=(0.0,) * 4)
    assert coupled.problem is not None
    assert coupled.problem.entry is axes.COUPLING_ACTIVE


@pytest.mark.spec("isg.g.measure-type2", "isg.g.measure-type3-g106")
def test_types_2_and_3() -> None:
    run = decode("G90 G00 X1\n#MEAS MODE[2]\nG100 X10 F7\n#MEAS MODE[3]\nG100 G106 X20 F200\nG100 X30\nM30", setup(FED))
    assert run.problem is None
    assert [b.feed for b in of(Line, run.blocks) if not b.rapid] == [120.0, 200.0, 200.0]
    assert [(m.through, m.signal_needed) for m in of(Measurement, run.blocks)] == [
        (False, True),
        (True, False),
        (False, False),
    ]


def test_the_parameters_of_axes_hold_until_they_are_reset() -> None:
    text = (
        "G90 G01 F100\n#MEAS [AX=X AX=Y SIGNAL=DRIVE EDGE=NEG INPUT=2]\nG100 X1 Y1\n"
        "#MEAS [AXNR=1 SIGNAL=PLC EDGE=POS ERR_NO_SIGNAL=1]\nG100 X2 Y2\n"
        "#MEAS DEFAULT [AX=Y]\nG100 X3 Y3\n#MEAS DEFAULT\n#MEAS PREPARE [AXNR=1]\nG100 X4 Y4\nM30"
    )
    run = decode(text, setup(DRIVE, replace(INPUT, latched=DRIVE.latched)))
    assert run.problem is None
    seen = [[(p.signal.name, p.number, p.rising) for p in m.probes] for m in of(Measurement, run.blocks)]
    low, plc = ("DRIVE", 2, False), ("PLC", 2, True)
    own, own_y = ("DRIVE", 1, True), ("INPUT", 1, True)
    assert seen == [[low, low], [plc, low], [plc, own_y], [own, own_y]]
    assert [m.signal_needed for m in of(Measurement, run.blocks)] == [False, True, True, True]
    configured = decode(
        "G90 G01 F100\nG100 X1\n#MEAS [ERR_NO_SIGNAL=0]\nG100 X2\nM30", setup(DRIVE, error_no_signal=True)
    )
    assert [m.signal_needed for m in of(Measurement, configured.blocks)] == [True, False]


@pytest.mark.spec("chan.meas.travel-limit")
def test_a_run_ends_at_the_software_limits_where_the_channel_says_so() -> None:
    """From X0 Y0 towards X200 Y100, where X may go to 100: half of the way."""
    run = decode("G90 G01 F100\nG100 X200 Y80\nG100 X-50 Y0\nM30", setup(DRIVE, DRIVE, within_limits=True))
    assert run.problem is None
    assert run.ends == [[100.0, 40.0, 0.0], [-50.0, 0.0, 0.0]]
    assert [m.limited for m in of(Measurement, run.blocks)] == [True, False]
    plain = decode("G90 G01 F100\nG100 X200 Y80\nM30", setup(DRIVE, DRIVE))
    assert plain.ends == [[200.0, 80.0, 0.0]]
    assert [m.limited for m in of(Measurement, plain.blocks)] == [False]
    stands_there = decode("G90 G01 X100 F100\nG100 X200\nM30", setup(DRIVE, DRIVE, within_limits=True))
    assert stands_there.problem is not None
    assert stands_there.problem.entry is errors.LIMIT_WITHOUT_SIGNAL


def test_a_block_without_way_may_be_allowed() -> None:
    assert refused("X5\nG100 X5") is errors.NO_WAY
    run = decode("G90 G01 X5 F100\nG100 X5\nP1=V.A.MERF.X\nX6\nM30", setup(DRIVE, error_no_way=False))
    assert run.problem is None
    assert of(Measurement, run.blocks) == []
    assert run.parameters == {1: 0}
    allowed = decode("G90 G01 F100\nG100 X5\nM30", setup(DRIVE, may_be_deflected=True))
    assert [m.may_be_deflected for m in of(Measurement, allowed.blocks)] == [True]


@pytest.mark.spec("chan.meas.dynamics")
@pytest.mark.parametrize(
    ("channel", "hold", "weight"),
    [
        ({}, HoldUse.CONFIGURED, ()),
        ({"brakes_as_rapid": True}, HoldUse.AS_ELSE, ()),
        ({"as_feed": True}, HoldUse.RAMP, (0.5, 1.0, 1.0)),
        ({"as_feed": True, "brakes_as_rapid": True}, HoldUse.RAMP, (0.5, 1.0, 1.0)),
    ],
)
def test_weights_act_where_a_run_is_planned_as_feed(
    channel: dict[str, Any], hold: HoldUse, weight: tuple[float, ...]
) -> None:
    run = decode("G90 G01 F100\nG130 X50\nG100 X5\nX6\nM30", setup(DRIVE, **channel))
    assert run.problem is None
    usual, during, behind = (b.settings for b in of(DynamicsChange, run.blocks))
    assert (during.hold_use, during.feed.acceleration) == (hold, weight)
    assert behind == usual


def test_inch_counts_for_the_target_and_the_values() -> None:
    machine = Probed([[25.4, 0, 0]], [{0: 25.4}])
    run = decode(
        "G90 G70 G01 F10\nG100 X2\nP1=V.A.MESS.X P2=V.A.MOFFS.X P3=V.A.MEAS.PCS.VALUE.X\nM30",
        setup(DRIVE),
        outside=machine,
    )
    assert run.problem is None
    assert run.parameters == pytest.approx({1: 1.0, 2: -1.0, 3: 1.0})


def test_a_check_without_machine_takes_the_run_to_its_target() -> None:
    run = decode("G90 G01 F100\nG100 X20\nP1=V.A.MESS.X P2=V.A.MERF.X P3=V.A.MOFFS.X\nM30", setup(DRIVE))
    assert run.problem is None
    assert run.parameters == {1: 20, 2: 1, 3: 0}


@pytest.mark.spec("isg.var.a-measuring", "chan.meas.values")
def test_a_shifted_coordinate_system_counts_in_mess() -> None:
    run = decode(
        "G90 G01 F100\n#CS ON [7,0,0,0,0,0]\nG100 X20\n"
        "P1=V.A.MESS.X P2=V.A.MEAS.ACS.VALUE.X P3=V.A.MEAS.PCS.VALUE.X P4=V.A.MOFFS.X\nM30",
        setup(DRIVE),
        outside=Probed([[25.5, 0, 0]], [{0: 25.0}]),
    )
    assert run.problem is None
    assert run.parameters == {1: 18, 2: 25, 3: 18, 4: -2}


@pytest.mark.spec("chan.meas.values")
@pytest.mark.parametrize(
    ("found", "complete"), [({0: -2.0, 1: 18.0, 2: 5.0}, True), ({0: -2.0, 1: 18.0}, False), ({2: 5.0}, False)]
)
def test_in_a_rotated_coordinate_system_the_main_axes_measure_together(found: dict[int, float], complete: bool) -> None:
    """Turned by 90 degrees about Z: programmed X is machine Y, programmed Y machine -X. The system lies at Z5."""
    run = decode(
        "G90 G01 F100\nG92 X1\n#CS ON [0,0,5,0,0,90]\nX0 Y0 Z0\nG100 X20\n"
        "P1=V.A.MEAS.PCS.VALUE.X P2=V.A.MEAS.PCS.VALUE.Y P3=V.A.MOFFS.X P4=V.A.MEAS.ACS.VALUE.Y P5=V.A.MERF.Y\n"
        "P6=V.A.ABS.Y\nG101 X1\nM30",
        setup(DRIVE, DRIVE, DRIVE),
        outside=Probed([[0.0, 19.0, 5.0]], [found]),
    )
    (measurement,) = of(Measurement, run.blocks)
    assert [probe.axis for probe in measurement.probes] == [0, 1, 2]
    assert run.problem is not None
    assert run.problem.entry is (errors.TURNED if complete else errors.NOT_MEASURED)
    warned = [warning.entry for warning in run.decoder.warnings].count(errors.NO_PCS_VALUE)
    p = run.parameters
    assert p[4] == found.get(1, 0.0)
    assert p[5] == float(1 in found)
    if not complete:
        assert warned == 1
        assert (p[1], p[2], p[3]) == (0.0, 0.0, 0.0)
        return
    assert warned == 0
    assert (p[1], p[2], p[3]) == pytest.approx((18.0, 3.0, -2.0))  # G92 X1 lies below the system: its origin is X1


@pytest.mark.spec("chan.meas.values")
def test_in_a_coordinate_system_every_axis_may_measure_with_those_of_the_block() -> None:
    text = "G90 G01 F100\n#CS ON [7,0,0,0,0,0]\nG100 X20\nM30"
    for every, axes_of_run in ((True, [0, 1]), (False, [0])):
        run = decode(text, setup(DRIVE, DRIVE, all_axes=every))
        assert [probe.axis for probe in of(Measurement, run.blocks)[0].probes] == axes_of_run
    plain = decode("G90 G01 F100\nG100 X20\nM30", setup(DRIVE, DRIVE, all_axes=True))
    assert [probe.axis for probe in of(Measurement, plain.blocks)[0].probes] == [0]


# ---------------------------------------------------------------------------------------------------- G310

INTERRUPTED = (
    "N10 G00 G90 X0 Y0\nN20 G310 G01 F100 X100 Y90 $GOTO[N_LABEL]\nN30 G01 X50\nN40 $GOTO[ENDE]\nN50 [N_LABEL] X1 Y1\n"
    "N60 [ENDE] M30"
)


@pytest.mark.spec("isg.g.measure-interrupt-g310")
def test_a_signal_ends_the_motion_and_leads_to_the_label() -> None:
    text = INTERRUPTED
    hit = decode(text, setup(DRIVE, DRIVE, type=5), outside=Probed([[30.5, 27.45, 0]], [{0: 30.0, 1: 27.0}]))
    assert hit.problem is None
    assert hit.ends[-2:] == [[100, 90, 0], [1, 1, 0]]
    (measurement,) = of(Measurement, hit.blocks)
    assert not measurement.signal_needed
    missed = decode(text, setup(DRIVE, DRIVE, type=5), outside=Probed([[100, 90, 0]], [{}]))
    assert missed.problem is None
    assert missed.ends[-2:] == [[100, 90, 0], [50, 90, 0]]
    checked = decode(text, setup(DRIVE, DRIVE, type=5, error_no_signal=True))
    assert checked.problem is None
    assert checked.ends[-1] == [50, 90, 0]


@pytest.mark.spec("isg.g.measure-interrupt-g310")
def test_without_a_label_the_next_block_follows_where_the_axes_stand() -> None:
    machine = Probed([[30.5, 0, 0]], [{0: 30.0}])
    run = decode("G90 G00 X1\nG310 X100\nP1=V.A.MESS.X P2=V.A.ABS.X\nY5\nM30", setup(DRIVE, type=5), outside=machine)
    assert run.problem is None
    assert run.parameters == {1: 30.0, 2: 30.5}
    assert run.ends[-1] == [30.5, 5, 0]
    assert all(line.rapid for line in of(Line, run.blocks))


@pytest.mark.spec("isg.g.measure-interrupt-g310")
@pytest.mark.parametrize(
    ("text", "entry"),
    [
        ("G310 X10", None),
        ("G100 X10", errors.TYPE_UNSUPPORTED),
        ("#MEAS MODE[1]\nG310 X10", errors.TYPE_UNSUPPORTED),
        ("#MEAS MODE[6]", errors.TYPE_UNSUPPORTED),
        ("G310 G02 X10 Y10", errors.BESIDE),
        ("G310 Z10", errors.NOT_MEASURING),
        ("G41\nX5\nG310 X10", radius.FORBIDDEN),
        ("G310 G106 X10", errors.G106_ALONE),
    ],
)
def test_what_g310_takes(text: str, entry: ErrorEntry | None) -> None:
    assert refused(text, type=5) is entry


@pytest.mark.spec("isg.g.measure-interrupt-g310")
def test_a_label_that_is_not_there_is_told_at_its_block() -> None:
    machine = Probed([[3.5, 0, 0]], [{0: 3.0}])
    run = decode("G90 G01 F100\nG310 X9 $GOTO[NOWHERE]\nM30", setup(DRIVE, type=5), outside=machine)
    assert run.problem is not None
    assert (run.problem.entry, run.problem.place.line) == (language.LABEL_MISSING, 2)
