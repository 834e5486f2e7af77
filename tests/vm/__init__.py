"""Tests on a machine of its own: QEMU with Debian's PREEMPT_RT kernel and real SocketCAN. `make test-vm` runs them."""
