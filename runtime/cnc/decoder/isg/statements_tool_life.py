"""#TOOL LIFE and V.TLM: the record of how long and how far tools are in use (programming manual 29426–29530)."""

from __future__ import annotations

import math

from runtime.cnc.blocks import LifeCommand
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, statement, variable, writes
from runtime.cnc.decoder.isg.statements_tools import tool_id
from runtime.cnc.decoder.tool_management import tell_life
from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.isg.functions import as_number
from runtime.cnc.language.isg.syntax import Form, Key
from runtime.diagnostics.catalogue import tools as catalogue

_READ = "isg.toolext.life-read-remove"
_WEIGHTS = "isg.toolext.life-weighting"


@statement("TOOL LIFE READ", _READ, syntax="#TOOL LIFE READ [<basic>[,<sister>[,<variant>]]]", form=Form.PLACES)
def read(x: Execution, call: StatementCall) -> None:
    """What was recorded so far is told to the management, as that of the tool that is named; the record goes on."""
    tell_life(x, LifeCommand.READ, tool_id(call))


@statement("TOOL LIFE REMOVE", _READ)
def remove(x: Execution, call: StatementCall) -> None:
    """The record of the active tool begins at 0 again."""
    tell_life(x, LifeCommand.REMOVE)


@statement(
    "TOOL LIFE DEF",
    "isg.toolext.life-def",
    syntax="#TOOL LIFE DEF [DIST=.. TIME=..]",
    form=Form.KEYS,
    keys=(Key("DIST", needed=True), Key("TIME", needed=True)),
)
def define(x: Execution, call: StatementCall) -> None:
    """The record of the active tool goes on from a distance in mm and a time in s."""
    values = {key: call.needed(key) for key in ("DIST", "TIME")}
    for key, value in values.items():
        if not 0 <= value < math.inf:
            raise call.error(catalogue.FIELD_VALUE, key, name=key, value=value, reason="it is at least 0")
    tell_life(x, LifeCommand.DEFINE, time=values["TIME"], distance=values["DIST"])


def _factor(value: object, name: str) -> float:
    factor = as_number(value, name)
    if not 0 <= factor < math.inf:
        raise CalculationError(catalogue.FIELD_VALUE, name, value=factor, reason="it is at least 0")
    return factor


@variable("V.TLM.TIME_FACT", _WEIGHTS, "what the time of use of a tool is multiplied with")
def time_factor(x: Execution) -> float:
    return x.memory.life_factors[0]


@writes("V.TLM.TIME_FACT")
def set_time_factor(x: Execution, value: object) -> None:
    x.memory.life_factors[0] = _factor(value, "V.TLM.TIME_FACT")
    tell_life_factors(x)


@variable("V.TLM.DIST_FACT", _WEIGHTS, "what the distance of use of a tool is multiplied with")
def distance_factor(x: Execution) -> float:
    return x.memory.life_factors[1]


@writes("V.TLM.DIST_FACT")
def set_distance_factor(x: Execution, value: object) -> None:
    x.memory.life_factors[1] = _factor(value, "V.TLM.DIST_FACT")
    tell_life_factors(x)


def tell_life_factors(x: Execution) -> None:
    tell_life(x, LifeCommand.WEIGHT, time=x.memory.life_factors[0], distance=x.memory.life_factors[1])
