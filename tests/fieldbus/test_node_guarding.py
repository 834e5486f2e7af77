"""Old nodes have no heartbeat: the master asks for their state, and they miss its questions."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import can
import pytest

from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.drives import DriveState
from runtime.fieldbus.described import DRIVE_EDS, eds_path
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.simulator import Fault
from runtime.fieldbus.simulator.node import MASTER_GUARDS
from tests.fieldbus.rig import Rig, demo_description
from tests.fieldbus.test_operation import ENABLED, X, Y, ids
from tests.fieldbus.test_rejoin import back


def old_eds(folder: Path, *, guarding: bool = True) -> Path:
    """The drive's EDS without heartbeat."""
    text = Path(eds_path(None, DRIVE_EDS)).read_text(encoding="utf-8")
    text = re.sub(rf"\[(101[67]|{'none' if guarding else '100C'})(sub\d)?\][^[]*", "", text)
    text = re.sub(r"^\d+=0x(101[67]|100C)\n", "", text, flags=re.MULTILINE) if not guarding else text
    file = folder / "old.eds"
    file.write_text(text)
    return file


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[Rig]:
    description = demo_description()
    description["axes"][0]["drive"]["eds"] = str(old_eds(tmp_path))
    with Rig(description) as rig:
        yield rig.enabled()


def test_a_guarded_drive_stays_in_operation(rig: Rig) -> None:
    rig.cycle(2000)
    assert rig.event_ids() == []
    assert rig.image.state[X] == ENABLED
    assert rig.image.frames_sent > 2000


def test_a_guarded_drive_that_falls_silent_is_lost_and_comes_back(rig: Rig) -> None:
    rig.simulated.inject(1, Fault.SILENT)
    assert rig.run_until(lambda: rig.image.state[X] == DriveState.OFFLINE)
    assert rig.image.state[Y] == ENABLED
    rig.cycle(600)
    assert rig.simulated.drives[1].state is DriveState.FAULT  # nobody asked it any more
    rig.simulated.heal(1)
    assert rig.run_until(lambda: back(rig, 1), 5.0)


def test_an_answer_that_does_not_toggle_is_no_sign_of_life(rig: Rig) -> None:
    drive = rig.simulated.drives[1]
    rig.cycle(300)

    def stuck(now: float) -> None:
        drive.on_heartbeat(MASTER_GUARDS, now)  # it hears the questions
        rig.simulated._network.send_message(0x701, b"\x05")

    drive.on_guard = stuck  # type: ignore[method-assign]
    assert rig.run_until(lambda: rig.image.state[X] == DriveState.OFFLINE)
    assert rig.event_ids()[0] == catalogue.HEARTBEAT_LOST.id


def test_the_question_is_a_remote_frame(rig: Rig) -> None:
    with can.Bus(interface="virtual", channel=rig.machine.fieldbus.bus.channel) as listener:
        rig.cycle(1000)
        asked = 0
        while (message := listener.recv(0)) is not None:
            asked += message.is_remote_frame and message.arbitration_id == 0x701
    assert asked == pytest.approx(10, abs=1)  # heartbeat: 100 ms


def test_a_node_that_cannot_be_watched_is_refused(tmp_path: Path) -> None:
    description = demo_description()
    description["axes"][0]["drive"]["eds"] = str(old_eds(tmp_path, guarding=False))
    with Rig(description) as rig, pytest.raises(FieldbusError) as refusal:
        rig.master.start()
    assert ids(refusal.value.problem.entry) == ids(catalogue.EDS_OBJECT_MISSING)
    assert "no object 0x100C, which is needed for watching the node" in refusal.value.problem.text
