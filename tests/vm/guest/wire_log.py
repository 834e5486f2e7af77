"""A listener beside the master: every frame goes into a file, with the time at which the kernel got it.

On the master's card, where the kernel hands over what was sent without loss; a card that receives has room for six frames.

python -m tests.vm.guest.wire_log INTERFACE FILE         until SIGTERM; a record: `RECORD`
"""

from __future__ import annotations

import signal
import socket
import struct
import sys
from types import FrameType
from typing import Final

RECORD: Final = struct.Struct("<dIB8s")  # s since 1970, identifier with its flags, length, data
_FRAME: Final = struct.Struct("=IB3x8s")
_SO_TIMESTAMP: Final = 29
_TIMEVAL: Final = struct.Struct("@ll")


def main() -> int:
    interface, file = sys.argv[1:]
    ended = False

    def end(_number: int, _frame: FrameType | None) -> None:
        nonlocal ended
        ended = True

    signal.signal(signal.SIGTERM, end)
    with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as wire, open(file, "wb", 1 << 16) as log:
        wire.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4 << 20)
        wire.setsockopt(socket.SOL_SOCKET, _SO_TIMESTAMP, 1)
        wire.settimeout(0.2)
        wire.bind((interface,))
        while not ended:
            try:
                data, extra, _, _ = wire.recvmsg(16, 64)
            except TimeoutError:
                continue
            except OSError:  # the interface is down, which is part of the tests
                continue
            seconds, microseconds = _TIMEVAL.unpack_from(extra[0][2])
            identifier, length, payload = _FRAME.unpack(data)
            log.write(RECORD.pack(seconds + microseconds * 1e-6, identifier, length, payload))
    return 0


if __name__ == "__main__":
    sys.exit(main())
