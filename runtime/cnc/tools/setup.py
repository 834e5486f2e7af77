"""What the channel parameters say about tools, in mm and seconds."""

from __future__ import annotations

from dataclasses import dataclass

from runtime.config.channel.parameters import INTERNAL, ChannelParameters

ANSWER_CYCLES = 10_000


@dataclass(frozen=True, slots=True)
class ToolSetup:
    """A channel's way with tools."""

    implicit_d: bool = False  # P-CHAN-00014: T executes D too
    direct_offsets: bool = False  # P-CHAN-00100: D moves the axes at once
    length_stays: bool = False  # P-CHAN-00420: the length acts in Z in every plane
    minimum_length: float = 0.0  # P-CHAN-00156, mm, 0: none
    minimum_radius: float = 0.0  # P-CHAN-00157, mm, 0: none
    wait_at_d: bool = False  # P-CHAN-00271: #FLUSH WAIT before D
    external: bool = False  # P-CHAN-00016: the tools are those of an external management
    announce: bool = False  # P-CHAN-00087: it is told of T
    flush_at_t: bool = False  # P-CHAN-00106: #FLUSH CONTINUE with T
    save_at_start: bool = False  # P-CHAN-00103: a program start saves the tool of the program before
    tell_life: bool = False  # P-CHAN-00076: it is told how long tools are in use
    life_with_d: bool = False  # P-CHAN-00482: a tool is in use from D on, and not from T on
    answer_cycles: int = ANSWER_CYCLES  # that the management has to answer

    @classmethod
    def of(cls, parameters: ChannelParameters, answer_cycles: int = ANSWER_CYCLES) -> ToolSetup:
        """The setup by the channel's parameters."""
        return cls(
            implicit_d=parameters.einrechnen_mit_t,
            direct_offsets=parameters.move_tool_offsets_directly,
            length_stays=parameters.remain_tool_length_in_ax,
            minimum_length=parameters.tool.minimum_length * INTERNAL,
            minimum_radius=parameters.tool.minimum_radius * INTERNAL,
            wait_at_d=parameters.flush.d_cmd == "FAW_D",
            external=parameters.ext_wzv_vorhanden,
            announce=parameters.t_info_to_wzv,
            flush_at_t=parameters.t_with_implicit_flush,
            save_at_start=parameters.d_clear_to_wzv,
            tell_life=parameters.tool_life_to_wzv,
            life_with_d=parameters.tool_life_with_d,
            answer_cycles=answer_cycles,
        )
