"""#TIMER: 128 counters of milliseconds that all channels share (programming manual 15464–15565)."""

from __future__ import annotations

from runtime.cnc.blocks import Flush, FlushKind, TimerAction, TimerCommand
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, StatementHandler, statement
from runtime.cnc.decoder.memory import TIMERS
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.syntax import Form, Key
from runtime.diagnostics.catalogue import language as catalogue


class _Read:
    """A counter that is being read on the path."""

    __slots__ = ("timer",)

    def __init__(self, timer: int) -> None:
        self.timer = timer


def _timer(command: TimerCommand) -> StatementHandler:
    @statement(
        f"TIMER {command.value}",
        "isg.add.timer",
        syntax=f"#TIMER {command.value} [SYN] [ID=..]",
        form=Form.KEYS,
        keys=(Key("ID", needed=True),),
        words=("SYN",),
    )
    def act(x: Execution, call: StatementCall) -> None:
        """At decoding time, or with SYN when the path is there."""
        timer = _number(call)
        if not call.words():
            count = x.outside.timer(command, timer)
            if command is TimerCommand.READ:
                x.memory.timers[timer] = float(count)
            return
        if command is not TimerCommand.READ:
            x.emit(TimerAction(x.source, command, timer))
            return
        if not isinstance(x.waiting, _Read):
            x.emit(TimerAction(x.source, command, timer))
            x.emit(Flush(x.source, FlushKind.WAIT))
            x.waiting = _Read(timer)
            x.repeat("count of a timer")
            if x.again is not None:
                return
        x.memory.timers[timer] = float(x.outside.latched(timer))
        x.waiting = None

    return act


def _number(call: StatementCall) -> int:
    value = call.needed("ID")
    if not -0.5 <= value < TIMERS - 0.5:
        raise call.error(catalogue.TIMER_NUMBER, "ID", value=value, last=TIMERS - 1)
    return round_half_up(value)


for _command in TimerCommand:
    _timer(_command)
