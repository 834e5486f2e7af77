"""#FILTER: FIR filters of the set-points (programming manual 9473–9567)."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from runtime.cnc.blocks import FilterChange, Flush, FlushKind
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.contouring import length_unit
from runtime.cnc.decoder.isg.registry import StatementCall, StatementHandler, statement
from runtime.cnc.language.isg.syntax import Form, Key
from runtime.config.fir_filter import MOST_ORDER
from runtime.diagnostics.catalogue import smoothing as catalogue

_SPEC = "isg.smooth.fir-filter"
_KEYS = ("ORDER", "ORDER_TIME", "SHARE", "AX_DEV", "FCUT", "ACC_FACT", "QUALITY")
_SYNTAX = "[ORDER=.. | ORDER_TIME=..] [SHARE=..] [AX_DEV=..] [FCUT=..] [ACC_FACT=..] [QUALITY=..]"
_MICROSECOND = 1e-6


def _set(x: Execution, call: StatementCall, on: bool | None) -> None:
    now = x.smoothing.filter
    if call.given("ORDER") and call.given("ORDER_TIME"):
        raise call.error(catalogue.CHOOSE_ONE, "ORDER_TIME", first="ORDER", second="ORDER_TIME")
    chosen = replace(now, on=now.on if on is None else on, **_values(x, call))
    if chosen.on:
        filters = [given for given in x.setup.filters if given is not None]
        if not filters:
            raise call.error(catalogue.NO_FILTER)
        if not (chosen.order or chosen.order_time or any(given.cycles(x.setup.period) for given in filters)):
            raise call.error(catalogue.FILTER_WITHOUT_ORDER)
    x.smoothing.filter = chosen
    if chosen.on or now.on:
        x.emit(Flush(x.source, FlushKind.STOP))  # the filter can only be changed while the axes stand
        x.emit(FilterChange(x.source, chosen))


def _values(x: Execution, call: StatementCall) -> dict[str, Any]:
    """What the statement names, in the units of the settings."""
    period = x.setup.period
    found: dict[str, Any] = {}
    if call.given("ORDER"):
        order = _within(call, "ORDER", 0.0, float(MOST_ORDER))
        if order != round(order):
            raise call.error(catalogue.VALUE_RANGE, "ORDER", key="ORDER", value=order, least=0.0, most=MOST_ORDER)
        found |= {"order": round(order), "order_time": None}
    if call.given("ORDER_TIME"):
        most = MOST_ORDER * period / _MICROSECOND
        found |= {"order": None, "order_time": _within(call, "ORDER_TIME", 0.0, most) * _MICROSECOND}
    if call.given("SHARE"):
        found["share"] = _within(call, "SHARE", 0.0, 100.0) / 100.0
    if call.given("AX_DEV"):
        found["deviation"] = _within(call, "AX_DEV", 0.0, 1e6) * length_unit(x)
    if call.given("FCUT"):
        found["cut_off"] = _within(call, "FCUT", 1.0, 0.5 / period)
    if call.given("ACC_FACT"):
        found["corner_factor"] = _within(call, "ACC_FACT", 1.0, 10.0)
    if call.given("QUALITY"):
        quality = _within(call, "QUALITY", 0.0, 1.0)
        if quality == 0.0:
            raise call.error(catalogue.NOT_ABOVE, "QUALITY", key="QUALITY", value=quality, least=0.0)
        found["quality"] = quality
    return found


def _within(call: StatementCall, key: str, least: float, most: float) -> float:
    value = call.needed(key)
    if not least <= value <= most:
        raise call.error(catalogue.VALUE_RANGE, key, key=key, value=value, least=least, most=most)
    return value


def _filter(name: str, on: bool | None) -> StatementHandler:
    @statement(
        name, _SPEC, syntax=f"#{name} {_SYNTAX}" if on is None else f"#{name} [{_SYNTAX}]",
        form=Form.KEYS, keys=tuple(Key(key) for key in _KEYS), optional=on is not None,
    )  # fmt: skip
    def filters(x: Execution, call: StatementCall) -> None:
        """Settings stay until they are programmed anew, also while the filter is off."""
        _set(x, call, on)

    return filters


_filter("FILTER", None)
_filter("FILTER ON", True)
_filter("FILTER OFF", False)
