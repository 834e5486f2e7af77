"""One block of words: G functions, feed and speeds, motion, functions, and what comes last.

The order of the words in the text has no influence (programming manual line 1113); what is done here in which order is the order
of the control:

    macros, assignments ─ G functions ─ F E S T D ─ functions before the motion ─ motion ─ functions behind it ─ call or jump
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial

from runtime.cnc.blocks import Block, DynamicsChange, Flush, FlushKind, Source, Stop
from runtime.cnc.decoder import additions, cycles
from runtime.cnc.decoder.axis_jobs import give_jobs, wait_for_jobs
from runtime.cnc.decoder.block_functions import Functions
from runtime.cnc.decoder.control_areas import contour_block, tell
from runtime.cnc.decoder.couplings import expect_no_slave, restore
from runtime.cnc.decoder.declarations import declare
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.flow import Flow
from runtime.cnc.decoder.frames import Frame, Level
from runtime.cnc.decoder.independent import begin_own_motions, emit_own_motions, end_own_motions, wait_for
from runtime.cnc.decoder.isg.registry import G_FUNCTIONS, STATEMENTS, GCall, StatementCall
from runtime.cnc.decoder.measuring import measure, wait_for_values
from runtime.cnc.decoder.modal import INCH, TAPPING, FeedMode, Motion
from runtime.cnc.decoder.motion import POSITION_LIMIT, dwell, move
from runtime.cnc.decoder.radius_compensation import FORBIDDEN_G, expect_none, forbids
from runtime.cnc.decoder.returns import return_to
from runtime.cnc.decoder.selection import select_zero_offset
from runtime.cnc.decoder.spatial import spatial_arc
from runtime.cnc.decoder.technology import SUBPROGRAM_END, functions_of
from runtime.cnc.decoder.threads import tap, thread
from runtime.cnc.decoder.tool_management import begin_with_tools
from runtime.cnc.decoder.tool_words import data_number, tool_words, tools_ready
from runtime.cnc.dynamic_settings import USUAL
from runtime.cnc.language.errors import ProgramError
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import CompiledBlock, GSlots, Values
from runtime.cnc.language.isg.index import Unit
from runtime.cnc.language.isg.macros import check_content
from runtime.cnc.language.isg.syntax import Group
from runtime.cnc.language.isg.words import WordKind
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.catalogue import technology

_FIRST = (Group.PLANE, Group.UNIT, Group.DIMENSION, Group.FEED_MODE)  # they say how the arguments of others count

_END_WHAT_IS_ABSENT = (52, 137)  # diameter programming, feed-forward of the path axes


def _comes_later(call: GCall) -> bool:
    return G_FUNCTIONS[call.number].syntax.group not in _FIRST


class WordBlocks:
    """Executes blocks of one execution. Raises LineError, CircleError and CalculationError."""

    def __init__(self, execution: Execution, flow: Flow) -> None:
        self._x = execution
        self._flow = flow

    def begin_program(self) -> None:
        """What holds from program start on: dynamics, zero offset (V.G.NP_DEFAULT), G functions (prog_start.g_gruppe)."""
        if self._x.dynamics != USUAL:
            self._x.emit(DynamicsChange(self._x.source, self._x.dynamics))
        self._x.read_offsets()
        select_zero_offset(self._x, self._x.memory.zero_default)
        begin_with_tools(self._x)
        restore(self._x)
        if self._x.memory.active_areas:
            tell(self._x)
        for number in self._x.setup.start_g:
            if number in _END_WHAT_IS_ABSENT and number not in G_FUNCTIONS:
                continue
            if number not in G_FUNCTIONS:
                raise ProgramError(catalogue.G_UNSUPPORTED, self._x.unit.place(0), number=number)
            try:
                G_FUNCTIONS[number].handler(self._x, GCall(number, 1))
            except LineError as error:
                raise ProgramError(error.entry, self._x.unit.place(0), **error.values) from None

    def define_macro(self, name: str, content: str) -> None:
        """A macro definition of the block."""
        x = self._x
        limits = x.setup.limits
        for what, size, most in (
            ("the name", len(name), limits.macro_name),
            ("the content", len(content), limits.macro_content),
            ("the number of macros", len(x.memory.macros) + (name not in x.memory.macros), limits.macros),
        ):
            if size > most:
                raise LineError(catalogue.MACRO_LIMIT, 1, name=name, what=what, limit=most)
        check_content(name, content, 1)
        x.memory.define_macro(name, content)

    # ------------------------------------------------------------------ the fast road

    def simple(self, block: CompiledBlock, values: Values, unit: Unit, number: int) -> bool:
        """A straight move and nothing else; False if the block needs the long road after all."""
        x = self._x
        modal, coordinates = x.modal, x.coordinates
        motion = modal.motion if block.motion < 0 else block.motion
        feed = modal.feeds.get(FeedMode.PER_MINUTE)
        if block.feed >= 0:
            feed = values[block.feed] * (INCH if modal.inch else 1.0) * x.setup.feed_factor
            if not 0 < feed < math.inf:
                return False
        if motion > 1 or (motion == 1 and not feed) or x.frames[-1].modal is not None:
            return False
        end = coordinates.position.copy()
        gain, shift, incremental = coordinates.gain, coordinates.shift, modal.incremental
        inch, linear, rotary = modal.inch, x.setup.linear, x.setup.rotary_unit
        for axis, slot in block.axes:
            value = values[slot]
            if not linear[axis]:
                value *= rotary
            elif inch:
                value *= INCH
            if axis in x.modulo.ranges:
                return False
            place = value * gain[axis] + (end[axis] if incremental else shift[axis])
            if not (-POSITION_LIMIT <= place <= POSITION_LIMIT and -POSITION_LIMIT <= value <= POSITION_LIMIT):
                return False
            end[axis] = place
        modal.motion = Motion.LINEAR if motion else Motion.RAPID
        if feed:
            modal.feeds[FeedMode.PER_MINUTE] = feed
        if x.source.program is not unit.name:
            x.source = Source(unit.name, block.source.line, None if number < 0 else number)
        x.straight(end, feed if motion and feed else math.inf, block.source.line, number)
        return True

    # ------------------------------------------------------------------ the long road

    def execute(self, frame: Frame | None, entry: int, block: CompiledBlock, values: Values) -> None:
        """A block of words or a # statement."""
        x = self._x
        if block.statement is not None:
            slots = block.statement
            x.levels.entered = False
            x.sections.before_statement(x)
            if forbids(slots.statement.syntax.name):
                expect_none(x, "#" + slots.statement.syntax.name, slots.statement.column)
            STATEMENTS[slots.statement.syntax.name].handler(x, StatementCall(slots, values))
            if x.again is None:
                if block.beside is not None:
                    added = block.beside
                    STATEMENTS[added.statement.syntax.name].handler(x, StatementCall(added, values))
                if not x.levels.entered:
                    cycles.after_block(x, False)
            return
        if not tools_ready(x, block, values):
            return
        x.axis_words = {axis: values[slot] for axis, slot in block.axes}
        x.letters = {index: values[slot] for index, slot in block.interpolation}
        x.additions = {name: values[slot] for name, slot in block.additions}
        x.axes_taken = False
        x.measuring.begin_block()
        x.incremental_words = {}
        x.end_feed = None
        x.feed_change = None
        x.exact_stop = x.compensation.tangential = x.speed_argument = 0
        x.stands = False
        x.feed_taken = x.override_off = x.brake_in_front = x.radius_taken = False
        x.values = values
        calls = sorted((self._g_call(slots, values) for slots in block.g), key=_comes_later)
        self._alone(block, calls)
        for declaration in block.declarations:
            declare(x, declaration, values)
        if x.setup.mixed_dimension:
            self._mixed_dimension(block, values)
        if block.beside is not None:
            slots = block.beside
            before = slots.statement.syntax.name.startswith("SUPPRESS")
            if before:
                STATEMENTS[slots.statement.syntax.name].handler(x, StatementCall(slots, values))
        for call in calls:
            if call.number in FORBIDDEN_G:
                expect_none(x, f"G{call.number}", call.column)
            if not G_FUNCTIONS[call.number].last:
                G_FUNCTIONS[call.number].handler(x, call)
        if block.radius >= 0 and not x.radius_taken:
            x.modal.radius = x.length(values[block.radius])
        self._feeds(block, values)
        try:
            self._motion_and_functions(frame, entry, block, values, calls)
        finally:
            x.coordinates.resume()

    def _motion_and_functions(
        self, frame: Frame | None, entry: int, block: CompiledBlock, values: Values, calls: list[GCall]
    ) -> None:
        x = self._x
        if x.open_area is not None:
            contour_block(x, block)
            return
        x.compensation.follow(x)
        x.sections.before(x, block)
        functions = functions_of(block, values, x)
        x.sections.tell_feed(x)
        x.turning.tell(x, block)
        actions = self._actions(block, values, functions, [c for c in calls if G_FUNCTIONS[c.number].last])
        x.independent.of_block.clear()
        give_jobs(x, block, values)
        own = bool(x.independent.of_block)
        begin_own_motions(x, functions)
        for before in functions.leading():
            x.emit(before)
        emit_own_motions(x)
        brakes = x.brake_in_front and x.dynamics.late_braking  # G09 for this block only
        if brakes:
            x.emit(DynamicsChange(x.source, replace(x.dynamics, late_braking=False)))
        jump = None
        if block.goto is not None:
            source = entry if frame is not None else -1
            jump = partial(self._flow.jump, x.frames[-1], source, block, block.goto, values)
        motion = self._motion(block, values, jump)
        if brakes:
            x.emit(DynamicsChange(x.source, x.dynamics))
        x.stop_exactly(motion and block.dwell < 0)
        end_own_motions(x, exact_stop=motion and bool(x.exact_stop or x.modal.exact_stop))
        for behind in functions.trailing():
            x.emit(behind)
        wait_for_jobs(x)
        if block.beside is not None and not block.beside.statement.syntax.name.startswith("SUPPRESS"):
            STATEMENTS[block.beside.statement.syntax.name].handler(x, StatementCall(block.beside, values))
        for kind in functions.stops:
            x.emit(Stop(x.source, kind))
        if motion or x.tools.moved or own:
            x.tools.moved = False
            if x.measuring.pending is None:
                x.block_end()
            else:
                wait_for_values(x)
        if functions.flush:
            if x.compensation.active or x.modal.contouring or x.smoothing.spline_on or x.smoothing.hsc_on:
                raise LineError(technology.FLUSH_BARRED, block.column(WordKind.M))
            x.emit(Flush(x.source, FlushKind.WAIT))
        if jump is not None and not x.measuring.interrupts_column:  # that of G310 comes when its run is over
            jump()  # a call in the same block is executed before the program goes on there
        for _, _, action in actions:
            action()
        if not actions and block.goto is None and (block.words or block.macros):
            cycles.after_block(x, motion)

    def _motion(self, block: CompiledBlock, values: Values, jump: Callable[[], None] | None) -> bool:
        """The motion of the block; whether there is any. `jump`: of its `$GOTO`."""
        x = self._x
        if x.measuring.column or x.measuring.through_column:
            return measure(x, block, jump)
        if block.dwell >= 0:
            additions.expect_no_line(x)
            dwell(x, block, values)
            return True
        corner = additions.corner_of(x, block)
        if x.coupling.slaves and not x.axes_taken:
            expect_no_slave(x, x.axis_words, block.column(WordKind.AXIS))
        if x.independent.running and (corner or x.additions or x.modal.motion is Motion.ARC_IN_SPACE):
            wait_for(x, tuple(x.independent.running))
        words = not x.axes_taken and bool(block.axes or block.interpolation)
        if not words and not (x.additions and not x.axes_taken):
            additions.expect_motion(x, block, corner)
            return False
        if additions.contour_line(x, block, corner) or additions.arc_by_angle(x, block, corner):
            return True
        if not words:
            additions.expect_motion(x, block, corner)
            return False
        if x.modal.motion is Motion.ARC_IN_SPACE:
            spatial_arc(x, block, corner)
        elif x.modal.motion is Motion.THREAD:
            thread(x, block, corner)
        elif x.modal.motion in TAPPING:
            tap(x, block, corner)
        else:
            move(x, block, corner)
        return True

    def _actions(
        self, block: CompiledBlock, values: Values, functions: Functions, last: list[GCall]
    ) -> list[tuple[str, int, Callable[[], None]]]:
        """What the block does when everything else is done: program end, return, call. Word, column and action of each."""
        x, levels = self._x, self._x.levels
        actions: list[tuple[str, int, Callable[[], None]]] = []
        m = block.column(WordKind.M)
        if functions.ending >= 0:
            held = functions.held_back() if functions.ending not in SUBPROGRAM_END else []
            actions.append((f"M{functions.ending}", m, lambda: self._end(functions.ending, held, m)))
        if block.returning is not None:
            word = block.returning
            actions.append((f"M{word.index}", word.column, lambda: return_to(x, self._flow, block, values)))
        if block.call is not None:
            call = block.call
            name = values[block.call_slot] if block.call_slot >= 0 else call.name
            actions.append((call.name, call.column, lambda: levels.call(call, name)))
        if functions.tool_change:
            actions.append(("M6", m, lambda: levels.call_file("M6", m, hidden=True)))
        actions += [(f"G{g.number}", g.column, partial(G_FUNCTIONS[g.number].handler, x, g)) for g in last]
        if data_number(x, block, values) is not None and levels.file_of("D"):
            d = block.column(WordKind.TOOL_DATA if block.tool_data >= 0 else WordKind.TOOL)
            actions.append(("D", d, lambda: levels.call_file("D", d)))
        if len(actions) > 1:
            raise LineError(catalogue.CALL_BESIDE, actions[1][1], word=actions[0][0], other=actions[1][0])
        return actions

    def _end(self, number: int, held: list[Block], column: int) -> None:
        """M17, M29: back to the caller. M02, M30, or M17 in the main program: the end of the program."""
        x = self._x
        if number in SUBPROGRAM_END and len(x.frames) > 1:
            x.levels.leave()
            return
        additions.expect_no_line(x)
        if len(x.frames) > 1 and x.frame.level is not Level.FINAL:
            x.warn(catalogue.END_IN_SUBPROGRAM, column, number=number, name=x.frame.section.name or x.unit.name)
        x.levels.finish(held)

    # ------------------------------------------------------------------ parts

    def _g_call(self, slots: GSlots, values: Values) -> GCall:
        word = slots.word
        value = values[slots.value] if slots.value >= 0 else None
        given = tuple(values[slot] if slot >= 0 else None for slot in slots.values)
        return GCall(word.index, word.column, value, given, word.name == "[")

    def _alone(self, block: CompiledBlock, calls: list[GCall]) -> None:
        """Functions that tolerate nothing beside them but their arguments."""
        for call in calls:
            if G_FUNCTIONS[call.number].syntax.alone and any(
                word.kind is not WordKind.AXIS and (word.kind is not WordKind.G or word.index != call.number)
                for word in block.words
            ):
                raise LineError(catalogue.NOT_ALONE, call.column, word=f"G{call.number}")

    def _mixed_dimension(self, block: CompiledBlock, values: Values) -> None:
        """G90 and G91 hold for the coordinates right of them (P-CHAN-00116). Of an axis that stands several times in the block
        (P-CHAN-00148) relative words add up, to an absolute one too; an absolute one leaves out what stands left of it."""
        x = self._x
        state = x.modal.incremental
        slots = iter(block.axes)
        x.axis_words.clear()
        for word in block.words:
            if word.kind is WordKind.G and word.index in (90, 91):
                state = word.index == 91
            elif word.kind is WordKind.AXIS:
                axis, slot = next(slots)
                if state and axis in x.axis_words:
                    x.axis_words[axis] += values[slot]
                else:
                    x.axis_words[axis], x.incremental_words[axis] = values[slot], state

    def _feeds(self, block: CompiledBlock, values: Values) -> None:
        x, modal = self._x, self._x.modal
        x.take_feed()
        if block.end_feed >= 0:
            value = values[block.end_feed]
            if modal.feed_mode is not FeedMode.PER_MINUTE:
                raise LineError(catalogue.END_FEED_MODE, block.column(WordKind.END_FEED))
            if not 0 <= value < math.inf:
                raise LineError(catalogue.FEED_INVALID, block.column(WordKind.END_FEED), value=value)
            x.end_feed = value * (INCH if modal.inch else 1.0) * x.setup.feed_factor
        tool_words(x, block, values)
