"""The demo machine, as in the tests of the whole machine."""

from tests.machine.conftest import demo

__all__ = ["demo"]
