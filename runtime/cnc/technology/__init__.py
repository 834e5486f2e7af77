"""Technology functions (M, H, S, T) in the cycle: put out at their place on the path, and what the path waits for."""

from runtime.cnc.technology.functions import TechnologyFunctions

__all__ = ["TechnologyFunctions"]
