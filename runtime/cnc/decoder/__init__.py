"""The decoder: a program file → blocks. `load_program` opens it in its dialect, `decoder_of` executes it."""

from __future__ import annotations

from runtime.cnc.decoder.decoder import Decoder
from runtime.cnc.decoder.dialects import (
    DIALECTS,
    AnyDecoder,
    AnyProgram,
    decoder_of,
    expect_dialect,
    load_program,
    look_through,
)
from runtime.cnc.decoder.locate import located
from runtime.cnc.decoder.memory import ChannelMemory
from runtime.cnc.decoder.outside import Offline, Outside
from runtime.cnc.decoder.program import Program
from runtime.cnc.decoder.setup import DecoderSetup, DecoderSetupError, SpindleSetup, parse_synch
from runtime.cnc.language.errors import ProgramError, ProgramErrors

__all__ = [
    "DIALECTS",
    "AnyDecoder",
    "AnyProgram",
    "ChannelMemory",
    "Decoder",
    "DecoderSetup",
    "DecoderSetupError",
    "Offline",
    "Outside",
    "Program",
    "ProgramError",
    "ProgramErrors",
    "SpindleSetup",
    "decoder_of",
    "expect_dialect",
    "load_program",
    "located",
    "look_through",
    "parse_synch",
]
