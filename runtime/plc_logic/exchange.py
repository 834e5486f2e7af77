"""Replacing the PLC program while it runs: from the request in the HLI to the answer.

request ─▶ load (beside the cycles) ─▶ no sequence under way? ─▶ state taken over, first cycle ─▶ answer
                │ syntax, import              │ too long                  │ setup or cycle raised
                └─────────────────────────────┴───────────────────────────┴──▶ refused, the old one goes on
"""

from __future__ import annotations

from collections.abc import Callable

from runtime.diagnostics.catalogue import plc as catalogue
from runtime.diagnostics.errors import Place
from runtime.hli.layout import Hli
from runtime.hli.memory import put_text
from runtime.plc_logic.errors import PlcFailure
from runtime.plc_logic.host import PlcHost
from runtime.plc_logic.program import Program

PATIENCE = 10.0  # s that sequences under way get to end
SHOWN = 12  # names of variables in the answer

Loaded = type[Program] | PlcFailure


class ProgramExchange:
    """`cycle` takes the place of the host's cycle. `load` hands back a function that tells the result, None until it is there."""

    def __init__(self, host: PlcHost, hli: Hli, load: Callable[[], Callable[[], Loaded | None]]) -> None:
        self._host = host
        self._platform = hli.platform
        self._load = load
        self._answered = int(hli.platform.reload_request_w)
        self._loading: Callable[[], Loaded | None] | None = None
        self._request = self._answered
        self._waits_since_ns: int | None = None

    def cycle(self, time_ns: int) -> None:
        """One PLC cycle, with the old program or the new one. Raises PlcFailure as the host does."""
        program = self._due(time_ns)
        if program is None:
            self._host.cycle(time_ns)
            return
        try:
            taken = self._host.replace(program, time_ns)
        except PlcFailure as failure:
            self._refuse(failure)
            self._host.cycle(time_ns)
        else:
            changed = _listed(taken.changed) or "none"
            text = f"{program.__name__} runs; state kept: {_listed(taken.kept) or 'none'}; begun anew: {changed}"
            self._answer(0, text)

    def _due(self, time_ns: int) -> type[Program] | None:
        """The new program when it can begin in this cycle."""
        if self._loading is None:
            if self._platform.reload_request_w == self._answered:
                return None
            self._request = int(self._platform.reload_request_w)
            self._loading = self._load()
            self._waits_since_ns = None
        loaded = self._loading()
        if loaded is None:
            return None
        if isinstance(loaded, PlcFailure):
            self._refuse(loaded)
            return None
        sequences = self._host.sequences
        if not sequences:
            return loaded
        if self._waits_since_ns is None:
            self._waits_since_ns = time_ns
        if time_ns - self._waits_since_ns > PATIENCE * 1e9:
            values = {"program": loaded.__name__, "functions": ", ".join(sequences), "seconds": PATIENCE}
            self._refuse(PlcFailure(catalogue.PLC_RELOAD_BUSY, Place(), "", **values))
        return None

    def _refuse(self, failure: PlcFailure) -> None:
        problem = failure.problem
        self._answer(problem.entry.id, "\n".join(part for part in (problem.text, failure.trace) if part))

    def _answer(self, error: int, text: str) -> None:
        platform = self._platform
        platform.reload_error_w = error
        put_text(platform, "reload_text_w", text)
        self._answered = self._request
        self._loading = None
        platform.reload_done_w = self._request


def _listed(names: tuple[str, ...]) -> str:
    more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return ", ".join(names[:SHOWN]) + more
