"""Technology functions (M, H, S, T) in the cycle: put out at their place or ahead of it, and what the path waits for."""

from runtime.cnc.technology.functions import TechnologyFunctions, TechnologySettings
from runtime.cnc.technology.travel import Travel, synch_in

__all__ = ["TechnologyFunctions", "TechnologySettings", "Travel", "synch_in"]
