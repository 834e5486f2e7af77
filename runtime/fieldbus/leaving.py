"""The end of a run: drives disabled in order, outputs off, nodes out of operation. One master or several."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final, Protocol

from runtime.drives import DriveImage

STOP_TIME: Final = 3.0  # s, the longest that the drives are waited for


class Leaving(Protocol):
    """What a master does at its end; nothing of it raises."""

    @property
    def running(self) -> bool: ...
    @property
    def resting(self) -> bool: ...
    def read(self) -> None: ...
    def write_set_points(self) -> None: ...
    def write_sync(self) -> None: ...
    def switch_off_outputs(self) -> None: ...
    def refresh_outputs(self) -> None: ...
    def pass_a_cycle(self) -> None: ...
    def leave(self) -> None: ...


def stop_all(masters: Sequence[Leaving], image: DriveImage, now: Callable[[], float]) -> None:
    """Stop the masters of a machine together. At most some seconds; never raises."""
    masters = [master for master in masters if master.running]
    if not masters:
        return

    def cycle() -> None:
        for master in masters:
            master.read()
        for master in masters:
            master.write_set_points()
        for master in masters:
            master.write_sync()
        masters[0].pass_a_cycle()

    image.enable[:] = False
    image.reset_fault[:] = False
    end = now() + STOP_TIME
    while now() < end:
        cycle()
        if all(master.resting for master in masters):
            break
    image.digital_out[:] = 0
    for master in masters:
        master.switch_off_outputs()
        master.refresh_outputs()
    cycle()
    for master in masters:
        master.leave()
