"""# statements of the channel: flush, waiting."""

from __future__ import annotations

from runtime.cnc.blocks import DistanceMark, Flush, FlushKind, SearchArea
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, statement
from runtime.cnc.language.isg.syntax import Form


@statement("FLUSH", "isg.add.flush")
def flush(x: Execution, call: StatementCall) -> None:
    x.emit(Flush(x.source, FlushKind.STOP))


@statement("FLUSH CONTINUE", "isg.add.flush-continue")
def flush_continue(x: Execution, call: StatementCall) -> None:
    x.emit(Flush(x.source, FlushKind.CONTINUE))


@statement("FLUSH WAIT", "isg.add.flush-wait")
def flush_wait(x: Execution, call: StatementCall) -> None:
    x.emit(Flush(x.source, FlushKind.WAIT))


@statement("WAIT FOR", "isg.add.wait-for", syntax="#WAIT FOR <expression>", form=Form.VALUE)
def wait_for(x: Execution, call: StatementCall) -> None:
    """Decoding stands until the expression is above 0.5 (line 12440)."""
    if not call.needed() > 0.5:
        x.repeat("#WAIT FOR")


@statement("BLOCKSEARCH LOCKED", "hli.ch.cu.block-search")
def search_locked(x: Execution, call: StatementCall) -> None:
    """No block search enters the program from here on."""
    x.emit(SearchArea(x.source, True))


@statement("BLOCKSEARCH RELEASED", "hli.ch.cu.block-search")
def search_released(x: Execution, call: StatementCall) -> None:
    x.emit(SearchArea(x.source, False))


@statement("DIST TO GO BEGIN", "isg.add.dist-to-go")
def distance_begins(x: Execution, call: StatementCall) -> None:
    x.emit(DistanceMark(x.source, True))


@statement("DIST TO GO END", "isg.add.dist-to-go")
def distance_ends(x: Execution, call: StatementCall) -> None:
    x.emit(DistanceMark(x.source, False))
