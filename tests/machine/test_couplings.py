"""#AX LINK: axes that follow others, decoded and on the whole machine in virtual time (programming manual 12926–13301)."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from runtime.cnc.blocks import CoupledAxis, CouplingChange
from runtime.cnc.decoder import ChannelMemory, DecoderSetup
from runtime.cnc.path_preparation.coupled_limits import narrowed
from runtime.config import load_machine
from runtime.config.loader import DEMO_MACHINE
from runtime.diagnostics.catalogue import axes as errors
from runtime.diagnostics.catalogue import block_search, language, motion
from runtime.diagnostics.errors import ErrorEntry
from runtime.hli.layout import SearchOrder
from tests.cnc.decoder.programs import SETUP, Run, decode
from tests.machine.driven import Driven

FIVE = replace(
    SETUP,
    axes=("X", "Y", "Z", "A", "B", "C"),
    linear=(True, True, True, True, True, False),
    log_axes=(1, 2, 3, 4, 5, 6),
    zero_offsets={},
)
SLAVE = """  - name: A
    log_axis: 9
    position_min: -60
    position_max: 300
    velocity: 200
    acceleration: 2000
    jerk: 30000
    drive: {node: 9, increments_per_unit: 1000, vendor_id: 0x7A4D, product_code: 0x402}
"""
DEFAULT = "{koppel_gruppe: {0: {paar: {0: {log_achs_nr_slave: 9, log_achs_nr_master: 1}}}}}"


def run(text: str, setup: DecoderSetup = FIVE, memory: ChannelMemory | None = None) -> Run:
    return decode(f"G90 G01 F1000\n{text}\nM30", setup, start=(0.0,) * len(setup.axes), memory=memory)


def refusal(text: str) -> ErrorEntry:
    found = run(text)
    assert found.problem is not None, text
    return found.problem.entry


@pytest.mark.spec("isg.add.ax-link-define", "isg.add.ax-link-enable", "isg.add.ax-link-variables")
@pytest.mark.parametrize(
    ("define", "on", "off"),
    [
        ("#SET AX LINK [1, A=X, B=Y]", "#ENABLE AX LINK [1]", "#DISABLE AX LINK [1]"),
        ("#AX LINK [P1, A=X, B=Y]", "#AX LINK ON [P1]", "#AX LINK OFF"),
        ("#AX LINK NBR [1, 4=1, 5=P2]", "#AX LINK ON[1]", "#AX LINK OFF ALL"),
    ],
)
def test_slaves_are_where_their_masters_have_led_them(define: str, on: str, off: str) -> None:
    found = run(
        f"P1=1 P2=2\nA5\n{define}\nP10=V.G.AX_LINK.ACTIVE\n{on}\nX10 Y20\nP11=V.A.ABS.A P12=V.A.ABS.B\n"
        f"P13=V.G.AX_LINK.ACTIVE P14=V.G.AX_LINK.NR P15=V.G.AX_LINK_GROUP[1].ACTIVE\n{off}\nP16=V.A.ABS.A\n"
        "P17=V.G.AX_LINK.ACTIVE P18=V.G.AX_LINK.NR\nA0"
    )
    assert found.problem is None, found.problem
    values = {number - 10: value for number, value in found.parameters.items() if number >= 10}
    assert values == {0: 0, 1: 15, 2: 20, 3: 1, 4: 1, 5: 1, 6: 15, 7: 0, 8: 1}
    on_, off_ = (block for block in found.blocks if isinstance(block, CouplingChange))
    assert on_.coupled == (CoupledAxis(3, 0, 5.0), CoupledAxis(4, 1, 0.0))
    assert (off_.coupled, off_.ends) == ((), ((3, 15.0), (4, 20.0)))


@pytest.mark.spec("isg.add.ax-link-enable")
def test_several_groups_end_in_the_order_that_is_asked_for() -> None:
    found = run(
        "#AX LINK [1, A=X]\n#AX LINK [2, B=X]\n#AX LINK ON [1]\n#AX LINK ON [2]\nX5\n#AX LINK OFF\nB0 X6\n#AX LINK OFF\nA0"
    )
    assert found.problem is None, found.problem
    changes = [block for block in found.blocks if isinstance(block, CouplingChange)]
    assert [len(change.coupled) for change in changes] == [1, 2, 1, 0]
    assert changes[2].ends == ((4, 5.0),)
    assert changes[3].ends == ((3, 6.0),)


@pytest.mark.spec("isg.add.ax-link-define")
def test_definitions_outlive_the_program_and_can_be_replaced() -> None:
    memory = ChannelMemory(FIVE)
    assert run("#AX LINK [1, A=X]", memory=memory).problem is None
    assert run("#AX LINK ON [1]\nX5", memory=memory).problem is None
    again = run("#AX LINK [1, B=Y]\n#AX LINK ON [1]\nY5\nA3", memory=memory)
    assert again.problem is None, again.problem


@pytest.mark.spec("isg.add.ax-link-define", "isg.add.ax-link-enable")
@pytest.mark.parametrize(
    ("text", "entry"),
    [
        ("#AX LINK [0, A=X]", errors.COUPLING_GROUP),
        ("#AX LINK [5, A=X]", errors.COUPLING_GROUP),
        ("#AX LINK [1, A=A]", errors.COUPLING_PAIRS),
        ("#AX LINK [1, A=X, B=A]", errors.COUPLING_PAIRS),
        ("#AX LINK [1, A=X, A=Y]", errors.COUPLING_PAIRS),
        ("#AX LINK [1, A=X]\n#AX LINK [2, B=A]", errors.COUPLING_PAIRS),
        ("#AX LINK [1, A=X]\n#AX LINK [2, A=Y]", errors.COUPLING_PAIRS),
        ("#AX LINK [1, Y=X]\n#AX LINK ON [1]", errors.COUPLING_PAIRS),
        ("#AX LINK [1, C=X]\n#AX LINK ON [1]", errors.COUPLING_PAIRS),
        ("#AX LINK NBR [1, 77=1]\n#AX LINK ON [1]", errors.COUPLING_PAIRS),
        ("#AX LINK NBR [1, A=X]", errors.COUPLING_NUMBER),
        ("#AX LINK [1, A=Q]", language.AXIS_UNKNOWN),
        ("#AX LINK ON [3]", errors.COUPLING_UNDEFINED),
        ("#AX LINK ON", errors.COUPLING_UNDEFINED),
        ("#AX LINK [1, A=X]\n#AX LINK ON [1]\n#AX LINK [1, A=Y]", errors.COUPLING_CHANGED),
        ("#AX LINK [1, A=X]\n#AX LINK ON [1]\nA5", errors.COUPLED_SLAVE),
        ("#AX LINK [1, A=X]\n#AX LINK ON [1]\nB[INDP_SYN POS=5 G00]", errors.COUPLING_ACTIVE),
        ("#AX LINK [1, A=X]\n#AX LINK ON [1]\nG201 A1", errors.COUPLING_ACTIVE),
        ("#AX LINK [1, A=X]\n#AX LINK ON [1]\nG74 X1", errors.COUPLING_ACTIVE),
        ("#AX LINK [1, A=X]\n#AX LINK ON [1]\n#CHANNEL INIT [CMDPOS]", errors.COUPLING_ACTIVE),
        ("#AX LINK [1, A=X]\nG201 A1\n#AX LINK ON [1]", errors.COUPLING_PAIRS),
        ("#AX LINK [1, A=X]\nG261\n#AX LINK ON [1]", errors.COUPLING_SMOOTHED),
    ],
)
def test_what_is_refused(text: str, entry: ErrorEntry) -> None:
    assert refusal(text) is entry


@pytest.mark.spec("isg.add.ax-link-variables")
def test_the_state_cannot_be_written() -> None:
    with pytest.raises(Exception, match=str(language.VARIABLE_READ_ONLY.id)):
        run("V.G.AX_LINK.ACTIVE = 1")


@pytest.mark.spec("chan.synchro.restore")
@pytest.mark.parametrize("after_end", [False, True])
@pytest.mark.parametrize("after_reset", [False, True])
@pytest.mark.parametrize("ended", [False, True])
def test_couplings_come_back_as_it_is_configured(after_end: bool, after_reset: bool, ended: bool) -> None:
    setup = replace(FIVE, couplings_after_end=after_end, couplings_after_reset=after_reset)
    memory = ChannelMemory(setup)
    text = "#AX LINK [1, A=X]\n#AX LINK ON [1]\nX5"
    first = run(text if ended else f"{text}\nX999999", setup, memory)  # which is too far
    assert (first.problem is None) is ended
    found = run("P1=V.G.AX_LINK.ACTIVE\n#AX LINK OFF ALL", setup, memory)
    assert found.parameters == {1: float(after_end if ended else after_reset)}
    assert run("P1=V.G.AX_LINK.ACTIVE", setup, memory).parameters == {1: 0.0}, "it was switched off"


def test_a_master_stays_where_its_slaves_stay_within_their_limits() -> None:
    limits = ((-100.0, 100.0), (-5.0, 5.0), (-np.inf, 20.0))
    coupled = (CoupledAxis(1, 0, 2.0), CoupledAxis(2, 0, -50.0))
    assert narrowed(limits, coupled) == ((-7.0, 3.0), *limits[1:])


# ---------------------------------------------------------------------------------------------------- the machine


def driven(folder: Path, parameters: str = "{}", *, ideal: bool = True) -> Driven:
    text = DEMO_MACHINE.read_text().replace("channels:\n", SLAVE + "channels:\n", 1)
    text = text.replace("axes: [X, Y, Z]", "axes: [X, Y, Z, A]", 1)
    text = text.replace("    parameters:\n", f"    parameters:\n      synchro_data: {parameters}\n", 1)
    (folder / "machine.yaml").write_text(text)
    return Driven(load_machine(folder / "machine.yaml"), folder, ideal_axes=ideal)


def drive(machine: Driven, text: str) -> tuple[np.ndarray, np.ndarray]:
    """Set-points of X and of A."""
    machine.forget()
    machine.start(text)
    machine.until_done()
    path = np.array(machine.targets)
    index = machine.machine.axis_index("A")
    axis, period = machine.machine.axes[index], machine.simulation.period
    v = np.diff(path[:, index]) / period
    assert np.abs(v).max(initial=0.0) <= axis.velocity * 1.001
    jump = axis.velocity_step / period
    assert np.abs(np.diff(v)).max(initial=0.0) / period <= axis.acceleration * 1.01 + jump
    return path[:, 0], path[:, index]


@pytest.mark.spec("isg.add.ax-link-enable")
@pytest.mark.parametrize("ideal", [True, False])
def test_a_slave_follows_lines_circles_and_curves_within_what_it_can(tmp_path: Path, ideal: bool) -> None:
    machine = driven(tmp_path, DEFAULT, ideal=ideal)
    x, a = drive(
        machine,
        "%A\nN10 G90 G00 X10 A-20\nN20 #AX LINK ON\nN30 G00 X150\nN40 G01 F20000 X120 Y30\nN50 G02 X80 I-20 J0\n"
        "N60 G261\nN70 G01 X60 Y10\nN80 X20 Y10\nN90 G260\nN100 #AX LINK OFF\nN110 G00 X0\nN120 A0\nM30\n",
    )
    assert not machine.simulation.problems, [str(problem) for problem in machine.simulation.problems]
    begin = int(np.nonzero(x > 10.0001)[0][0])
    end = begin + int(np.nonzero(np.isclose(x[begin:], 20.0, rtol=0.0, atol=1e-9))[0][-1])
    np.testing.assert_allclose(a[begin:end] - x[begin:end], -30.0, atol=1e-9)
    assert x[begin:end].max() > 149.9
    assert (x[-1], a[-1]) == pytest.approx((0.0, 0.0))
    behind = a[end:]
    assert behind[0] == pytest.approx(-10.0)
    assert np.all(np.diff(behind) >= -1e-12), "it stays until it is moved itself"


@pytest.mark.spec("isg.add.ax-link-enable")
def test_the_limits_of_a_slave_stop_its_master_before_the_motion(tmp_path: Path) -> None:
    machine = driven(tmp_path, DEFAULT)
    x, a = drive(machine, "%B\nN10 G90 G00 X10 A-20\nN20 #AX LINK ON\nN30 G01 F6000 X-20\nN40 X-40\nM30\n")
    machine.alarm(motion.SOFTWARE_LIMIT)  # A has to stay above -60, which is X -30
    assert x[-1] == pytest.approx(-20.0)
    assert a[-1] == pytest.approx(-50.0)


@pytest.mark.spec("isg.add.ax-link-enable", "chan.synchro.restore")
def test_a_reset_stops_both_and_the_coupling_comes_back(tmp_path: Path) -> None:
    kept = DEFAULT.replace("{koppel", "{restore_coupling_after_reset: 1, koppel")
    machine = driven(tmp_path, kept)
    machine.forget()
    machine.start("%C\nN10 G90 G01 F6000\nN20 #AX LINK ON\nN30 X100\nM30\n")
    machine.until_x(20.0)
    machine.reset()
    machine.until_done()
    index = machine.machine.axis_index("A")
    x, a = machine.image.target_position[0], machine.image.target_position[index]
    assert 20.0 < x < 40.0
    assert a == pytest.approx(x), "both have come to rest together"
    drive(machine, "%D\nN10 G91 G01 F6000 X10\nM30\n")
    assert machine.image.target_position[index] == pytest.approx(a + 10.0)


@pytest.mark.spec("isg.add.ax-link-enable")
def test_no_block_search_goes_over_a_coupling(tmp_path: Path) -> None:
    machine = driven(tmp_path, DEFAULT)
    search = machine.operator.block_search
    search.data_w = SearchOrder(type=4, value=30, automatic_return=True, no_hold=True)
    search.semaphor_rw = True
    machine.start("%E\nN10 G90 G01 F1000\nN20 #AX LINK ON\nN30 X10\nM30\n")
    machine.until(lambda: not machine.channel.active)
    machine.alarm(block_search.SEARCH_STOPS_HERE)
    assert machine.image.target_position[0] == 0.0
