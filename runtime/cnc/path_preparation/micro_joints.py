"""Micro-joints: functions that are moved back along the path, by cutting its elements (cutting manual, lines 1001–1540).

    N10 ━━━━━━━━━┿━━━ N20 ━━━━●━━━━┿━━━━ N30 M500 M300       M500 with a lead is put out at ●, M300 at its place:
                              └── lead ──┘                   between them the beam is off, a bridge of material stays

The stage keeps back the last NC blocks of the path. A function with a lead that comes is put between them, and what was kept goes
on; so a later one comes back to the place of the one before at most. Nothing is moved over a place where the path waits for the
decoder or for an operator, nor into a block that an MVS_SNS function waits at the end of.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from runtime.cnc.blocks import (
    MICRO_JOINTS,
    Arc,
    Block,
    BlockEnd,
    CouplingChange,
    DynamicsChange,
    Flush,
    Hold,
    Homing,
    IndependentMotion,
    IndependentWait,
    Line,
    ManualMotion,
    Measurement,
    MeasurementEnd,
    MicroJointFeed,
    PathRestart,
    Polyline,
    Polynomials,
    PositionSetting,
    Stop,
    Synch,
    TakeOver,
    TechnologyFunction,
    Wait,
)
from runtime.cnc.dynamic_settings import NO_LIMITS, USUAL, DynamicSettings
from runtime.cnc.path_preparation.element_lengths import MOTIONS, Motion, before, behind, element_lengths
from runtime.cnc.path_preparation.errors import PathError
from runtime.cnc.path_preparation.motion_pieces import lines_of, moves
from runtime.config.channel.parameters import INTERNAL, ChannelParameters
from runtime.diagnostics.catalogue import machine
from runtime.diagnostics.catalogue import technology as catalogue
from runtime.diagnostics.errors import Place, Problem

_ON_BORDER = 1e-6  # mm: a place so near to the end of an element lies there
_MOST_KEPT = 4096  # blocks of any kind; a program without ends of blocks is not kept back further
_BARRIERS = (
    CouplingChange,
    Flush,
    Hold,
    Homing,
    IndependentMotion,
    IndependentWait,
    ManualMotion,
    Measurement,
    MeasurementEnd,
    PathRestart,
    PositionSetting,
    Stop,
    TakeOver,
)
_WAITED = Synch.MVS_SVS | Synch.MVS_SNS | Synch.MNS_SNS


@dataclass(frozen=True, slots=True)
class MicroJointSettings:
    """NC blocks that are kept back (P-CHAN-00603); mm beyond which fewer are, 0: however long they are (P-CHAN-00604); mm by
    which a function may miss its place, 0: by any (P-CHAN-00760)."""

    blocks: int = 10
    most: float = 0.0
    tolerance: float = 0.0

    @classmethod
    def of(cls, parameters: ChannelParameters) -> MicroJointSettings | None:
        """Of a channel; None if it has no micro-joints (P-CHAN-00600)."""
        preparation = parameters.configuration.path_preparation
        if not preparation.has_micro_joints:
            return None
        most = preparation.m_pre_output_max_distance * INTERNAL
        return cls(preparation.m_pre_output_lookahead, most, parameters.pre_output_tolerance * INTERNAL)


@dataclass(slots=True)
class _Kept:
    """A block that is kept back. `lengths` of its elements, mm; `ends`: NC blocks that end within it or with it."""

    block: Block
    lengths: tuple[float, ...] = ()
    ends: int = 0

    @classmethod
    def of(cls, block: Block) -> _Kept:
        if isinstance(block, MOTIONS):
            return cls(block, tuple(element_lengths(block).tolist()), _ends(block))
        return cls(block, ends=int(isinstance(block, BlockEnd)))

    @property
    def length(self) -> float:
        return sum(self.lengths)


def _ends(motion: Motion) -> int:
    if isinstance(motion, Polyline):
        return 0 if motion.one_block else len(motion.feeds)
    return int(motion.block_ends.sum()) if isinstance(motion, Polynomials) else 0


class MicroJoints:
    """The stage of one program. What there is to warn of goes to `warnings`."""

    def __init__(self, settings: MicroJointSettings, warnings: list[Problem] | None = None) -> None:
        self._settings = settings
        self._warnings = warnings
        self._kept: list[_Kept] = []
        self._ends = 0
        self._length = 0.0
        self._dynamics = USUAL  # where what is kept begins
        self._feed: MicroJointFeed | None = None  # of the next joint
        self._within = False  # the last place lies within a line or an arc

    def __call__(self, blocks: Iterable[Block]) -> Iterator[Block]:
        group: list[TechnologyFunction] = []
        for block in blocks:
            if isinstance(block, TechnologyFunction) and block.lead > 0.0 and block.synch.kind & MICRO_JOINTS:
                if group and group[0].source != block.source:
                    yield from self._placed(group)
                    group = []
                group.append(block)
                continue
            if group:
                yield from self._placed(group)
                group = []
            if isinstance(block, MicroJointFeed):
                self._feed = block
            elif isinstance(block, _BARRIERS):
                yield from self._released()
                yield block
            else:
                self._keep(_Kept.of(block))
                yield from self._surplus()
        if group:
            yield from self._placed(group)
        yield from self._released()

    # ------------------------------------------------------------------ what is kept back

    def _keep(self, kept: _Kept) -> None:
        self._kept.append(kept)
        self._ends += kept.ends
        self._length += kept.length

    def _let_go(self, count: int) -> Iterator[Block]:
        """The first ones go on."""
        gone, self._kept = self._kept[:count], self._kept[count:]
        for kept in gone:
            self._ends -= kept.ends
            self._length -= kept.length
            if isinstance(kept.block, DynamicsChange):
                self._dynamics = kept.block.settings
            yield kept.block

    def _released(self) -> Iterator[Block]:
        yield from self._let_go(len(self._kept))
        self._ends, self._length = 0, 0.0

    def _surplus(self) -> Iterator[Block]:
        """What lies further back than a function may be moved."""
        most = self._settings.most
        while self._ends > self._settings.blocks or len(self._kept) > _MOST_KEPT:
            first, surplus = self._kept[0], self._ends - self._settings.blocks
            if first.ends > surplus:
                run = first.block
                if not isinstance(run, Polyline):
                    break  # a curve stays as it is: a function comes back a little further
                self._kept[:1] = [_Kept.of(moves(run, 0, surplus)), _Kept.of(moves(run, surplus, len(run.feeds)))]
            yield from self._let_go(1)
        while most > 0.0 and self._kept and self._length - self._kept[0].length > most:
            yield from self._let_go(1)

    # ------------------------------------------------------------------ functions that are moved back

    def _placed(self, group: list[TechnologyFunction]) -> Iterator[Block]:
        """Everything that is kept, with the functions at their places."""
        feed, self._feed = self._feed, None
        for function in sorted(group, key=lambda function: -function.lead):
            at, missed = self._place(function)
            self._check(function, missed)
            out: list[_Kept] = [_Kept(replace(function, lead=0.0))]
            if function.synch.kind & _WAITED:
                wait = _Kept(Wait(function.source, function.synch.kind))
                if function.synch.kind == Synch.MVS_SNS and self._within:
                    self._kept.insert(at + 1, wait)  # at the end of the block that was cut
                else:
                    out.append(wait)
            self._kept[at:at] = out
            if feed is not None:
                self._set_feed(at, at + len(out), feed)
                feed = None
        yield from self._released()

    def _place(self, function: TechnologyFunction) -> tuple[int, float]:
        """Index in what is kept in front of which the function belongs, and by how much it misses its place, mm."""
        left = function.lead
        self._within = False
        for index in range(len(self._kept) - 1, -1, -1):
            kept = self._kept[index]
            if isinstance(kept.block, Wait) and self._waits_for_motion(index):
                return index + 1, left
            for element in range(len(kept.lengths) - 1, -1, -1):
                length = kept.lengths[element]
                if length > left + _ON_BORDER:
                    return self._cut(index, element, length - left), 0.0
                left -= length
                if left <= _ON_BORDER:
                    return self._cut(index, element, 0.0) if element else index, 0.0
        return 0, left

    def _waits_for_motion(self, index: int) -> bool:
        """At this Wait the path waits for a function MVS_SNS that was put out in front of motion."""
        motion = False
        source = self._kept[index].block
        assert isinstance(source, Wait)
        if not source.kinds & Synch.MVS_SNS:
            return False
        for kept in reversed(self._kept[:index]):
            block = kept.block
            motion |= bool(kept.lengths)
            if isinstance(block, Wait) or (isinstance(block, BlockEnd) and motion):
                return False
            if isinstance(block, TechnologyFunction) and block.synch.kind == Synch.MVS_SNS:
                return motion
        return False

    def _cut(self, index: int, element: int, taken: float) -> int:
        """Cut a motion `taken` mm into an element; the index of what is behind the place."""
        kept = self._kept[index]
        motion, length = kept.block, kept.lengths[element]
        assert isinstance(motion, MOTIONS)
        front = [_Kept.of(piece) for piece in before(motion, element, taken, length)]
        back = [_Kept.of(piece) for piece in behind(motion, element, taken, length)]
        self._kept[index : index + 1] = front + back
        self._within = taken > 0.0 and not isinstance(motion, Polynomials)
        return index + len(front)

    def _check(self, function: TechnologyFunction, missed: float) -> None:
        """Raises PathError for a function that misses its place by more than it may."""
        if missed <= _ON_BORDER:
            return
        place = Place(function.source.program, function.source.line)
        values = {"letter": function.kind.name, "number": function.number, "late": missed}
        tolerance = self._settings.tolerance
        if tolerance > 0.0:
            if missed > tolerance:
                raise PathError(machine.PRE_OUTPUT_LATE, place, limit=tolerance, **values)
        elif self._warnings is not None:
            self._warnings.append(Problem(catalogue.JOINT_SHORT, {**values, "lead": function.lead}, place))

    # ------------------------------------------------------------------ feed of a joint

    def _set_feed(self, end: int, begin: int, joint: MicroJointFeed) -> None:
        """The feed in the joint, from index `begin` on, and where the path comes to it, before index `end`."""
        if joint.without_limits:
            self._lift_limits(begin, joint)
        if joint.feed is not None:
            for kept in self._kept[begin:]:
                kept.block = _with_feed(kept.block, joint.feed)
        if joint.end_feed is not None:
            last = next((k for k in range(end - 1, -1, -1) if self._kept[k].lengths), -1)
            if last >= 0:
                slower = _with_end_feed(self._kept[last].block, joint.end_feed)
                self._kept[last : last + 1] = [_Kept.of(block) for block in slower]

    def _lift_limits(self, at: int, joint: MicroJointFeed) -> None:
        """#VECTOR LIMIT does not count in the joint; behind it what was selected holds again."""
        dynamics = self._dynamics
        for kept in self._kept[:at]:
            if isinstance(kept.block, DynamicsChange):
                dynamics = kept.block.settings
        lifted = _Kept(DynamicsChange(joint.source, _without_limits(dynamics)))
        for kept in self._kept[at:]:
            if isinstance(kept.block, DynamicsChange):
                dynamics = kept.block.settings
                kept.block = replace(kept.block, settings=_without_limits(dynamics))
        self._kept.insert(at, lifted)
        self._kept.append(_Kept(DynamicsChange(joint.source, dynamics)))


def _without_limits(dynamics: DynamicSettings) -> DynamicSettings:
    feed, rapid = replace(dynamics.feed, vector=NO_LIMITS), replace(dynamics.rapid, vector=NO_LIMITS)
    return replace(dynamics, feed=feed, rapid=rapid)


def _with_feed(block: Block, feed: float) -> Block:
    """The same with another feed, if it is a motion and no rapid one."""
    if isinstance(block, Polyline | Polynomials):
        return replace(block, feeds=np.where(np.isfinite(block.feeds), feed, block.feeds))
    if isinstance(block, Arc) or (isinstance(block, Line) and not block.rapid):
        return replace(block, feed=feed)
    return block


def _with_end_feed(block: Block, feed: float) -> Iterator[Block]:
    """The same with a feed at its end."""
    if isinstance(block, Line | Arc):
        yield replace(block, end_feed=feed)
    elif isinstance(block, Polynomials):
        k = len(block.feeds) - 1
        if k and not block.constant_velocity:
            yield from before(block, k, 0.0, 1.0)
            yield from (
                replace(last, end_feed=feed) for last in behind(block, k, 0.0, 1.0) if isinstance(last, Polynomials)
            )
        else:
            yield replace(block, end_feed=feed)
    elif isinstance(block, Polyline):
        k = len(block.feeds) - 1
        if k:
            yield moves(block, 0, k)
        for line in lines_of(moves(block, k, k + 1)):
            yield replace(line, end_feed=feed)
            if not block.one_block:
                yield BlockEnd(line.source)
    else:
        yield block
