"""Looking at a bus without a machine: scan, comparison with EDS files, the beginning of a machine description."""

from __future__ import annotations

from pathlib import Path

import can
import pytest

from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.fieldbus.commissioning import Commissioning
from runtime.fieldbus.described import DRIVE_EDS, eds_path
from runtime.fieldbus.dictionaries import read_dictionary
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.simulator import Fault
from tests.fieldbus.rig import Rig


def look(rig: Rig) -> Commissioning:
    rig.idle()
    return Commissioning(rig.bus, lambda: rig.time, rig.idle)


def test_every_node_tells_what_it_is() -> None:
    with Rig() as rig:
        rig.simulated.inject(3, Fault.SILENT)
        found = look(rig).scan()
        assert [(node.node, node.profile) for node in found] == [
            (1, "drive (CiA 402)"),
            (2, "drive (CiA 402)"),
            (6, "drive (CiA 402)"),
            (10, "I/O (CiA 401)"),
        ]
        assert [(node.vendor, node.product, node.serial) for node in found][:2] == [
            (0x7A4D, 0x402, 1),
            (0x7A4D, 0x402, 2),
        ]
        assert "imulated" in found[0].name
        assert found[0].firmware


def test_a_running_master_is_left_alone() -> None:
    with Rig() as rig, can.Bus(interface="virtual", channel=rig.machine.fieldbus.bus.channel) as visitor:
        rig.enabled()
        with pytest.raises(FieldbusError) as refusal:
            Commissioning(visitor, lambda: rig.time, rig.cycle).scan()
        assert refusal.value.problem.entry is catalogue.OTHER_MASTER
        assert rig.event_ids() == []


def test_a_node_is_what_its_eds_describes() -> None:
    with Rig() as rig:
        assert list(look(rig).compare(1, read_dictionary(eds_path(None, DRIVE_EDS), 1))) == []


def test_differences_are_named(tmp_path: Path) -> None:
    text = Path(eds_path(None, DRIVE_EDS)).read_text(encoding="utf-8")
    text = text.replace("[6085]", "[6086]").replace("=0x6085\n", "=0x6086\n")
    file = tmp_path / "other.eds"
    file.write_text(text)
    with Rig() as rig:
        rig.simulated.inject(1, Fault.WRONG_VENDOR)
        found = {
            difference.object: (difference.expected, difference.found)
            for difference in look(rig).compare(1, read_dictionary(str(file), 1))
        }
    assert found == {"0x1018:1": ("0x7A4D", "0x1234"), "0x6086": ("there", "not there")}


def test_a_node_that_is_not_there() -> None:
    with Rig() as rig, pytest.raises(FieldbusError) as refusal:
        list(look(rig).compare(77, read_dictionary(eds_path(None, DRIVE_EDS), 77)))
    assert "node 77" in refusal.value.problem.text
