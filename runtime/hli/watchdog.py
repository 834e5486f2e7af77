"""The watchdog of the PLC, seen from the CNC: how long since its last sign of life
(hli.mech.watchdog-cnc-monitors-plc)."""

from __future__ import annotations

from runtime.diagnostics.catalogue import plc as catalogue
from runtime.diagnostics.errors import Problem
from runtime.hli.layout import Channel, Watchdog


class PlcWatchdog:
    """Looks for the rising edges of `alive_rw` of one channel; call `check` once per cycle."""

    def __init__(self, channel: Channel) -> None:
        self._channel = channel
        self._watchdog: Watchdog = channel.watchdog
        self._last_edge_ns: int | None = None  # None: not supervised
        self._reported = False

    def check(self, now_ns: int) -> Problem | None:
        """Error 270053, once per loss, when the PLC was silent for longer than it promised; `now_ns` is the runtime's
        clock.

        Supervision begins when the PLC is present and enables the watchdog, and begins anew with the next sign of life.
        """
        watchdog = self._watchdog
        watchdog.lc_alive_rw = True
        if not (watchdog.enable_w and self._channel.plc_present_w):
            self._last_edge_ns = None
            self._reported = False
            watchdog.alive_state_r = False
            return None
        if watchdog.alive_rw:
            watchdog.alive_rw = False
            self._last_edge_ns = now_ns
            self._reported = False
            watchdog.alive_state_r = True
            return None
        if self._last_edge_ns is None:
            self._last_edge_ns = now_ns
        silent_ns = now_ns - self._last_edge_ns
        if self._reported or silent_ns <= int(watchdog.cycle_time_w) * 1000:
            return None
        self._reported = True
        watchdog.alive_state_r = False
        return Problem(
            catalogue.PLC_WATCHDOG, {"milliseconds": silent_ns // 1_000_000, "allowed": watchdog.cycle_time_w / 1000}
        )
