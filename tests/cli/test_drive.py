"""`tandem drive` with the demo machine's simulated nodes, in virtual time; its keys on pipes and on a terminal."""

from __future__ import annotations

import os
import pty
import select
import signal
import termios
from collections.abc import Callable, Iterator
from pathlib import Path

import can
import pytest

from runtime.cli import drive as command
from runtime.cli.keys import Keys, StatusLine
from runtime.cli.main import main
from runtime.drives import DriveState
from runtime.fieldbus.commissioning import Commissioning
from runtime.fieldbus.jog import DeadMan, DriveSession
from tests.fieldbus.rig import Rig


class Hand(Keys):
    """Keys by the virtual time: what `pressed(time)` gives."""

    pressed: Callable[[], bytes | None]

    def __init__(self) -> None:
        super().__init__(os.open(os.devnull, os.O_RDONLY))

    def __exit__(self, *_: object) -> None:
        super().__exit__()
        os.close(self._descriptor)

    def read(self) -> bytes | None:
        return None if self.ended else type(self).pressed()


@pytest.fixture
def rig(monkeypatch: pytest.MonkeyPatch) -> Iterator[Rig]:
    """The machine that every `tandem drive` finds, with its bus in virtual time."""
    with Rig() as rig:
        rig.idle()

        class Looking(Commissioning):
            def __init__(self, bus: can.BusABC, *_: object) -> None:
                super().__init__(bus, lambda: rig.time, rig.idle)

        class Session(DriveSession):
            def __init__(self, machine: object, axis: object, bus: can.BusABC, **_: object) -> None:
                super().__init__(machine, axis, bus, now=lambda: rig.time, idle=rig.idle)  # type: ignore[arg-type]

        channel = rig.machine.fieldbus.bus.channel
        monkeypatch.setattr(command, "Commissioning", Looking)
        monkeypatch.setattr(command, "DriveSession", Session)
        monkeypatch.setattr(command, "Keys", Hand)
        monkeypatch.setattr(os, "sched_setscheduler", lambda *_: None)
        monkeypatch.setattr(command, "load_machine", lambda path: rig.machine)
        monkeypatch.setattr(command, "open_bus", lambda bus: can.Bus(interface="virtual", channel=channel))
        yield rig


def told(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    code = main(["drive", *arguments])
    out, err = capsys.readouterr()
    return code, out, err


def test_state_and_objects(rig: Rig, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, _ = told(capsys, "state", "X")
    assert code == 0
    assert "switch on disabled" in out
    assert "no error" in out
    assert "(0x6064): 0, 0 mm" in out
    code, out, _ = told(capsys, "objects", "X", "quick")
    assert code == 0
    assert "0x6085" in out
    assert "0x6064" not in out
    assert (
        "0x1008 Manufacturer device name = Tandem simulated CiA 402 drive"
        in told(capsys, "read", "X", "0x1008", "0x6064")[1]
    )
    assert "= 5000 " not in told(capsys, "write", "X", "0x6085", "5000")[2]
    assert "= 5000 (0x1388)" in told(capsys, "read", "X", "0x6085")[1]
    code, _, err = told(capsys, "write", "X", "0x6064", "1")
    assert (code, "303111" in err) == (1, True)
    code, _, err = told(capsys, "read", "W", "0x6064")
    assert (code, "303112" in err, "X, Y, Z, S" in err) == (1, True, True)


def test_a_running_machine_is_left_alone(rig: Rig, capsys: pytest.CaptureFixture[str]) -> None:
    rig.enabled()
    rig.idle = lambda: rig.cycle()  # type: ignore[method-assign]
    for arguments in (("state", "X"), ("write", "X", "0x6085", "1"), ("jog", "X"), ("tune", "X", "--by", "1")):
        code, _, err = told(capsys, *arguments)
        assert (code, "another CANopen master" in err) == (1, True)
    assert rig.event_ids() == []


def test_jog_by_keys(rig: Rig, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    begin: list[float] = []

    def pressed() -> bytes:
        begin.append(rig.time)
        elapsed = rig.time - begin[0]
        return b"+" if elapsed < 0.2 else b"" if elapsed < 1.5 else b"q"

    monkeypatch.setattr(Hand, "pressed", staticmethod(pressed), raising=False)
    code, out, _ = told(capsys, "jog", "X", "--velocity", "20", "--dead-man", "0.1")
    assert code == 0
    assert "X from -10 to 10 mm with 20 mm/s" in out
    position = rig.simulated.drives[1].servo.position / 10_000
    assert position == pytest.approx(20.0 * 0.3, rel=0.05)  # while it was held, and the dead-man's time
    assert f"X stands at {position:.2f}"[:15] in out
    assert rig.simulated.drives[1].state is DriveState.SWITCH_ON_DISABLED


@pytest.mark.parametrize("end", ["terminal lost", "Ctrl-C"])
def test_what_ends_a_jog(
    rig: Rig, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, end: str
) -> None:
    begin: list[float] = []

    def pressed() -> bytes | None:
        begin.append(rig.time)
        if rig.time - begin[0] < 0.1:
            return b"+"
        if end == "Ctrl-C":
            os.kill(os.getpid(), signal.SIGINT)
            return b"+"
        return None

    monkeypatch.setattr(Hand, "pressed", staticmethod(pressed), raising=False)
    assert told(capsys, "jog", "X")[0] == 0
    assert rig.simulated.drives[1].servo.velocity == 0.0
    assert rig.simulated.drives[1].state is DriveState.SWITCH_ON_DISABLED
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_tune_draws(
    rig: Rig, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    end = rig.time + 1.5
    monkeypatch.setattr(Hand, "pressed", staticmethod(lambda: b" " if rig.time < end else b"q"), raising=False)
    picture = tmp_path / "drive.png"
    code, out, _ = told(capsys, "tune", "X", "--by", "-2", "--velocity", "20", "--plot", str(picture))
    assert code == 0
    assert "X from -2 to 0 mm" in out
    assert "following error: at most 0.0" in out
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert -2.01 < rig.simulated.drives[1].servo.position / 10_000 < 0.01


@pytest.mark.parametrize("arguments", [("jog", "X", "--velocity", "9999"), ("tune", "S", "--by", "10")])
def test_too_much_is_refused(rig: Rig, capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...]) -> None:
    code, _, err = told(capsys, *arguments)
    assert (code, "303115" in err) == (1, True)


def test_keys_of_a_pipe() -> None:
    reading, writing = os.pipe()
    with Keys(reading) as keys:
        assert keys.read() == b""
        os.write(writing, b"\x1b[C\x1b[D\x1bOCx")
        assert keys.read() == b"+-+x"
        os.close(writing)
        assert keys.read() is None
        assert keys.ended
    os.close(reading)


def test_keys_of_a_terminal_that_is_lost() -> None:
    master, slave = pty.openpty()
    before = termios.tcgetattr(slave)
    with Keys(slave) as keys:
        os.write(master, b"+")
        assert select.select([slave], [], [], 5.0)[0]  # without Enter
        assert keys.read() == b"+"
        os.close(master)
        assert keys.read() is None
    os.close(slave)
    assert before[3] & 2  # ICANON: it was a terminal with lines


def test_the_hand_that_holds_keys() -> None:
    reading, writing = os.pipe()
    with Keys(reading) as keys:
        hand = command.KeyHand(keys, DeadMan(0.5))
        assert hand.order(0.0, 0.0) == 0
        os.write(writing, b"+")
        assert [hand.order(t, 0.0) for t in (1.0, 1.4, 1.6)] == [1, 1, 0]
        os.write(writing, b"--")
        assert hand.order(2.0, 0.0) == -1
        os.write(writing, b" ")
        assert hand.order(2.1, 0.0) == 0
        os.write(writing, b"q")
        assert hand.order(2.2, 0.0) is None
    os.close(reading)
    os.close(writing)


def test_a_stopped_terminal_holds_nobody_up() -> None:
    master, slave = pty.openpty()
    line = StatusLine(slave)
    line.tell("X 1.0")
    assert b"X 1.0" in os.read(master, 100)
    for _ in range(10_000):  # nobody reads
        line.tell("X" * 80)
    os.close(master)
    line.tell("gone")
    os.close(slave)
