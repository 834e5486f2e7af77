"""One block of words: codes, modal words, functions, motion, and what comes last (manual lines 2887–2927).

The order of the words in the text has no influence:

    G of SELECT ─ F H D … ─ G of SET ─ functions before the motion ─ motion ─ functions behind it ─ stops ─ calls, returns, end
"""

from __future__ import annotations

import math

from runtime.cnc.blocks import Arc, Dwell, ExactStop, Line, Polyline, Polynomials, Source, SpatialArc, Stop, StopKind
from runtime.cnc.decoder.feed_group import MAIN_AXES
from runtime.cnc.decoder.modal import FeedMode, Motion
from runtime.cnc.decoder.motion import POSITION_LIMIT
from runtime.cnc.decoder.nct.corners import corner_of
from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.decoder.nct.frames import Frame
from runtime.cnc.decoder.nct.functions import functions_of, m_numbers, speed_of_end
from runtime.cnc.decoder.nct.g_skip import wait_for_signal
from runtime.cnc.decoder.nct.registry import G_CODES, M_CODES, TABLE, WORDS, GCall, Group, Stage, number_text, tenths_of
from runtime.cnc.decoder.nct.words import BlockWords
from runtime.cnc.language.errors import LineError
from runtime.cnc.language.nct.addresses import ADDRESSES, checked
from runtime.cnc.language.nct.compiler import CompiledBlock, Value, Values
from runtime.cnc.language.nct.words import Word
from runtime.diagnostics.catalogue import nct as catalogue

STOPS = {0: StopKind.PROGRAMMED, 1: StopKind.OPTIONAL}
NO_CYCLE, POLAR = 800, 160
NOTED = "ABCDEHMST"  # addresses whose last value programs can read (#4101 to #4120)
MOTIONS = (Line, Arc, SpatialArc, Polyline, Polynomials)
_LEAVE_TO_THE_MOVER = (Group.MOTION, Group.CYCLE, Group.COMPENSATION)  # I, J, K of G41 are those of a circle beside it
_FUNCTION_ADDRESSES = ("G", "M", "S", "T")


def g_calls(words: BlockWords) -> list[GCall]:
    """The G codes of a block in the order of the text. LineError for one that there is not, and for two of a group."""
    calls: list[GCall] = []
    groups: dict[Group, GCall] = {}
    for word, value in words.all:
        if word.address != "G":
            continue
        assert value is not None
        tenths = tenths_of(value)
        code = G_CODES.get(tenths)
        if code is None:
            if tenths in TABLE:
                raise LineError(catalogue.NOT_SUPPORTED, word.column, what=f"G{number_text(tenths)}")
            raise LineError(catalogue.ILLEGAL_G, word.column, number=number_text(tenths))
        call = GCall(tenths, word.column)
        other = groups.setdefault(code.group, call)
        if other is not call:
            raise LineError(
                catalogue.G_GROUP_TWICE,
                word.column,
                number=number_text(tenths),
                other=number_text(other.tenths),
                group=f"{code.group.value % 100:02d}",
            )
        calls.append(call)
    return calls


class WordBlocks:
    """Executes blocks of words of one execution. Raises LineError, GeometryError and CalculationError."""

    def __init__(self, execution: NctExecution) -> None:
        self._x = execution

    # ------------------------------------------------------------------ the fast road

    def simple(self, frame: Frame, block: CompiledBlock) -> bool:
        """A straight move and nothing else; False if the block needs the long road after all."""
        x = self._x
        modal, coordinates = x.modal, x.coordinates
        if x.macros.watches:
            return False
        if x.active.get(Group.CYCLE, NO_CYCLE) != NO_CYCLE or x.active.get(Group.POLAR) == POLAR:
            return False
        motion, feed = modal.motion, modal.feeds.get(FeedMode.PER_MINUTE)
        end = coordinates.position.copy()
        gain, shift = coordinates.gain, coordinates.shift
        if x.nct.feedmax or x.surface.on:
            return False
        assert block.constants is not None
        for word, value in zip(block.words, block.constants, strict=True):
            assert value is not None
            if word.address == "G":
                motion = Motion.LINEAR if value else Motion.RAPID
            elif word.address == "F":
                return False
            else:
                axis = x.axis_of.get(word.address)
                if axis is None or axis in x.modulo.ranges or axis >= MAIN_AXES or not x.setup.linear[axis]:
                    return False
                value = x.axis_value(axis, value)
                place = value * gain[axis] + (end[axis] if modal.incremental else shift[axis])
                if not (-POSITION_LIMIT <= place <= POSITION_LIMIT and -POSITION_LIMIT <= value <= POSITION_LIMIT):
                    return False
                end[axis] = place
        if motion not in (Motion.RAPID, Motion.LINEAR) or (motion is Motion.LINEAR and not feed):
            return False
        modal.motion = motion
        x.active[Group.MOTION] = 10 * int(motion)
        name = frame.unit.name
        if x.source.program is not name:
            x.source = Source(name, block.source.line, None if block.number < 0 else block.number)
        x.straight(end, feed if motion is Motion.LINEAR and feed else math.inf, block.source.line, block.number)
        return True

    # ------------------------------------------------------------------ the long road

    def execute(self, block: CompiledBlock, values: Values) -> None:
        """A block of words with the values of its words, vacant ones None."""
        x = self._x
        pairs: list[tuple[Word, Value]] = list(zip(block.words, values, strict=True))
        if not block.constant:
            pairs = [(w, None if v is None else checked(w.address, v, w.column)) for w, v in pairs]
        words = x.words = BlockWords(pairs, x.axis_of)
        noted: dict[str, float] = {}
        for word, spoken in words.all:
            if word.address in NOTED and spoken is not None:
                noted.setdefault(word.address, spoken)
        self._begin(words)
        if x.macros.before(words):
            return
        calls = g_calls(words)
        codes = [G_CODES[call.tenths] for call in calls]
        if any(code.all_words for code in codes):
            words.take_all()
            for call in calls:
                G_CODES[call.tenths].handler(x, call)
            self._act()
            return
        groups = {code.group for code in codes}
        if Group.MOTION in groups and Group.CYCLE not in groups:
            x.end_of_cycle()
        self._once(words)
        words.take(_FUNCTION_ADDRESSES)
        words.take(x.nct.miscel)
        numbers = m_numbers(words)
        for code in codes:
            words.take(code.takes)
            if code.modal and code.stage is Stage.SELECT:
                x.active[code.group] = code.tenths
        claimed = {a for code in codes if code.group not in _LEAVE_TO_THE_MOVER for a in code.takes}
        for number, _ in numbers:
            if number in M_CODES:
                words.take(M_CODES[number].takes)
                claimed |= M_CODES[number].takes
        words.claimed = frozenset(claimed)
        self._stage(calls, Stage.SELECT)
        for address, known in WORDS.items():
            value = words.number(address)
            if value is not None:
                known.handler(x, value, words.place(address))
        self._stage(calls, Stage.SET)
        moves_by_code = [call for call in calls if G_CODES[call.tenths].stage is Stage.MOVE]
        mover = x.mover()
        own = [a for a in mover.takes if a in words and a not in claimed]
        words.take(mover.takes)
        self._expect_taken(words)
        x.compensation.follow(x)
        x.corner = corner_of(x)
        functions = x.block_functions = functions_of(x, words, numbers)
        moves = not moves_by_code and not x.axes_taken and bool(x.axis_words or own)
        within = moves and mover.functions_within
        if not within:
            for before in functions.leading():
                x.emit(before)
        if moves:
            x.surface.before_motion(x)
        since, collected = len(x.out), x.collected
        for call in moves_by_code:
            G_CODES[call.tenths].handler(x, call)
        if moves:
            assert mover.moves is not None
            mover.moves(x)
        moved = x.collected > collected or any(isinstance(out, MOTIONS) for out in x.out[since:])
        x.stands = False
        if moves and x.modal.motion is Motion.RAPID and x.surface.acts(x):
            x.out[since:since] = speed_of_end(x)
        dwelt = any(isinstance(out, Dwell) for out in x.out[since:])
        if moved and x.stops_here and not x.suppressed.exact_stop:
            x.emit(ExactStop(x.source))
            x.stands = True
        else:
            x.stop_exactly(moved)
        if not within:
            for behind in functions.trailing():
                x.emit(behind)
        for number, _ in numbers:
            if number in STOPS:
                x.emit(Stop(x.source, STOPS[number]))
        if x.measuring.pending is not None:
            wait_for_signal(x)
        elif moved or dwelt:
            x.block_end()
        for number, column in numbers:
            if number in M_CODES:
                M_CODES[number].handler(x, number, column)
        self._stage(calls, Stage.LAST)
        self._act()
        x.last_words.update(noted)
        if x.stack:
            x.macros.after(moved)

    def _begin(self, words: BlockWords) -> None:
        """What belongs to the block in work alone."""
        x = self._x
        x.axis_words = {
            x.axis_of[word.address]: value
            for word, value in words.all
            if word.address in x.axis_of and value is not None
        }
        x.letters = {"IJK".index(word.address): v for word, v in words.all if word.address in "IJK" and v is not None}
        x.incremental_words = {
            x.axis_of[word.address]: word.incremental or x.modal.incremental
            for word, _ in words.all
            if word.address in x.axis_of
        }
        x.length_before = tuple(x.coordinates.length)
        x.additions = {}
        x.axes_taken = False
        x.end_feed = x.feed_change = None
        x.exact_stop = 0
        x.override_off = x.brake_in_front = False
        x.actions = []
        x.stops_here = x.speed_taken = False
        x.corner = None

    def _once(self, words: BlockWords) -> None:
        """LineError for an address that the channel does not have, and for one that stands twice."""
        seen: set[str] = set()
        for word, _ in words.all:
            if word.address in seen and ADDRESSES[word.address].unique:
                raise LineError(catalogue.WORD_TWICE, word.column, address=word.address)
            seen.add(word.address)

    def _expect_taken(self, words: BlockWords) -> None:
        x = self._x
        for word in words.left:
            if word.address in x.axis_of:
                continue
            if word.address in "XYZUVWABC":
                x.expect_axis(word.address, word.column)
            raise LineError(catalogue.WORD_WITHOUT_MEANING, word.column, address=word.address)

    def _stage(self, calls: list[GCall], stage: Stage) -> None:
        x = self._x
        for call in calls:
            code = G_CODES[call.tenths]
            if code.stage is stage:
                code.handler(x, call)
                if code.modal:
                    x.active[code.group] = code.tenths
        if stage is Stage.SELECT:  # G90 and G91 say how the words count
            for word, _ in self._x.words.all:
                if word.address in x.axis_of:
                    x.incremental_words[x.axis_of[word.address]] = word.incremental or x.modal.incremental

    def _act(self) -> None:
        x = self._x
        for action in x.actions:
            action()
        x.actions = []
