"""System variables in programs (manual lines 6721–7259)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from runtime.cnc.blocks import (
    ExactStop,
    ExternalWrite,
    Floats,
    Flush,
    Message,
    Polyline,
    Receiver,
    Stop,
    StopKind,
    Suppression,
    UserError,
)
from runtime.cnc.decoder import ChannelMemory, DecoderSetup, Offline
from runtime.cnc.tools.offset_table import MemoryOffsets, OffsetTableError, Register, SqliteOffsets, WorkOffset
from runtime.config.nct import NctParameters
from runtime.diagnostics.catalogue import nct, offsets
from runtime.diagnostics.catalogue import nct_macros as catalogue
from runtime.diagnostics.errors import ErrorEntry
from runtime.hli.external import ExternalVariable, write_external
from tests.cnc.decoder.nct.macro_programs import SETUP, decode, values

spec = pytest.mark.spec


class Standing(Offline):
    """A machine whose axes stand somewhere, some cycles after its start."""

    def __init__(self, *, cycles: int = 0, command: tuple[float, ...] = (), actual: tuple[float, ...] = ()) -> None:
        super().__init__()
        self._cycles, self._command, self._actual = cycles, np.array(command), np.array(actual)

    def cycle(self) -> int:
        return self._cycles

    def command_position(self) -> Floats | None:
        return self._command

    def actual_position(self) -> Floats | None:
        return self._actual


# ---------------------------------------------------------------------------------------------------- alarm, stop


@spec("nct.sysvar.alarm-3000")
@pytest.mark.parametrize(
    ("block", "number", "text"),
    [
        ("#3000=123(DOOR OPEN)", 4123, "4123 DOOR OPEN"),
        ("#3000=1", 4001, "4001"),
        ("#3000=(NO NUMBER)", 4000, "4000 NO NUMBER"),
        ("IF[1 EQ 1]#3000=7(IN A BRANCH)", 4007, "4007 IN A BRANCH"),
    ],
)
def test_an_alarm_stands_behind_what_came_before(block: str, number: int, text: str) -> None:
    run = decode(f"G0 X1\n{block}\nX2\nM30")
    at = next(i for i, out in enumerate(run.blocks) if isinstance(out, UserError))
    error = run.blocks[at]
    assert isinstance(error, UserError)
    assert (error.number, error.text, error.remedy_class) == (number, text, 2)
    assert isinstance(run.blocks[at + 1], Flush)
    assert at == 1


@spec("nct.sysvar.stop-message-3006")
@pytest.mark.parametrize(
    ("block", "text"),
    [("#3006=12(TURN THE PART)", "5012 TURN THE PART"), ("#3006=1", "5001"), ("#3006=(LOOK)", "5000 LOOK")],
)
def test_a_stop_with_a_message(block: str, text: str) -> None:
    run = decode(f"G0 X1\n{block}\nX2\nM30")
    message, stop = run.blocks[1:3]
    assert isinstance(message, Message)
    assert (message.text, message.receiver) == (text, Receiver.HMI)
    assert isinstance(stop, Stop)
    assert stop.kind is StopKind.PROGRAMMED
    assert run.axis("X") == [1.0, 2.0]


REFUSED: list[tuple[str, ErrorEntry]] = [
    ("#3000=1000", catalogue.VALUE_REFUSED),
    ("#3000=-1", catalogue.VALUE_REFUSED),
    ("#3006=1.5", catalogue.VALUE_REFUSED),
    ("#3000=1(ABCDEFGHIJKLMNOPQRSTUVWXYZ)", catalogue.TEXT_TOO_LONG),
    ("#3006=1(ABCDEFGHIJKLMNOPQRSTUVWXYZ)", catalogue.TEXT_TOO_LONG),
    ("#3003=2", catalogue.VALUE_REFUSED),
    ("#3004=8", catalogue.VALUE_REFUSED),
    ("#4001=1", catalogue.VARIABLE_READ_ONLY),
    ("#5001=1", catalogue.VARIABLE_READ_ONLY),
    ("#1=#3000", catalogue.VARIABLE_WRITE_ONLY),
    ("#1=#3006", catalogue.VARIABLE_WRITE_ONLY),
    ("#1=#5004", catalogue.VARIABLE_UNKNOWN),
    ("#1=#3002", catalogue.VARIABLE_UNKNOWN),
]


@spec("nct.sysvar.alarm-3000", "nct.sysvar.stop-message-3006", "nct.sysvar.suppression-3003-3004")
@pytest.mark.parametrize(("block", "entry"), REFUSED, ids=[block for block, _ in REFUSED])
def test_what_is_refused(block: str, entry: ErrorEntry) -> None:
    assert decode(f"G0 X1\n{block}\nM30").place == (entry, 2, block.index("#", 1) + 1 if "#1=" in block else 1)


# ---------------------------------------------------------------------------------------------------- timer, suppression


def test_the_timer_counts_from_power_on_and_from_what_is_written() -> None:
    outside = Standing(cycles=70_000)
    assert decode("#100=#3001\n#3001=1000\n#101=#3001\nM30", outside=outside).value(100) == 70_000 - 65_536
    assert decode("#3001=1000\n#101=#3001\nM30", outside=outside).value(101) == 1000.0


@spec("nct.sysvar.suppression-3003-3004")
def test_single_block_is_suppressed_and_comes_back_with_the_next_program() -> None:
    run = decode("G0 X1\n#3003=1\nX2\n#100=#3003\n#3003=0\n#101=#3003\nM30")
    assert (run.value(100), run.value(101)) == (1.0, 0.0)
    assert not run.decoder.execution.steps.locked
    assert decode("#3003=1\nM30").decoder.execution.steps.locked
    assert values("#100=#3003\n#101=#3004", 100, 101) == [0.0, 0.0]


@spec("nct.sysvar.suppression-3003-3004")
@pytest.mark.parametrize("bits", range(8))
def test_stop_override_and_exact_stop_are_suppressed(bits: int) -> None:
    run = decode(f"#3004={bits}\n#100=#3004\nG61 G0 X1\n#3004=0\nX2\nM30")
    assert run.problem is None
    assert run.value(100) == bits
    first = next(block for block in run.blocks if isinstance(block, Suppression))
    assert (first.feed_stop, first.override) == (bool(bits & 1), bool(bits & 2))
    assert sum(isinstance(block, ExactStop) for block in run.blocks) == (1 if bits & 4 else 2)


def test_mirrored_axes() -> None:
    run = decode("#100=#3007\nG51.1 X0 Z0\n#101=#3007\nG50.1 X0\n#102=#3007\n#3007=1\nM30")
    assert [run.value(n) for n in (100, 101, 102)] == [0.0, 5.0, 4.0]  # axes 1 and 3: line 7036
    assert run.place == (catalogue.VARIABLE_READ_ONLY, 6, 1)


# ---------------------------------------------------------------------------------------------------- modal information


@spec("nct.sysvar.modal-information")
def test_codes_and_words_of_the_block_before_and_of_the_block_in_work() -> None:
    text = (
        "G90 G17 G1 F250 S500 T7 M3\nN20 #101=#4001\n#102=#4003\n#103=#4109\n#104=#4119\n#105=#4120\n#106=#4113\n"
        "N30 G91 X[#4003] Y[#4203]\n#107=#4114\n#108=#4314\nN40 #109=#4314\n#110=#4115"
    )
    run = decode(f"O0077\n{text}\nM30")
    assert run.problem is None
    assert [run.value(n) for n in range(101, 107)] == [1.0, 90.0, 250.0, 500.0, 7.0, 3.0]
    assert run.ends == [(90.0, 91.0, 0.0)]  # the block before was G90
    assert [run.value(n) for n in (107, 108, 109, 110)] == [30.0, 30.0, 40.0, 77.0]


@spec("nct.sysvar.modal-information")
def test_what_was_never_written_is_vacant() -> None:
    assert values("#100=1\n#100=#4120\n#101=1\n#101=#4114", 100, 101) == [None, None]


# ---------------------------------------------------------------------------------------------------- positions


def test_positions() -> None:
    shifted = DecoderSetup(axes=("X", "Y", "Z"), linear=(True,) * 3, zero_offsets={54: np.array([100.0, 10.0, 1.0])})
    outside = Standing(command=(105.0, 17.0, 1.0), actual=(104.5, 17.0, 1.25))
    run = decode(
        "G90 G0 X5 Y7\n#101=#5001\n#102=#5002\n#103=#5021\n#104=#5041\n#105=#5101\n#106=#5103\n#107=#5083\nM30",
        shifted,
        outside=outside,
    )
    assert run.problem is None
    assert [run.value(n) for n in range(101, 108)] == [5.0, 7.0, 105.0, 5.0, 0.5, -0.25, 0.0]
    assert sum(isinstance(block, Flush) for block in run.blocks) == 4


# ---------------------------------------------------------------------------------------------------- offsets


@spec("nct.sysvar.tool-compensation")
def test_compensation_registers_are_those_of_g10() -> None:
    memory = ChannelMemory(SETUP)
    text = "G10 L10 P1 R50\nG10 L11 P1 R-0.5\nG10 L12 P999 R6\n#100=#10001\n#101=#11001\n#102=#12999\n#103=#13999\n"
    run = decode(f"{text}#10002=3.25\n#11002=0.1\n#12002=-4\n#13002=#1\nM30", memory=memory)
    assert run.problem is None
    assert [run.value(n) for n in (100, 101, 102, 103)] == [50.0, -0.5, 6.0, 0.0]
    assert memory.offsets.register("H", 2) == (3.25, 0.1)
    assert memory.offsets.register("D", 2) == (-4.0, 0.0)


@spec("nct.sysvar.tool-compensation")
def test_a_register_that_is_written_acts_with_the_next_h() -> None:
    run = decode("#10001=10\nG90 G43 H1 G0 Z0\n#10001=20\nZ0\nH1 Z0\nM30")
    *before, last = run.axis("Z")
    assert set(before) == {10.0}
    assert last == 20.0


@spec("nct.sysvar.tool-compensation")
def test_registers_in_inch_and_their_limits() -> None:
    run = decode("G20\n#10001=2\nG21\n#100=#10001\n#11001=16.381\nM30")
    assert run.value(100) == pytest.approx(50.8)
    assert run.place == (nct.VALUE_EXCESS, 5, 1)
    assert decode("#100=#11000\nM30").place[0] is catalogue.VARIABLE_UNKNOWN  # there is no register 0


@spec("nct.sysvar.work-offsets")
def test_work_offsets_are_read_and_written() -> None:
    setup = replace(SETUP, zero_offsets={54: np.array([1.0, 2.0, 3.0]), 59: np.array([7.0, 8.0, 9.0])})
    memory = ChannelMemory(setup)
    run = decode("#100=#5221\n#101=#5223\n#102=#5322\n#103=#5201\n#5242=4\n#5203=-1\nM30", setup, memory=memory)
    assert run.problem is None
    assert [run.value(n) for n in (100, 101, 102, 103)] == [1.0, 3.0, 8.0, 0.0]
    assert memory.zero_offsets[2, 1] == 4.0
    assert memory.common_offset[2] == -1.0


@spec("nct.sysvar.work-offsets")
def test_an_active_offset_acts_at_once_and_moves_nothing() -> None:
    run = decode("G90 G54 G0 X10\n#5221=5\nX10\n#5241=9\nX11\n#5201=1\nX11\nG55 X0\nM30")
    assert run.problem is None
    assert run.axis("X") == [10.0, 15.0, 16.0, 17.0, 10.0]


@spec("nct.sysvar.work-offsets")
def test_work_offsets_of_axes_that_are_not_there() -> None:
    assert decode("#100=#5224\nM30").place == (catalogue.VARIABLE_UNKNOWN, 1, 6)
    assert decode("#5324=1\nM30").place == (catalogue.VARIABLE_UNKNOWN, 1, 1)


def test_a_table_that_is_out_of_reach_is_told_at_the_variable() -> None:
    class Broken(MemoryOffsets):
        def register(self, kind: str, number: int) -> Register:
            raise OffsetTableError(offsets.TABLE_FAILED, reason="gone")

        def set_work_offset(self, channel: int, data_set: int, axis: str, offset: WorkOffset) -> None:
            raise OffsetTableError(offsets.TABLE_FAILED, reason="gone")

        def set_variables(self, channel: int, values: Mapping[int, float | None]) -> None:
            raise OffsetTableError(offsets.TABLE_FAILED, reason="gone")

    for block, column in (("#1=#10001", 4), ("#10001=1", 1), ("#5221=1", 1)):
        run = decode(f"{block}\nM30", memory=ChannelMemory(SETUP, offsets=Broken()))
        assert run.place == (offsets.TABLE_FAILED, 1, column)
    run = decode("G0 X1\n#500=1\nM30", memory=ChannelMemory(SETUP, offsets=Broken()))
    assert run.problem is not None
    assert run.problem.entry is offsets.TABLE_FAILED
    assert run.axis("X") == [1.0]


@spec("nct.var.local-and-common")
def test_the_upper_common_variables_are_kept_over_a_restart(tmp_path: Path) -> None:
    def start() -> ChannelMemory:
        return ChannelMemory(SETUP, offsets=SqliteOffsets(tmp_path / "offsets.db"))

    first = start()
    assert decode("#100=1\n#500=2.5\n#599=7\n#599=#0\n#510=1\nM30", memory=first).problem is None
    second = start()
    run = decode("#101=#100\n#102=#500\n#103=#599\n#510=#0\nM30", memory=second)
    assert [run.value(n) for n in (101, 102, 103)] == [None, 2.5, None]
    assert dict(start().offsets.variables(SETUP.channel_number)) == {500: 2.5}


@spec("nct.var.local-and-common")
def test_what_an_aborted_program_has_written_is_kept_too(tmp_path: Path) -> None:
    table = SqliteOffsets(tmp_path / "offsets.db")
    run = decode("#500=3\nX1\n#501=1/0\nM30", memory=ChannelMemory(SETUP, offsets=table))
    assert run.problem is not None
    assert dict(table.variables(SETUP.channel_number)) == {500: 3.0}


# ---------------------------------------------------------------------------------------------------- interface

WORDS = (
    ExternalVariable("V.E.inputs", "UNS16", 4, 2, (), (), "rw", False),
    ExternalVariable("V.E.outputs", "UNS16", 6, 2, (), (), "rw", False),
    ExternalVariable("V.E.level", "REAL64", 8, 8, (), (), "rw", False),
)
WIRED = replace(SETUP, external=WORDS, nct=NctParameters(i_line="inputs", o_line="outputs"))


@spec("nct.sysvar.interface-io")
def test_inputs_one_by_one_and_as_a_number() -> None:
    outside = Offline()
    write_external(outside.external, 4, "UNS16", 2, 2**2 + 2**8)  # lines 6757-6760: #1002 and the tenth octal one
    run = decode("#100=#1002\n#101=#1003\n#102=#1008\n#103=#1032\nM30", WIRED, outside=outside)
    assert [run.value(n) for n in (100, 101, 102, 103)] == [1.0, 0.0, 1.0, 260.0]
    assert sum(isinstance(block, Flush) for block in run.blocks) == 4


@spec("nct.sysvar.interface-io")
def test_outputs_are_put_out_on_the_path_and_read_back() -> None:
    outside = Offline()
    write_external(outside.external, 6, "UNS16", 2, 2**9)
    run = decode(
        "#100=#1109\n#1102=1\nG0 X1\n#1109=0\n#101=#1102\n#102=#1132\n#1132=65535\n#103=#1115\nM30",
        WIRED,
        outside=outside,
    )
    assert run.problem is None
    assert [run.value(n) for n in (100, 101, 102, 103)] == [1.0, 1.0, 4.0, 1.0]
    written = [(block.offset, block.kind, block.value) for block in run.blocks if isinstance(block, ExternalWrite)]
    assert written == [(6, "UNS16", 2.0**9 + 4), (6, "UNS16", 4.0), (6, "UNS16", 65535.0)]
    places = [isinstance(block, ExternalWrite) for block in run.blocks if isinstance(block, ExternalWrite | Polyline)]
    assert places == [True, False, True, True]


@spec("nct.sysvar.interface-io")
@pytest.mark.parametrize(
    ("block", "setup", "entry"),
    [
        ("#1000=1", WIRED, catalogue.VARIABLE_READ_ONLY),
        ("#1032=1", WIRED, catalogue.VARIABLE_READ_ONLY),
        ("#1100=2", WIRED, catalogue.VALUE_REFUSED),
        ("#1132=65536", WIRED, catalogue.VALUE_REFUSED),
        ("#1132=0.5", WIRED, catalogue.VALUE_REFUSED),
        ("#1100=1", SETUP, catalogue.VARIABLE_REFUSED),
        ("#1=#1000", SETUP, catalogue.VARIABLE_REFUSED),
        ("#1=#1032", replace(WIRED, nct=NctParameters(i_line="level")), catalogue.VARIABLE_REFUSED),
        ("#1=#1016", WIRED, catalogue.VARIABLE_UNKNOWN),
    ],
)
def test_what_the_interface_refuses(block: str, setup: DecoderSetup, entry: ErrorEntry) -> None:
    assert decode(f"{block}\nM30", setup).place[:2] == (entry, 1)
