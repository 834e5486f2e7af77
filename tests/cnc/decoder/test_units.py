"""Units of programmed positions as a channel has them, and blocks in which an axis stands several times."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from runtime.cnc.decoder.setup import GRADIAN, DecoderSetup
from runtime.config.loader import parse_machine
from runtime.diagnostics.catalogue import language as catalogue
from tests.cnc.decoder.programs import SETUP, Run, decode, found
from tests.config.machines import MACHINE, parameters_of, with_parameters

TURNING = replace(
    SETUP,
    axes=("X", "Y", "C"),
    linear=(True, True, False),
    position_limits=((None, None), (None, None), (-1000.0, 1000.0)),
)


def good(text: str, setup: DecoderSetup) -> Run:
    run = decode(f"{text}\nM30", setup)
    assert run.problem is None, run.problem
    return run


@pytest.mark.spec("chan.units")
def test_programs_begin_in_the_unit_of_the_channel() -> None:
    inch = replace(TURNING, inch=True)
    run = good("P1=V.G.MASS_MM\nG90 G00 X1 C10\nP2=V.A.ABS.X P3=V.A.ABS.C\nG71\nX1\nG70\nX2 Y[0.5]\nG01 X3 F10", inch)
    assert run.parameters == {1: 1, 2: 1, 3: 10}
    assert [x for x, _, _ in run.ends] == pytest.approx([25.4, 1, 50.8, 76.2])
    assert [c for _, _, c in run.ends] == [10] * 4
    assert run.ends[2][1] == pytest.approx(12.7)
    assert good("G90 G00 X1", TURNING).ends == [[1, 0, 0]]


@pytest.mark.spec("chan.units")
@pytest.mark.parametrize("plain", [True, False])
def test_rotary_axes_in_gradians(plain: bool) -> None:
    """400 to a turn: 100 of them are a quarter. Plain lines take another road than those with an expression."""
    gradians = replace(TURNING, rotary_unit=GRADIAN)
    values = ("100", "400", "-50") if plain else ("[50 + 50]", "[P1]", "[-50]")
    run = good(
        f"P1=400\nG90 G00 X5 C{values[0]}\nC{values[1]}\nG91 C{values[2]} X1\nP2=V.A.ABS.C P3=V.A.PROG.C", gradians
    )
    assert [x for x, _, _ in run.ends] == [5, 5, 6]
    assert [c for _, _, c in run.ends] == pytest.approx([90, 360, 315])
    assert run.parameters == pytest.approx({1: 400, 2: 350, 3: 350})


@pytest.mark.spec("chan.units")
def test_the_parameters_of_the_channel_choose_the_units() -> None:
    machine = parse_machine(with_parameters("mass_einh: 1\nrund_mass_einh: 1"))
    setup = DecoderSetup.from_machine(machine)
    assert (setup.inch, setup.rotary_unit) == (True, 0.9)
    usual = DecoderSetup.from_machine(parse_machine(MACHINE))
    assert (usual.inch, usual.rotary_unit) == (False, 1.0)
    assert parameters_of("mass_einh: 0").mass_einh == 0


MIXED = replace(SETUP, mixed_dimension=True, repeated_axes=True)


@pytest.mark.spec("chan.prog.mixed-g90-g91")
@pytest.mark.parametrize(
    ("block", "end"),
    [  # from X100 Y100 Z100; the examples of the manual, channel parameters lines 5530 and 5541
        ("G90 X10 Y20 G91 Z30", (10, 20, 130)),
        ("G91 X15 G90 Y25 Z15", (115, 25, 15)),
        ("G91 X10 G90 Z30 G91 Y5", (110, 105, 30)),
        ("G91 X20 Z30 G90 Y40", (120, 40, 130)),
        ("G90 X10 G91 Y10 Z20 Y1", (10, 111, 120)),
        ("G91 X10 Y10 G90 X2 G91 Z30", (2, 110, 130)),
        ("G90 X10 Y20 G91 Z30 Y5", (10, 25, 130)),
        ("G91 Z15 Y20 G90 X5 G91 Z30", (5, 120, 145)),
        ("G90 X1 X7", (7, 100, 100)),
        ("G91 X1 X7", (108, 100, 100)),
    ],
)
def test_words_are_read_from_left_to_right(block: str, end: tuple[float, ...]) -> None:
    run = good(f"G90 G00 X100 Y100 Z100\n{block}", MIXED)
    assert run.ends[-1] == list(end)


@pytest.mark.spec("chan.prog.mixed-g90-g91")
def test_the_last_dimension_stays_and_what_is_not_permitted_is_an_error() -> None:
    run = good("G90 G00 X10\nG91 X1 G90 Y5 G91 X1\nX3", MIXED)
    assert run.ends == [[10, 0, 0], [12, 5, 0], [15, 5, 0]]
    one_each = replace(SETUP, mixed_dimension=True)
    assert list(found("G90 X1 G91 X2\nM30", one_each)) == [(catalogue.WORD_TWICE, 1, 12)]
    assert list(found("G90 X1 G91 Y2\nM30")) == [(catalogue.G_GROUP_TWICE, 1, 8)]
    alone = replace(SETUP, repeated_axes=True)  # counts with the other one only
    assert list(found("X1 X2\nM30", alone)) == [(catalogue.WORD_TWICE, 1, 4)]
    machine = parse_machine(with_parameters("multi_dimension_in_block: 1\nmulti_axes_in_block: 1"))
    assert DecoderSetup.from_machine(machine).repeated_axes


@pytest.mark.spec("chan.channel-id")
def test_a_channel_may_have_a_number_of_its_own() -> None:
    machine = parse_machine(with_parameters("channel_id: 3"))
    own, usual = DecoderSetup.from_machine(machine), DecoderSetup.from_machine(parse_machine(MACHINE))
    for setup, number in ((own, 3), (usual, 1)):
        assert decode("P1=V.G.CNC_CHANNEL\nM30", setup, start=tuple(np.zeros(2))).parameters == {1: number}
