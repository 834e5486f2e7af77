"""What a PLC program imports: the base class, the handlers of technology functions, the blocks of IEC 61131-3.

More blocks: `control_blocks` (blink, ramp, PID, ...); functions: `iec_functions`, `conversions`.
"""

from runtime.hli.layout import AxisState, Mode, SpindleCommandKind, SpindleWay, State, StopCondition
from runtime.hli.tools import Identity, ManagedTool, RequestKind, ToolLife, ToolOrder
from runtime.plc_logic.areas import NcMessage
from runtime.plc_logic.cycle_time import cycle_at
from runtime.plc_logic.errors import PlcError, PlcFailure
from runtime.plc_logic.function_blocks import CTD, CTU, CTUD, F_TRIG, R_TRIG, RS, SR, TOF, TON, TP
from runtime.plc_logic.handlers import NcFunction, h_function, m_function, s_function, t_function
from runtime.plc_logic.iec_time import TIME
from runtime.plc_logic.image import AnalogueInput, AnalogueOutput, Input, Io, Output
from runtime.plc_logic.program import Program
from runtime.plc_logic.retained_variables import retain
from runtime.plc_logic.tasks import task

__all__ = [
    "CTD",
    "CTU",
    "CTUD",
    "F_TRIG",
    "RS",
    "R_TRIG",
    "SR",
    "TIME",
    "TOF",
    "TON",
    "TP",
    "AnalogueInput",
    "AnalogueOutput",
    "AxisState",
    "Identity",
    "Input",
    "Io",
    "ManagedTool",
    "Mode",
    "NcFunction",
    "NcMessage",
    "Output",
    "PlcError",
    "PlcFailure",
    "Program",
    "RequestKind",
    "SpindleCommandKind",
    "SpindleWay",
    "State",
    "StopCondition",
    "ToolLife",
    "ToolOrder",
    "cycle_at",
    "h_function",
    "m_function",
    "retain",
    "s_function",
    "t_function",
    "task",
]
