"""Registration of commands in brackets behind the name of an axis of the channel: <axis>[KEYWORD ..]."""

from __future__ import annotations

from collections.abc import Callable

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, StatementHandler, statement
from runtime.cnc.language.isg.job_brackets import job_name
from runtime.cnc.language.isg.syntax import Form, Key
from runtime.diagnostics.catalogue import language as catalogue

AxisHandler = Callable[[Execution, StatementCall, int], None]


def axis_command(
    keyword: str, *spec: str, syntax: tuple[str, ...], keys: tuple[Key, ...], alone: bool = True
) -> Callable[[AxisHandler], StatementHandler]:
    """Register the decorated handler, which gets the channel index of the axis; `syntax` without the name of the axis.

    `alone`: nothing but the block number may stand beside it.
    """

    def register(handler: AxisHandler) -> StatementHandler:
        def run(x: Execution, call: StatementCall) -> None:
            if alone and x.block is not None and len(x.block.words) > 1:
                raise call.error(catalogue.NOT_ALONE, word=f"<axis>[{keyword}]")
            argument = call.argument("AX")
            assert argument is not None
            handler(x, call, argument.index)

        run.__doc__ = handler.__doc__
        shown = tuple(f"<axis>[{text}]" for text in syntax)
        return statement(job_name(keyword), *spec, syntax=shown, form=Form.KEYS, keys=keys, prefix="")(run)

    return register


def chosen(call: StatementCall, keyword: str, *switches: str) -> str:
    """The one of the switches that is given. Raises LineError for none or several."""
    given = [name for name in switches if call.given(name)]
    if len(given) != 1:
        raise call.error(
            catalogue.KEY_MISSING, key=f"one of {', '.join(switches)}", statement=f"<axis>[{keyword}]",
            syntax=call.syntax.syntax[0],
        )  # fmt: skip
    return given[0]
