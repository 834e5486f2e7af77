"""Channel parameters under the names of the manual: register, list files, typed values."""

from runtime.config.channel.parameters import ChannelParameters, PathKind

__all__ = ["ChannelParameters", "PathKind"]
