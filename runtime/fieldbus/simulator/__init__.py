"""Simulated CANopen nodes: real protocol, real object dictionaries, simulated motors and plant."""

from runtime.fieldbus.simulator.drive import Fault, SimulatedDrive
from runtime.fieldbus.simulator.encoder import EncoderFile
from runtime.fieldbus.simulator.io import SimulatedIo
from runtime.fieldbus.simulator.nodes import SimulatedNodes
from runtime.fieldbus.simulator.plant import DEMO_PLANT, SimulatedPlant

__all__ = ["DEMO_PLANT", "EncoderFile", "Fault", "SimulatedDrive", "SimulatedIo", "SimulatedNodes", "SimulatedPlant"]
