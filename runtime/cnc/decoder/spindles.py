"""Spindles in a program: what is modal for each of them, which one is the main spindle, and what a block orders.

    S1000 M3            the main spindle, by its name           ┐
    S2[M4 REV500]       any spindle, by its own name            ├─▶ SpindleWords ─▶ one S function, or none
    M19 S.POS=45        the main spindle stands at an angle     ┘

Of the words of a spindle in one block only one synchronisation counts: M19 before M3, M4, M5 before the speed (line 22296).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from runtime.cnc.blocks import SpindleSetting, SpindleValue, Synch, Technology, TechnologyFunction
from runtime.cnc.decoder.setup import GearRange, SpindleSetup
from runtime.cnc.language.isg.comments import LineError
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.catalogue import spindle
from runtime.diagnostics.catalogue import technology as errors

if TYPE_CHECKING:
    from runtime.cnc.decoder.block_functions import Functions
    from runtime.cnc.decoder.execution import Execution

VALUE_LIMIT = 2**31 - 1
ANGLE_LIMIT = 1e6  # degrees
TURNING = (3, 4)
STOPPED, POSITIONED = 5, 19
FIRST_GEAR = 40  # M40 is the first stage


@dataclass(slots=True)
class ProgrammedSpindle:
    """What is modal for a spindle: the last of M3, M4, M5; speed in rev/min; angle of M19 in degrees."""

    command: int = STOPPED
    speed: float = 0.0
    angle: float = 0.0
    positioned: bool = False  # M19 was the last that moved it
    feeds_forward: bool = True  # G135, G137
    feed_forward: float = 1.0  # G136


@dataclass(slots=True)
class SpindleWords:
    """What a block says to one spindle; `column` for errors, `word` is how the speed is written."""

    column: int
    command: int = -1  # 3, 4 or 5
    position: bool = False  # M19
    speed: float | None = None
    angle: float | None = None
    override_off: bool = False  # G167
    word: str = "S"

    @property
    def any(self) -> bool:
        """The block says anything."""
        return (
            self.command >= 0 or self.position or self.override_off or self.speed is not None or self.angle is not None
        )


class Spindles:
    """The spindles of one program run. Every program begins with the configured main spindle."""

    def __init__(self, setups: tuple[SpindleSetup, ...], main: int, main_name: str, start_m: int = STOPPED) -> None:
        self._setups = setups
        self._configured = main
        self._main_name = main_name
        self.main = main
        self.programmed = [ProgrammedSpindle() for _ in setups]
        if start_m in TURNING and setups:  # as behind an M19: it turns with the next speed
            self.main_programmed.command, self.main_programmed.positioned = start_m, True

    @property
    def main_programmed(self) -> ProgrammedSpindle:
        """Of the main spindle."""
        return self.programmed[self.main]

    def choose_main(self, x: Execution, index: int | None) -> None:
        """#MAIN SPINDLE: another spindle, or the configured one again; each keeps its own speed."""
        x.turning.end(x)
        self.main = self._configured if index is None else index
        x.modal.speed = self.main_programmed.speed

    def index_of(self, name: str, column: int) -> int:
        """The spindle of a name; raises LineError. While a spindle is the main one it has two names."""
        wanted = name.upper()
        if wanted == self._main_name.upper():
            return self.main
        for index, setup in enumerate(self._setups):
            if setup.name.upper() == wanted:
                return index
        if wanted == "S":
            return self.main
        known = ", ".join(setup.name for setup in self._setups)
        raise LineError(catalogue.SPINDLE_UNKNOWN, column, spindle=name, spindles=known)

    def expect_main(self, name: str, column: int) -> None:
        """LineError if a name outside of brackets is not that of the main spindle ("" and "S" are always)."""
        if len(name) > 1 and name[0] != "@" and self.index_of(name, column) != self.main:
            raise LineError(errors.NOT_MAIN_SPINDLE, column, name=name, main=self._setups[self.main].name)

    # ------------------------------------------------------------------ orders

    def order(self, x: Execution, functions: Functions, index: int, words: SpindleWords) -> None:
        """Enter what is modal and put out at most one function. Raises LineError."""
        setup, state = self._setups[index], self.programmed[index]
        if words.speed is not None:
            if not 0 <= words.speed <= VALUE_LIMIT:
                raise LineError(catalogue.SPEED_NEGATIVE, words.column, value=words.speed)
            state.speed = words.speed
            if index == self.main:
                x.modal.speed = words.speed
        if words.angle is not None:
            if not abs(words.angle) <= ANGLE_LIMIT:
                raise LineError(catalogue.RESULT_RANGE, words.column, value=words.angle, name="POS")
            state.angle = words.angle
        number, sense = self._number(setup, state, words)
        if number < 0:
            return
        self._expect_free(x, index, f"M{number}" if number else words.word, words.column)
        synch, duration = setup.s, setup.s_duration
        if number > 0:
            synch, duration = setup.m.get(number, Synch.NO_SYNCH), setup.m_duration.get(number, 0.0)
        self._check_synch(synch, f"M{number}" if number else words.word, words.column)
        functions.add(
            TechnologyFunction(
                x.source,
                Technology.S,
                number,
                state.speed,
                synch,
                spindle=-1 if setup.plc else index,
                area=-1 if setup.plc else setup.area,
                duration=duration,
                angle=state.angle,
                sense=sense,
                override_off=words.override_off,
                plc_spindle=setup.log_axis if setup.plc else 0,
            )
        )

    def _number(self, setup: SpindleSetup, state: ProgrammedSpindle, words: SpindleWords) -> tuple[int, int]:
        """The function to be put out (0 for a new speed, -1 none) and its sense; the modal state follows."""
        if words.position:
            if words.command == STOPPED:
                raise LineError(catalogue.SPINDLE_M_TWICE, words.column, number=POSITIONED, other=STOPPED)
            if state.speed <= 0:
                raise LineError(errors.POSITIONING_SPEED, words.column, name=setup.name)
            if words.command in TURNING:
                state.command = words.command
            state.positioned = True
            return POSITIONED, words.command if words.command in TURNING else 0
        if words.command >= 0:
            state.command, state.positioned = words.command, False
            return words.command, 0
        if words.speed is None and not words.override_off:
            return -1, 0
        if state.positioned and state.command in TURNING:
            state.positioned = False
            return 0, state.command
        return 0, 0

    def _check_synch(self, synch: Synch, word: str, column: int) -> None:
        """With NO_SYNCH the kernel of the manual does not execute a function (line 22600). A spindle that goes on turning after
        an M5 is no way to run a machine, so here that is an error."""
        if synch == Synch.NOT_VALID:
            raise LineError(catalogue.SPINDLE_LOCKED, column, word=word)
        if synch.kind == Synch.NO_SYNCH:
            raise LineError(catalogue.SPINDLE_NO_SYNCH, column, word=word)

    def _expect_free(self, x: Execution, index: int, word: str, column: int) -> None:
        """LineError for an order to the spindle that follows the path."""
        if x.sections.tapping and index == x.sections.spindle:
            motion = f"G{int(x.modal.motion)}"
            raise LineError(spindle.TAPPING_SPINDLE, column, word=word, name=self._setups[index].name, motion=motion)

    def set(self, x: Execution, index: int, what: SpindleValue, value: float, column: int) -> None:
        """A setting of a spindle that the control moves itself, at its place on the path."""
        if self._setups[index].plc:
            raise LineError(errors.PLC_SPINDLE, column, name=self._setups[index].name)
        self._expect_free(x, index, what.name, column)
        x.emit(SpindleSetting(x.source, index, what, value))

    def home(self, x: Execution, index: int, column: int) -> None:
        """G74: the spindle stands afterwards."""
        self.programmed[index].command, self.programmed[index].positioned = STOPPED, False
        self.set(x, index, SpindleValue.HOMING, 0.0, column)

    # ------------------------------------------------------------------ gear

    def select_gear(self, x: Execution, wanted: int, words: SpindleWords) -> int:
        """The stage (0…5) that the main spindle has to change to before its words act, -1 for none. Raises LineError.

        `wanted`: of M40…M45, -1 without. With automatic choice the present stage stays as long as it covers the speed
        (line 22848); without it the programmed stage has to cover the speed.
        """
        setup = self._setups[self.main]
        present = x.memory.gears.get(self.main, -1)
        state = self.main_programmed
        speed = state.speed if words.speed is None else words.speed
        fits = [stage for stage, known in enumerate(setup.gears) if known.covers(speed)]
        asked = words.speed is not None or words.command in TURNING or words.position
        if wanted >= 0:
            known = setup.gears[wanted] if wanted < len(setup.gears) else GearRange()
            if not known.usable or (speed > 0 and not known.covers(speed)):
                raise LineError(errors.GEAR_UNSUITABLE, words.column, number=FIRST_GEAR + wanted, speed=speed)
            if setup.automatic_gear and present in fits:
                return -1
            return wanted if wanted != present else -1
        if not asked or speed <= 0 or present in fits:
            return -1
        if not setup.automatic_gear:
            shown = f"M{FIRST_GEAR + present}" if present >= 0 else "no stage"
            raise LineError(errors.GEAR_MISSING, words.column, speed=speed, present=shown)
        if not fits:
            raise LineError(errors.GEAR_NONE, words.column, speed=speed)
        return fits[-1] if setup.gears_from_top else fits[0]

    def change_gear(self, x: Execution, stage: int) -> None:
        """The stage is told: it counts from here on, also for the programs that follow."""
        x.memory.gears[self.main] = x.memory.gear_data[self.main] = stage
        if stage < self._setups[self.main].stages:
            x.emit(SpindleSetting(x.source, self.main, SpindleValue.GEAR, float(stage)))


def free_number(x: Execution, number: int) -> bool:
    """M3, M4, M5, M19 are ordinary technology functions (P-CHAN-00098)."""
    return x.memory.spindle_m_free and number in x.memory.m_synch
