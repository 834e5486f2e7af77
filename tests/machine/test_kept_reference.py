"""An absolute encoder: a reference that was found once is kept over the power-off, and trusted only where it can be."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
import yaml
from pydantic import ValidationError

from runtime.config import load_machine
from runtime.config.loader import DEMO_MACHINE
from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import machine as alarms
from runtime.drives import DriveState
from runtime.fieldbus.simulator import Fault
from runtime.hli.layout import Hli, ReferenceState
from runtime.plc_logic.motion import MC_Home, MC_MoveAbsolute
from runtime.scheduler.keeping import Keeper, retained_of
from runtime.scheduler.retained import Retained, RetainedStore
from tests.machine.beside_channel import TABLE, Rig
from tests.machine.test_mc_home import referenced, servo

HOMING = "    homing: {fast: 60, slow: 6, position: 10, direction: negative, absolute: {%s}}\n    drive: {"
ABSOLUTE = TABLE.replace("    drive: {", HOMING % "range: 2000, moved: 0.5")


def again(folder: Path, kept: Mapping[str, Mapping[str, Any]], table: str = ABSOLUTE) -> Rig:
    """The machine is switched on with this kept."""
    return Rig(folder, ideal=False, table=table, prepare=lambda s: s.controller.references.restore(kept))


def ids(rig: Rig) -> list[int]:
    return [problem.entry.id for problem in rig.simulation.errors]


@pytest.fixture(scope="module")
def homed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Retained, float]:
    """What is kept of a table that was homed, and where it stood: there the encoder counts 0, as a simulated one at its start."""
    folder = tmp_path_factory.mktemp("homed")
    rig = Rig(folder, ideal=False, table=ABSOLUTE)
    assert not referenced(rig)
    assert retained_of(rig.machine, rig.hli).references == {}
    rig.call("cam", lambda p: setattr(p.axes["B"], "reference_cam", servo(rig) < -20.0))
    rig.run(0.05)
    home, move = MC_Home(), MC_MoveAbsolute()
    rig.call("home", lambda p: home(p.axes["B"], True))
    rig.until(lambda: home.Done)
    assert referenced(rig)
    rig.call("move", lambda p: move(p.axes["B"], True, Position=float(rig.image.origin[rig.table]), Velocity=90.0))
    rig.until(lambda: move.Done)
    rig.run(0.2)
    assert servo(rig) == pytest.approx(0.0, abs=0.01)
    store = RetainedStore(folder / "state")
    store.save(retained_of(rig.machine, rig.hli))
    kept, problems = store.load()  # from the disk, as after a power loss
    assert problems == []
    return kept, rig.place("B")


def test_the_reference_is_there_again(tmp_path: Path, homed: tuple[Retained, float]) -> None:
    kept, place = homed
    assert kept.references["B"]["identity"][:2] == [0x7A4D, 0x402]
    assert place > 20.0
    rig = again(tmp_path, kept.references)
    assert referenced(rig)
    assert rig.place("B") == pytest.approx(place, abs=0.01)
    assert ids(rig) == []
    assert retained_of(rig.machine, rig.hli).references["B"]["origin"] == kept.references["B"]["origin"]
    move = MC_MoveAbsolute()
    rig.call("move", lambda p: move(p.axes["B"], True, Position=place + 10.0, Velocity=90.0))
    rig.until(lambda: move.Done)
    assert servo(rig) == pytest.approx(10.0, abs=0.05)


def test_a_reference_that_is_found_or_lost_does_not_wait_for_the_next_second(tmp_path: Path) -> None:
    rig = Rig(tmp_path, ideal=False, table=ABSOLUTE)
    store = RetainedStore(tmp_path / "state")
    keeper = Keeper(rig.machine, store)
    keeper.keep(rig.hli)
    assert not keeper.urgent(rig.hli)
    rig.call("cam", lambda p: setattr(p.axes["B"], "reference_cam", servo(rig) < -20.0))
    rig.run(0.05)
    home = MC_Home()
    rig.call("home", lambda p: home(p.axes["B"], True))
    rig.until(lambda: keeper.urgent(rig.hli))
    found = rig.simulation.time
    rig.until(lambda: referenced(rig))
    assert rig.simulation.time - found < 0.01
    keeper.keep(rig.hli)
    assert "B" in store.load()[0].references
    rig.until(lambda: home.Done)
    rig.run(0.5)
    assert not keeper.urgent(rig.hli)  # where the axis stands may wait
    again = MC_Home()
    rig.call("home", lambda p: again(p.axes["B"], True))
    rig.until(lambda: keeper.urgent(rig.hli), 1.0)  # and a reference that counts no longer may not
    keeper.keep(rig.hli)
    assert store.load()[0].references == {}


def test_a_disk_that_is_full_is_not_tried_without_a_pause(homed: tuple[Retained, float], tmp_path: Path) -> None:
    hli = Hli()
    machine = described(ABSOLUTE)
    keeper = Keeper(machine, RetainedStore(tmp_path / "a file"))
    (tmp_path / "a file").write_text("no folder")
    hli.axes[machine.axis_index("B")].reference.state_r = ReferenceState.KEPT
    assert keeper.urgent(hli)
    keeper.keep(hli)
    assert hli.platform.not_retained_w
    assert not keeper.urgent(hli)  # it is tried again with the others, each second


def changed(kept: Retained, **values: Any) -> dict[str, dict[str, Any]]:
    return {"B": {**kept.references["B"], **values}}


@pytest.mark.parametrize("turns", [-1, 1, 3])
def test_an_encoder_that_counts_anew_meanwhile(tmp_path: Path, homed: tuple[Retained, float], turns: int) -> None:
    """Kept so many ranges away, with its origin: the same place."""
    kept, place = homed
    origin = kept.references["B"]["origin"] - turns * 2000.0
    rig = again(tmp_path, changed(kept, origin=origin))
    assert referenced(rig)
    assert rig.place("B") == pytest.approx(place, abs=0.01)


@pytest.mark.parametrize(("way", "trusted"), [(0.4, True), (-0.4, True), (0.7, False), (-300.0, False), (999.0, False)])
def test_an_axis_that_was_moved(tmp_path: Path, homed: tuple[Retained, float], way: float, trusted: bool) -> None:
    kept, place = homed
    rig = again(tmp_path, changed(kept, place=place + way))
    assert referenced(rig) is trusted
    assert ids(rig) == ([] if trusted else [alarms.REFERENCE_MOVED.id])
    assert ("B" in retained_of(rig.machine, rig.hli).references) is trusted  # forgotten at once


def test_another_drive_is_not_trusted(tmp_path: Path, homed: tuple[Retained, float]) -> None:
    vendor, product, serial = homed[0].references["B"]["identity"]
    rig = again(tmp_path, changed(homed[0], identity=[vendor, product, serial + 1]))
    assert not referenced(rig)
    assert ids(rig) == [alarms.REFERENCE_OTHER_DRIVE.id]
    assert retained_of(rig.machine, rig.hli).references == {}


def test_other_units_of_the_description_are_another_axis(tmp_path: Path, homed: tuple[Retained, float]) -> None:
    rig = again(tmp_path, changed(homed[0], increments_per_unit=500.0))
    assert not referenced(rig)


def test_a_drive_that_comes_back_has_its_reference_or_not(tmp_path: Path, homed: tuple[Retained, float]) -> None:
    kept, place = homed
    rig = again(tmp_path, kept.references)
    nodes = rig.simulation.nodes
    for way in (0.3, 5.0):
        nodes.inject(9, Fault.SILENT)
        rig.until(lambda: rig.image.state[rig.table] == DriveState.OFFLINE, 2.0)
        assert retained_of(rig.machine, rig.hli).references["B"]["place"] == pytest.approx(
            place, abs=0.5
        )  # while it is away
        nodes.drives[9].servo.position += way * 1000.0
        nodes.heal(9)
        rig.until(lambda: rig.image.state[rig.table] != DriveState.OFFLINE, 12.0)
        rig.run(0.05)
        assert referenced(rig) is (way < 0.5)
    assert alarms.REFERENCE_MOVED.id in ids(rig)


def test_nothing_is_lost_before_the_machine_has_said_anything(homed: tuple[Retained, float]) -> None:
    """The service writes every second, also while the cycle process still starts."""
    hli = Hli()
    assert retained_of(load_machine(DEMO_MACHINE), hli, homed[0]).references == {}  # this machine has no such axis
    machine = described(ABSOLUTE)
    assert retained_of(machine, hli, homed[0]).references == homed[0].references
    hli.axes[machine.axis_index("B")].reference.state_r = ReferenceState.NONE
    assert retained_of(machine, hli, homed[0]).references == {}


def described(table: str) -> Machine:
    description = yaml.safe_load(DEMO_MACHINE.read_text(encoding="utf-8"))
    description["axes"].append(yaml.safe_load(table)[0])
    return Machine.model_validate(description)


@pytest.mark.parametrize(
    ("setup", "drive", "says"),
    [
        ("range: 2000, moved: 1000", "node: 9", "not below half of the range"),
        ("range: 2000", "node: 9, gantry: {node: 10, difference: 1}", "has two drives"),
    ],
)
def test_what_cannot_be_kept_is_refused(setup: str, drive: str, says: str) -> None:
    with pytest.raises(ValidationError, match=says):
        described(TABLE.replace("    drive: {", HOMING % setup).replace("node: 9", drive))
