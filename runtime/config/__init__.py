"""The machine description: YAML → typed, validated objects."""

from runtime.config.loader import ConfigurationError, load_machine

__all__ = ["ConfigurationError", "load_machine"]
