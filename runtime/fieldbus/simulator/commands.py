"""Faults by hand: lines on standard input of the simulator process tell its nodes what shall befall them.

silent 2          a fault of runtime.fieldbus.simulator.drive.Fault, for node 2
drive 1 0x4310    a drive fault with its error code
heal 2            undo
"""

from __future__ import annotations

import os
import sys

from runtime.fieldbus.simulator.drive import OVER_CURRENT, Fault
from runtime.fieldbus.simulator.nodes import SimulatedNodes


class CommandLines:
    """Reads a descriptor without ever waiting for it; what is not understood is answered on standard error."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._rest = b""
        os.set_blocking(descriptor, False)

    def obey(self, nodes: SimulatedNodes) -> None:
        """Carry out every line that has come."""
        try:
            data = os.read(self._descriptor, 4096)
        except BlockingIOError:
            return
        *lines, self._rest = (self._rest + data).split(b"\n")
        for line in lines:
            words = line.decode(errors="replace").split()
            try:
                _carry_out(words, nodes)
            except (ValueError, KeyError, IndexError) as error:
                print(f"simulator: {' '.join(words)!r} is not understood: {error!r}", file=sys.stderr)


def _carry_out(words: list[str], nodes: SimulatedNodes) -> None:
    """Raises ValueError, KeyError or IndexError for what is no command of these nodes."""
    node = int(words[1], 0)
    if words[0] == "heal":
        nodes.heal(node)
    else:
        nodes.inject(node, Fault(words[0]), int(words[2], 0) if len(words) > 2 else OVER_CURRENT)
