"""Tests on a machine of its own: QEMU with Debian's PREEMPT_RT kernel, real SocketCAN, real systemd. `make test-vm` runs them."""
