"""What operator and PLC want from a channel in one cycle."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(slots=True)
class ChannelInputs:
    """What the operator and the PLC want from the channel in this cycle."""

    override: float = 1.0
    rapid_override: float = 1.0  # of rapid moves
    alone_override: float = 1.0  # of axes that are homed or moved by hand
    external_feed: float = -1.0  # mm/s, in place of the programmed feed; negative: there is none
    feeds_backward: bool = False  # with it the path is driven backward
    time_override: float = 1.0  # scales the time of the path, on top of the override
    feed_hold: bool = False
    axis_feed_hold: bool = False  # of an axis that takes part
    single_block: bool = False
    optional_stop: bool = False
    continue_motion: bool = False
    read_disable: bool = False
    delete_distance: bool = False  # TRUE in one cycle only
    backward: bool = False
    simulate_motion: bool = False
    simulate_mask: int = 0
    stop_level: int = 0
    restricted: bool = False  # a direction is blocked, or an axis has dynamic limits
    # of the path axes, in their order
    axis_holds: list[bool] = field(default_factory=list)
    blocked: list[int] = field(default_factory=list)  # runtime.hli.layout.Blocked
    limits: list[tuple[float, float] | None] = field(default_factory=list)  # dynamic ones, mm or degrees
