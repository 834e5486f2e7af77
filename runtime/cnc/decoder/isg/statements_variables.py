"""# statements that make and remove variables and macros."""

from __future__ import annotations

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, statement


@statement("VAR", "isg.param.arrays", "isg.var.user-declaration", syntax="#VAR … #ENDVAR")
def begin_declarations(x: Execution, call: StatementCall) -> None:
    x.declaring = True


@statement("ENDVAR", "isg.param.arrays", "isg.var.user-declaration")
def end_declarations(x: Execution, call: StatementCall) -> None:
    x.declaring = False
