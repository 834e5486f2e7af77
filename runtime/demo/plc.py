"""The PLC program of the demo mill: clamp, coolant, tool changer, spindle, lamps, door and emergency stop.

Start your own machine from here: a method per technology function says what the machine does and when it is finished;
`cycle` has the interlocks. An acknowledgement that does not come raises an alarm, and the path waits.
"""

from __future__ import annotations

from collections.abc import Iterator

from runtime.plc_logic import TON, NcFunction, Program, State, h_function, m_function, s_function, t_function

MAGAZINE_PLACES = 8
JOG_BUTTONS = [(f"jog_{axis}_plus", f"jog_{axis}_minus") for axis in "xyz"]  # the key pairs 1 to 3

# Longest times of the machine's movements, s
CLAMP_TIME = 2.0
COOLANT_TIME = 1.5
TOOL_TIME = 2.0
SPINDLE_TIME = 6.0


class DemoMill(Program):
    """A three-axis mill with a hydraulic clamp and a disc magazine."""

    def setup(self) -> None:
        self.spindle = self.spindles["S"]
        self.unsafe = TON(PT=0.1)  # contacts bounce
        self.tool = 0  # in the spindle
        self.next_tool = 0
        self.holes = 0

    # ------------------------------------------------------------------ clamp

    @m_function(20)
    def close_clamp(self, f: NcFunction) -> bool:
        self.io.clamp_valve = True
        if f.elapsed > CLAMP_TIME:
            self.alarm("clamp does not close: check pressure and the switch clamp_closed")
        return self.io.clamp_closed

    @m_function(21)
    def open_clamp(self, f: NcFunction) -> bool:
        self.io.clamp_valve = False
        if f.elapsed > CLAMP_TIME:
            self.alarm("clamp does not open: check the valve and the switch clamp_open")
        return self.io.clamp_open

    # ------------------------------------------------------------------ coolant

    @m_function(8)
    def coolant_on(self, f: NcFunction) -> bool:
        self.io.coolant_pump = True
        if f.elapsed > COOLANT_TIME:
            self.alarm("no coolant pressure: check the tank and the filter")
        return self.io.coolant_pressure

    @m_function(9)
    def coolant_off(self, f: NcFunction) -> bool:
        self.io.coolant_pump = False
        return True

    # ------------------------------------------------------------------ spindle and tools

    @s_function(3, 4)
    def spindle_on(self, f: NcFunction) -> bool:
        if f.elapsed > SPINDLE_TIME:
            self.alarm(f"spindle does not reach {f.speed:.0f} rev/min")
        return f.elapsed > 0.02 and self.spindle.at_speed  # before, it may still mean the speed before

    @s_function()
    def spindle_told(self, f: NcFunction) -> bool:
        return True  # a new speed, M5, M19: the CNC does it, nothing is switched here

    @t_function()
    def select_tool(self, f: NcFunction) -> bool:
        self.next_tool = f.tool
        return True

    @m_function(6)
    def change_tool(self, f: NcFunction) -> Iterator[None]:
        """A sequence of steps: `yield` ends the cycle, the end of the method acknowledges."""
        self.spindle.override = 0.0  # the program need not say M5 first
        yield from self.until(lambda: self.spindle.standing, SPINDLE_TIME, "tool change: the spindle turns")
        self.io.tool_unlock = True
        yield from self.until(lambda: self.io.tool_unlocked, TOOL_TIME, "tool does not unlock")
        for _ in range((self.next_tool - self.tool) % MAGAZINE_PLACES):
            self.io.magazine_step = True
            yield from self.wait(0.1)
            self.io.magazine_step = False
            yield from self.wait(0.1)
        self.io.tool_unlock = False
        yield from self.until(lambda: self.io.tool_in_spindle, TOOL_TIME, "tool is not clamped in the spindle")
        self.tool = self.next_tool
        self.spindle.override = 100.0

    @h_function(12)
    def count_hole(self, f: NcFunction) -> bool:
        self.holes += 1
        return True

    # ------------------------------------------------------------------ interlocks and lamps

    def cycle(self) -> None:
        safe = self.io.door_closed and self.io.e_stop_ok
        self.channel.feed_hold = not safe or self.channel.operator.feed_hold
        if self.unsafe(IN=not safe).Q:
            self.alarm("door is open" if self.io.e_stop_ok else "emergency stop")
        for key, (plus, minus) in enumerate(JOG_BUTTONS, 1):
            self.channel.keys.press(key, getattr(self.io, plus) - getattr(self.io, minus))
        self.io.lamp_green = safe and self.channel.state is State.ACTIVE
        self.io.lamp_red = bool(self.alarms) or self.channel.error != 0

    def on_reset(self) -> None:
        self.io.coolant_pump = False
        self.io.tool_unlock = False
        self.io.magazine_step = False
        self.spindle.override = 100.0
