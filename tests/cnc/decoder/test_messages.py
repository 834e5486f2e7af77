"""Messages, errors, timers and waiting: #MSG, #ADD, #ERROR, #TIMER, #WAIT FOR, #FLUSH."""

from __future__ import annotations

from dataclasses import replace

import pytest

from runtime.cnc.blocks import (
    Flush,
    FlushKind,
    Hold,
    Line,
    Message,
    Polyline,
    Receiver,
    TimerAction,
    TimerCommand,
    UserError,
)
from runtime.cnc.decoder import ProgramError
from runtime.cnc.decoder.message_text import composed
from runtime.diagnostics.catalogue import language as C  # noqa: N812 - a table of constants
from tests.cnc.decoder.programs import SETUP, Run, decode
from tests.cnc.decoder.scripted_outside import Machine
from tests.cnc.decoder.test_variables import EXTERNAL


def ran(text: str, machine: Machine | None = None, **options: object) -> tuple[Run, Machine]:
    machine = machine or Machine()
    run = decode(text, outside=machine, **options)  # type: ignore[arg-type]
    assert run.problem is None, run.problem
    return run, machine


def sent(run: Run) -> list[Message]:
    """Messages at their place on the path."""
    return [block for block in run.blocks if isinstance(block, Message)]


def problem(text: str) -> tuple[object, int]:
    run = decode(text)
    assert run.problem is not None
    return run.problem.entry, run.problem.place.column


# -- #MSG ----------------------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.add.msg")
def test_messages_go_out_when_decoded_or_when_the_path_is_there() -> None:
    text = '#MSG HMI ["Text_1"]\n#MSG SYN HMI ["Text_2"]\n#MSG ["Text_3"]\n#MSG SYN ["Text_4"]\n#MSG SYN_ACK PLC ["Text_5"]'
    run, machine = ran(text)
    assert [(m.text, m.receiver) for _, m in machine.told] == [
        ("Text_1", Receiver.HMI),
        ("Text_3", Receiver.DIAGNOSIS),
    ]
    assert [(m.text, m.receiver, m.acknowledge, m.source.line) for m in sent(run)] == [
        ("Text_2", Receiver.HMI, False, 2),
        ("Text_4", Receiver.DIAGNOSIS, False, 4),
        ("Text_5", Receiver.PLC, True, 5),
    ]


@pytest.mark.spec("isg.add.msg")
def test_a_message_of_the_path_stands_between_its_motions() -> None:
    run, _ = ran('G01 X1 F100\n#MSG SYN ["now"]\nX2')
    kinds = [type(block) for block in run.blocks if isinstance(block, (Line, Polyline, Message))]
    assert kinds == [Polyline, Message, Polyline]


@pytest.mark.spec("isg.add.msg")
def test_ack_holds_the_decoder_until_the_receiver_has_taken_the_message() -> None:
    holds = []

    def later(machine: Machine) -> None:
        holds.append(len(machine.told))
        if len(holds) == 3:
            machine.taken_numbers.add(1)

    run, machine = ran('#MSG ACK ["a"]\n#MSG ["b"]', Machine(later))
    assert holds == [1, 1, 1]
    assert machine.texts == ["a", "b"]
    assert sum(isinstance(block, Hold) for block in run.blocks) == 3


@pytest.mark.spec("isg.add.msg")
def test_the_decoder_waits_when_nobody_fetches_the_messages() -> None:
    machine = Machine(lambda m: setattr(m, "rooms", 1))
    machine.rooms = 2
    run, machine = ran('#MSG ["1"]\n#MSG ["2"]\n#MSG ["3"]', machine)
    assert machine.texts == ["1", "2", "3"]
    assert sum(isinstance(block, Hold) for block in run.blocks) == 1


def test_without_a_machine_nobody_waits_for_an_answer() -> None:
    assert decode('#MSG ACK ["a"]\nP1 = 1').problem is None


@pytest.mark.spec("isg.add.msg")
@pytest.mark.parametrize(
    ("text", "entry", "column"),
    [
        ('#MSG ["a"] X1', C.STATEMENT_ARGUMENTS, 12),
        ('#MSG PLC SYN ["a"]', C.MESSAGE_MODE, 10),
        ('#MSG SYN ACK ["a"]', C.MESSAGE_MODE, 10),
        ('#MSG NOBODY ["a"]', C.WORD_UNKNOWN, 6),
        ('#MSG ["a"', C.BRACKET_OPEN, 6),
        ("#MSG [5]", C.NUMBER_NOT_ALLOWED, 7),
    ],
)
def test_what_a_message_refuses(text: str, entry: object, column: int) -> None:
    assert _any_problem(text) == (entry, column)


def _any_problem(text: str) -> tuple[object, int]:
    """Of the check or the execution."""
    try:
        return problem(text)
    except ProgramError as error:
        return error.problem.entry, error.problem.place.column


@pytest.mark.spec("isg.add.msg-format")
@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ('"Message text_%d and message text_2", 1', "Message text_1 and message text_2"),
        ('"value: %f", 34.56780', "value: 3.4567800000E+001"),
        ('"%F %f", 0, -0.00125', "0.0000000000E+000 -1.2500000000E-003"),
        ('"state: %s", "End of roughing"', "state: End of roughing"),
        ('"%s%S", "a, ]b", V.P.TEXT', "a, ]bpart"),
        ('"%d %D %d", -2.4, 2.5, P1', "-2 3 20"),
        ('"%u %U", 7, P1', "7 20"),
        ('"Text with %% character"', "Text with % character"),
        ('"Text in quotation marks: \\"TEXT\\" "', 'Text in quotation marks: "TEXT" '),
        ('"%s is a macro of value %d and %d", "SUM", "SUM", 2 * "SUM"', "1 + P1 is a macro of value 21 and 22"),
        ("V.P.TEXT", "part"),
        ('"%d%d%d%d%d%d%d%d%d%d",1,2,3,4,5,6,7,8,9,0', "1234567890"),
    ],
)
def test_format_elements(arguments: str, text: str) -> None:
    _, machine = ran(f'P1 = 20\nV.P.TEXT = "part"\n"SUM" = "1 + P1"\n#MSG [{arguments}]')
    assert machine.texts == [text]


@pytest.mark.spec("isg.add.msg-format")
@pytest.mark.parametrize(
    ("arguments", "entry"),
    [
        ('"%d"', C.MESSAGE_MARKS),
        ('"%d", 1, 2', C.MESSAGE_MARKS),
        ('"100 %"', C.MESSAGE_MARK),
        ('"%x", 1', C.MESSAGE_MARK),
        ('"%d%d%d%d%d%d%d%d%d%d%d",1,2,3,4,5,6,7,8,9,0,1', C.MESSAGE_VALUES),
        ('"%d", "one"', C.MESSAGE_VALUE),
        ('"%s", 1', C.MESSAGE_VALUE),
        ('"%u", -1', C.MESSAGE_VALUE),
    ],
)
def test_values_that_do_not_fit_their_format_elements(arguments: str, entry: object) -> None:
    assert problem(f"#MSG [{arguments}]") == (entry, 7)


@pytest.mark.parametrize("value", [0.0, 1.0, -1e-300, 9.99999999999e99, 123456.789])
def test_a_real_number_reads_back_as_what_it_was(value: float) -> None:
    assert float(composed("%f", [value], "#MSG")) == pytest.approx(value, rel=1e-10)


@pytest.mark.spec("isg.add.msg-info")
def test_message_information_is_marked() -> None:
    run, machine = ran('P1 = 20\n#MSG INFO ["RED,%d,BOLD",P1]\n#MSG INFO SYN HMI ["A"]\n#MSG ["plain"]')
    assert [(m.text, m.information) for _, m in machine.told] == [("RED,20,BOLD", True), ("plain", False)]
    assert [(m.text, m.information, m.receiver) for m in sent(run)] == [("A", True, Receiver.HMI)]


@pytest.mark.spec("isg.add.msg-macro")
def test_a_whole_message_may_be_a_macro() -> None:
    setup = replace(SETUP, macros={"Message_1": '#MSG ["Message text"]'})
    _, machine = ran('"Message_1"\n"OWN" = "#MSG HMI [\\"own %d\\", P1]"\nP1 = 3\n"OWN"\nP1 = 4\nN9 "OWN"', setup=setup)
    assert machine.texts == ["Message text", "own 3", "own 4"]


@pytest.mark.spec("isg.add.add")
def test_additional_information_at_the_end_of_a_block() -> None:
    run, machine = ran(
        'N5 G01 X1 F100 #ADD HMI ["at %d", 7] (comment)\nP1 = 1 #ADD ["assigned"]\n#MSG ["a"] #ADD ["b"]'
    )
    assert [type(block) for block in run.blocks][:2] == [Line, Message]
    assert [(m.text, m.receiver, m.source.line, m.source.n) for m in sent(run)] == [
        ("at 7", Receiver.HMI, 1, 5),
        ("assigned", Receiver.DIAGNOSIS, 2, None),
        ("b", Receiver.DIAGNOSIS, 3, None),
    ]
    assert machine.texts == ["a"]
    assert run.parameters[1] == 1


@pytest.mark.spec("isg.add.add")
@pytest.mark.parametrize(
    ("text", "entry"), [('X1 #ADD SYN ["a"]', C.WORD_UNKNOWN), ('X1 #ADD ["a"] Y2', C.STATEMENT_ARGUMENTS)]
)
def test_what_additional_information_refuses(text: str, entry: object) -> None:
    assert problem(f"F100\n{text}")[0] is entry


def test_add_within_a_text_is_text() -> None:
    _, machine = ran('#MSG ["see #ADD there"]')
    assert machine.texts == ["see #ADD there"]


# -- #ERROR --------------------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.add.error")
def test_a_warning_is_told_at_once_and_the_program_goes_on() -> None:
    run, machine = ran("#ERROR [ID100 RC0 MID10]\n#ERROR []\nP1 = 1")
    assert [(e.number, e.remedy_class, e.multiple) for e in machine.warnings] == [(100, 0, 10), (1, 0, 0)]
    assert run.parameters == {1: 1}
    assert not any(isinstance(block, UserError) for block in run.blocks)


@pytest.mark.spec("isg.add.error")
def test_an_error_stands_on_the_path_with_its_values() -> None:
    text = (
        "#ERROR [ID455 RC2 PV1=5 PV2=4.999 PM1=2 PM2=3]\n"
        '#ERROR [ID123 RC2 PV1="Text-A" PM1=4 PV2="Text-B" PM2=3]\n'
        "#ERROR [ID=999, RC=7, PV3=1+1, PIV2=8]"
    )
    run, machine = ran(text)
    errors = [block for block in run.blocks if isinstance(block, UserError)]
    assert [(e.number, e.remedy_class, e.values, e.meanings, e.further) for e in errors] == [
        (455, 2, (5.0, 4.999), (2, 3), ()),
        (123, 2, ("Text-A", "Text-B"), (4, 3), ()),
        (999, 7, (0.0, 0.0, 2.0), (1, 1, 1), (0.0, 8.0)),
    ]
    assert machine.warnings == []


@pytest.mark.spec("isg.add.error")
def test_nothing_behind_an_error_is_decoded_ahead_of_it() -> None:
    run, _ = ran("#ERROR [RC2]\nV.S.AFTER = 1")
    assert [type(block) for block in run.blocks][:2] == [UserError, Flush]
    flush = run.blocks[1]
    assert isinstance(flush, Flush)
    assert flush.kind is FlushKind.WAIT


@pytest.mark.spec("isg.add.error")
@pytest.mark.parametrize(
    ("keys", "column"),
    [("ID0", 11), ("ID1001", 11), ("ID1 RC1", 15), ("ID1 MID=-1", 17), ("PM1=22", 13), (f'PV1="{"x" * 24}"', 13)],
)
def test_values_of_an_error_have_their_ranges(keys: str, column: int) -> None:
    assert problem(f"#ERROR [{keys}]") == (C.ERROR_VALUE, column)


# -- #TIMER --------------------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.add.timer")
def test_timers_of_decoding_time() -> None:
    machine = Machine()
    machine.counts = {10: 250}
    text = (
        "#TIMER START [ID=10]\nP1 = V.G.TIMER[10]\n#TIMER READ [ID10]\nP2 = V.G.TIMER[10]\n"
        "#TIMER STOP [ID10]\n#TIMER CLEAR [ID10]\nP3 = V.G.TIMER[10]"
    )
    run, _ = ran(text, machine)
    assert machine.commands == [
        (TimerCommand.START, 10),
        (TimerCommand.READ, 10),
        (TimerCommand.STOP, 10),
        (TimerCommand.CLEAR, 10),
    ]
    assert run.parameters == {1: 0, 2: 250, 3: 250}  # CLEAR leaves the variable as it is


@pytest.mark.spec("isg.add.timer")
def test_timers_of_the_path_and_reading_them_waits() -> None:
    machine = Machine()
    machine.counts = {11: 5}
    run, _ = ran("#TIMER START SYN[ID11]\n#TIMER READ SYN [ID11]\nP1 = V.G.TIMER[11]\n#TIMER STOP SYN [ID11]", machine)
    assert [(b.command, b.timer) for b in run.blocks if isinstance(b, TimerAction)] == [
        (TimerCommand.START, 11),
        (TimerCommand.READ, 11),
        (TimerCommand.STOP, 11),
    ]
    kinds = [type(block) for block in run.blocks]
    assert kinds[1:4] == [TimerAction, Flush, Hold]
    assert run.parameters == {1: 1005}
    assert machine.commands == []


@pytest.mark.spec("isg.add.timer")
@pytest.mark.parametrize(
    ("text", "entry"),
    [
        ("#TIMER START [ID=10, ID11]", C.KEY_TWICE),
        ("#TIMER START [ID=128]", C.TIMER_NUMBER),
        ("#TIMER READ SYN [ID=-1]", C.TIMER_NUMBER),
        ("#TIMER STOP []", C.KEY_MISSING),
        ("P1 = V.G.TIMER[128]", C.SET_INDEX),
        ("V.G.TIMER[1] = 5", C.VARIABLE_READ_ONLY),
    ],
)
def test_what_timers_refuse(text: str, entry: object) -> None:
    assert _any_problem(text)[0] is entry


# -- waiting -------------------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.add.wait-for")
def test_waiting_for_a_condition_of_the_outside() -> None:
    asked = []

    def count(machine: Machine) -> None:
        asked.append(True)
        machine.external[0] = len(asked)

    text = "N10 #WAIT FOR V.E.BYTE == 5\nP1 = V.E.BYTE\n#WAIT FOR V.E.BYTE\nP2 = 1"
    run, _ = ran(text, Machine(count), setup=replace(SETUP, external=EXTERNAL))
    assert len(asked) == 5
    assert run.parameters == {1: 5, 2: 1}
    holds = [block for block in run.blocks if isinstance(block, Hold)]
    assert len(holds) == 5
    assert {(hold.source.line, hold.source.n) for hold in holds} == {(1, 10)}


@pytest.mark.spec("isg.add.wait-for")
@pytest.mark.parametrize(("value", "waits"), [("0.5", True), ("0.51", False), ("TRUE", False), ("-1", True)])
def test_a_wait_ends_above_a_half(value: str, waits: bool) -> None:
    class GivesUp(Machine):
        def waits_in_vain(self) -> bool:
            return bool(self.commands)

    machine = GivesUp(lambda m: m.commands.append((TimerCommand.READ, 0)))
    run, _ = ran(f"#WAIT FOR {value}\nP1 = 1", machine)
    assert any(isinstance(block, Hold) for block in run.blocks) is waits


def test_waiting_for_a_synchronous_variable_flushes_once() -> None:
    asked = []

    def count(machine: Machine) -> None:
        asked.append(True)
        machine.external[8] = len(asked)

    run, _ = ran("#WAIT FOR V.E.SYNC == 3", Machine(count), setup=replace(SETUP, external=EXTERNAL))
    assert [type(block) for block in run.blocks][:4] == [Flush, Hold, Hold, Hold]


@pytest.mark.spec("isg.add.flush")
@pytest.mark.spec("isg.add.flush-continue")
@pytest.mark.spec("isg.add.flush-wait")
@pytest.mark.parametrize(
    ("text", "kind"),
    [("#FLUSH", FlushKind.STOP), ("#FLUSH CONTINUE", FlushKind.CONTINUE), ("#FLUSH WAIT", FlushKind.WAIT)],
)
def test_flush_stands_behind_the_motion_before_it(text: str, kind: FlushKind) -> None:
    run, _ = ran(f"G01 X1 F100\nN20 {text}\nX2")
    assert [type(block) for block in run.blocks][:3] == [Polyline, Flush, Polyline]
    flush = run.blocks[1]
    assert isinstance(flush, Flush)
    assert (flush.kind, flush.source.line, flush.source.n) == (kind, 2, 20)
