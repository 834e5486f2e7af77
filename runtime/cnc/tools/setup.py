"""What the channel parameters say about tools, in mm and seconds."""

from __future__ import annotations

from dataclasses import dataclass

from runtime.config.channel.parameters import INTERNAL, ChannelParameters

ANSWER_TIMEOUT = 10.0  # s


@dataclass(frozen=True, slots=True)
class ToolSetup:
    """A channel's way with tools."""

    implicit_d: bool = False  # P-CHAN-00014: T executes D too
    direct_offsets: bool = False  # P-CHAN-00100: D moves the axes at once
    length_stays: bool = False  # P-CHAN-00420: the length acts in Z in every plane
    minimum_length: float = 0.0  # P-CHAN-00156, mm, 0: none
    minimum_radius: float = 0.0  # P-CHAN-00157, mm, 0: none

    @classmethod
    def of(cls, parameters: ChannelParameters) -> ToolSetup:
        return cls(
            implicit_d=parameters.einrechnen_mit_t,
            direct_offsets=parameters.move_tool_offsets_directly,
            length_stays=parameters.remain_tool_length_in_ax,
            minimum_length=parameters.tool.minimum_length * INTERNAL,
            minimum_radius=parameters.tool.minimum_radius * INTERNAL,
        )
