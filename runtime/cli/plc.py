"""`tandem plc`: the PLC program of a running machine."""

from __future__ import annotations

import time
from typing import Annotated

import typer

from runtime.diagnostics.catalogue import plc as catalogue
from runtime.diagnostics.errors import ErrorEntry, Place
from runtime.hli.memory import HliMemory, get_text
from runtime.plc_logic.errors import PlcFailure

app = typer.Typer(
    help="The PLC program of a running machine.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
_LOOK_EVERY = 0.02  # s


@app.callback()
def _common() -> None:
    """The PLC program of a running machine."""


@app.command()
def reload(
    name: Annotated[str, typer.Option("--name", help="Name of the runtime (its shared memory).")] = "tandem",
    timeout: Annotated[float, typer.Option(help="Seconds to wait for the answer.", min=0.1)] = 20.0,
) -> None:
    """Replace the program by what its files contain now, at the border of a PLC cycle; unchanged variables keep their state.

    A new version that is broken is refused with its traceback, and the old one goes on.
    """
    with HliMemory.attach(name) as memory:
        platform = memory.hli.platform
        if not (platform.plc_running_r and memory.owner_alive):
            raise PlcFailure(catalogue.PLC_NOT_RELOADABLE, Place(), "", name=name)
        platform.reload_request_w += 1
        request = platform.reload_request_w
        end = time.monotonic() + timeout
        while platform.reload_done_w != request:
            if time.monotonic() > end or not memory.owner_alive:
                raise PlcFailure(catalogue.PLC_RELOAD_NO_ANSWER, Place(), "", name=name, seconds=timeout)
            time.sleep(_LOOK_EVERY)
        text = get_text(platform, "reload_text_w")
        if platform.reload_error_w:
            entry = ErrorEntry(platform.reload_error_w, "{text}", remedy="the old program goes on")
            raise PlcFailure(entry, Place(), "", text=text)
        print(text)
