"""What all tests share."""

pytest_plugins = ["tests.spec_results", "runtime.testbench.plugin"]
