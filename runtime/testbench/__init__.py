"""A test bench for machine builders: their PLC program on a whole machine in virtual time, as pytest fixtures."""

from runtime.fieldbus.simulator.plant import Always, Follow, Interrupt, Rule
from runtime.testbench.bench import MachineBench, ProgramResult

__all__ = ["Always", "Follow", "Interrupt", "MachineBench", "ProgramResult", "Rule"]
