"""G74 with drives that home by themselves (mode 6): reference, hold, abort, faults, and that nothing jumps."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from runtime.config.drive import Gantry
from runtime.config.machine import HomingSetup, Machine, SimulatedServo
from runtime.diagnostics.catalogue import machine as alarms
from runtime.drives import DriveState
from runtime.fieldbus.simulator import Fault
from runtime.hli.layout import Mode, State
from tests.machine.driven import Driven
from tests.machine.scripted_plc import ScriptedPlc

X, NODE = 0, 1
ENABLED = DriveState.OPERATION_ENABLED


@pytest.fixture
def make(demo: Machine, tmp_path: Path) -> Callable[..., Driven]:
    """The demo machine with simulated drives; X homes by its drive, with these settings."""

    def build(cam: float = -5.0, **settings: object) -> Driven:
        setup = HomingSetup(fast=100.0, slow=10.0, position=3.0, method=21)
        axis = demo.axes[X]
        assert axis.drive is not None
        drive = axis.drive.model_copy(
            update={"simulated": SimulatedServo(home_switch=(-60.0, cam), limits=(-70.0, 700.0))}
        )
        axis = axis.model_copy(update={"homing": setup.model_copy(update=settings), "drive": drive})
        machine = demo.model_copy(update={"axes": (axis, *demo.axes[1:])})
        return Driven(machine, tmp_path, partner=lambda memory: ScriptedPlc(memory, {}))

    return build


def home(driven: Driven, blocks: str = "G74 X1") -> None:
    driven.simulation.order(Mode.HOMING, State.ACTIVE, blocks)
    driven.watch(3)


def servo(driven: Driven) -> float:
    nodes = driven.simulation.nodes
    assert nodes is not None
    return nodes.drives[NODE].servo.position / 10_000


@pytest.mark.spec("isg.g.homing-g74", "hli.mode.homing")
def test_the_drive_finds_the_reference_and_the_axis_goes_to_it(make: Callable[..., Driven]) -> None:
    driven = make()
    status = driven.hli.axes[X].status
    assert not status.referenced_r
    home(driven, "G74 X1\nG90 G01 F6000 X20")
    way: list[float] = []
    for _ in range(20_000):
        if not driven.channel.active:
            break
        driven.watch(1)
        way.append(servo(driven))
    assert driven.errors == []
    assert status.referenced_r
    assert driven.image.target_position[X] == pytest.approx(20.0)
    # the cam was left at -5 of the encoder: that is 3 of the axis
    assert servo(driven) == pytest.approx(20.0 - 3.0 - 5.0, abs=0.05)
    assert min(way) < -5.0
    speed = np.abs(np.diff(way)) / 0.001
    assert speed.max() <= 101.0 * 1.05  # the search, and no jump at its end
    driven.start("%P\nN10 G90 G01 F6000 X5\nN20 M30\n")
    driven.until(lambda: not driven.channel.active)
    assert driven.image.target_position[X] == 5.0
    assert driven.errors == []


def test_feed_hold_halts_the_drive_and_an_abort_stops_it(make: Callable[..., Driven]) -> None:
    driven = make(cam=-30.0)
    home(driven)
    driven.watch(100)
    driven.operator.feedhold_w = True
    driven.watch(200)
    stands = servo(driven)
    driven.watch(100)
    assert servo(driven) == pytest.approx(stands, abs=1e-3)
    assert driven.channel.active
    driven.operator.feedhold_w = False
    driven.watch(50)
    assert servo(driven) < stands - 0.1
    driven.simulation.order(Mode.HOMING, State.SELECTED)
    driven.until(lambda: not driven.channel.active, 2.0)
    driven.watch(10)
    stands = servo(driven)
    driven.watch(100)
    assert servo(driven) == pytest.approx(stands, abs=1e-3)
    assert driven.image.state[X] == ENABLED
    assert not driven.image.by_drive[X]
    assert driven.image.target_position[X] == pytest.approx(driven.image.actual_position[X], abs=1e-3)
    assert not driven.hli.axes[X].status.referenced_r
    home(driven)
    driven.until(lambda: not driven.channel.active)
    assert driven.hli.axes[X].status.referenced_r
    assert driven.errors == []


@pytest.mark.parametrize(
    ("settings", "entry"),
    [({"method": -7}, alarms.HOMING_BY_DRIVE), ({"timeout": 0.2}, alarms.HOMING_LATE)],
)
def test_a_homing_that_fails_stops_the_axis_and_says_why(
    make: Callable[..., Driven], settings: dict[str, object], entry: object
) -> None:
    driven = make(**settings)
    home(driven)
    driven.until(lambda: not driven.channel.active or driven.channel.error is not None, 5.0)
    driven.watch(300)
    assert driven.alarm(entry)  # type: ignore[arg-type]
    stands = servo(driven)
    driven.watch(50)
    assert servo(driven) == pytest.approx(stands, abs=1e-3)
    assert not driven.hli.axes[X].status.referenced_r


def test_a_drive_fault_while_it_homes(make: Callable[..., Driven]) -> None:
    driven = make()
    home(driven)
    driven.watch(150)
    nodes = driven.simulation.nodes
    assert nodes is not None
    nodes.inject(NODE, Fault.DRIVE, 0x2310)
    driven.watch(500)
    assert driven.channel.error is not None
    assert driven.image.state[X] == DriveState.FAULT
    driven.reset()
    driven.watch(700)
    assert driven.image.state[X] == ENABLED
    stands = servo(driven)
    driven.watch(100)
    assert servo(driven) == pytest.approx(stands, abs=1e-3)
    home(driven)
    driven.until(lambda: not driven.channel.active)
    assert driven.hli.axes[X].status.referenced_r


def test_ideal_axes_have_their_reference_where_they_stand(demo: Machine, tmp_path: Path) -> None:
    setup = HomingSetup(fast=100.0, slow=10.0, position=3.0, method=21)
    axes = (demo.axes[X].model_copy(update={"homing": setup}), *demo.axes[1:])
    driven = Driven(
        demo.model_copy(update={"axes": axes}),
        tmp_path,
        ideal_axes=True,
        partner=lambda memory: ScriptedPlc(memory, {}),
    )
    home(driven)
    driven.until(lambda: not driven.channel.active)
    assert driven.hli.axes[X].status.referenced_r
    assert driven.image.target_position[X] == pytest.approx(3.0)


def test_a_gantry_is_homed_by_both_drives_and_squared(demo: Machine, tmp_path: Path) -> None:
    """The references stand 0.3 mm apart, as the drives count them at the start; square is where both count 0."""
    axis = demo.axes[X]
    assert axis.drive is not None
    gantry = Gantry(node=20, difference=0.5, simulated=SimulatedServo(home_switch=(-60.0, -4.7)))
    drive = axis.drive.model_copy(update={"simulated": SimulatedServo(home_switch=(-60.0, -5.0)), "gantry": gantry})
    setup = HomingSetup(fast=100.0, slow=10.0, position=3.0, method=21)
    axis = axis.model_copy(update={"homing": setup, "drive": drive})
    machine = demo.model_copy(update={"axes": (axis, *demo.axes[1:])})
    driven = Driven(machine, tmp_path, partner=lambda memory: ScriptedPlc(memory, {}))
    home(driven, "G74 X1\nG90 G01 F6000 X20\nG04 3")
    driven.until(lambda: not driven.channel.active, 20.0)
    assert driven.errors == []
    assert driven.hli.axes[X].status.referenced_r
    nodes = driven.simulation.nodes
    assert nodes is not None
    first, second = (nodes.drives[node].servo.position / 10_000 for node in (NODE, 20))
    assert first == pytest.approx(20.0 - 3.0 - 5.0, abs=0.05)  # a cycle of the slow speed
    assert second - first == pytest.approx(0.3, abs=0.002)
