"""Making and attaching to the HLI, and the start-up check between two processes."""

from __future__ import annotations

import ctypes as c
import gc
import os
import signal
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

from runtime.config.loader import load_machine
from runtime.diagnostics.memory import SHARED_MEMORY
from runtime.hli import layout
from runtime.hli.describe import describe_machine, io_bits
from runtime.hli.errors import HliError
from runtime.hli.layout import Hli
from runtime.hli.memory import HliMemory, describe_layout, get_text, layout_hash, put_text


def other_process(code: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=False)


@pytest.mark.spec("hli.mech.shared-memory")
def test_another_process_reads_what_the_owner_writes_and_answers(shared: HliMemory) -> None:
    shared.hli.channels[0].status.line_r = 4711
    done = other_process(
        "import sys; from runtime.hli.memory import HliMemory\n"
        "with HliMemory.attach(sys.argv[1]) as memory:\n"
        "    print(memory.hli.channels[0].status.line_r)\n"
        "    memory.hli.channels[0].plc_present_w = True",
        shared.name or "",
    )
    assert (done.stdout.strip(), done.stderr) == ("4711", "")
    assert shared.hli.channels[0].plc_present_w
    assert (SHARED_MEMORY / str(shared.name)).exists(), "the memory must outlive a process that attached to it"


@pytest.mark.spec("hli.mech.init-check")
@pytest.mark.parametrize(
    ("element", "value", "error"),
    [
        ("magic_r", 0, 40019),
        ("version_r", b"0.9", 40015),
        ("channel_capacity_r", 9, 40016),
        ("axis_capacity_r", 9, 40016),
        ("axis_size_r", 9, 40017),
        ("channel_size_r", 9, 40018),
        ("platform_size_r", 9, 40022),
        ("layout_hash_r", b"f" * 64, 304004),
    ],
)
def test_another_layout_is_refused_by_another_process(
    shared: HliMemory, element: str, value: object, error: int
) -> None:
    setattr(shared.hli.head, element, value)
    done = other_process(
        "import sys; from runtime.hli.memory import HliMemory; from runtime.hli.errors import HliError\n"
        "for read_only in (False, True):\n"
        "    try:\n"
        "        HliMemory.attach(sys.argv[1], read_only=read_only)\n"
        "    except HliError as refusal:\n"
        "        print(refusal.problem.entry.id)",
        shared.name or "",
    )
    assert done.stdout.split() == [str(error)] * 2
    assert done.stderr == ""


@pytest.mark.parametrize("read_only", [False, True])
@pytest.mark.parametrize("content", [b"", b"x", b"x" * 60_000])
def test_foreign_memory_is_refused(name: str, content: bytes, read_only: bool) -> None:
    path = SHARED_MEMORY / name
    path.write_bytes(content)
    try:
        with pytest.raises(HliError) as refusal:
            HliMemory.attach(name, read_only=read_only)
        assert refusal.value.problem.entry.id == 40019
    finally:
        path.unlink()


def test_nothing_to_attach_to(name: str) -> None:
    with pytest.raises(HliError, match="304001"):
        HliMemory.attach(name)
    with pytest.raises(HliError, match="304003"):
        HliMemory.attach("../passwd")


def test_a_second_runtime_of_the_same_name_is_refused_while_the_first_lives(shared: HliMemory) -> None:
    with pytest.raises(HliError) as refusal:
        HliMemory.create(str(shared.name))
    assert refusal.value.problem.entry.id == 304005
    assert str(os.getpid()) in refusal.value.problem.text


def test_the_left_over_of_a_killed_runtime_is_replaced_and_seen_as_dead(name: str) -> None:
    code = (
        "import sys, time; from runtime.hli.memory import HliMemory\n"
        "memory = HliMemory.create(sys.argv[1]); memory.hli.head.running_r = True\n"
        "print('ready', flush=True); time.sleep(60)"
    )
    process = subprocess.Popen([sys.executable, "-c", code, name], stdout=subprocess.PIPE)
    assert process.stdout is not None
    assert process.stdout.readline() == b"ready\n"
    with HliMemory.attach(name, read_only=True) as watcher:
        assert watcher.owner_alive
        process.send_signal(signal.SIGKILL)
        process.wait()
        process.stdout.close()
        assert watcher.hli.head.running_r, "the killed process could not take it back"
        assert not watcher.owner_alive
    with HliMemory.create(name) as memory:
        assert not memory.hli.head.running_r


def test_a_read_only_client_follows_the_machine_and_cannot_disturb_it(shared: HliMemory) -> None:
    with HliMemory.attach(str(shared.name), read_only=True) as watcher:
        shared.hli.axes[0].status.actual_position_r = 123
        assert watcher.hli.axes[0].status.actual_position_r == 123
        watcher.hli.operator[0].reset_rw = True
        assert not shared.hli.operator[0].reset_rw


def test_permissions_let_the_group_look(shared: HliMemory) -> None:
    assert (SHARED_MEMORY / str(shared.name)).stat().st_mode & 0o777 == 0o640


def test_structures_stay_readable_after_close_and_nothing_complains(name: str) -> None:
    memory = HliMemory.create(name)
    channel = memory.hli.channels[0]
    channel.status.line_r = 5
    memory.close()
    assert not (SHARED_MEMORY / name).exists()
    assert channel.status.line_r == 5
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        del channel, memory
        gc.collect()


def test_the_hash_follows_every_element() -> None:
    class A(c.Structure):
        _fields_ = [("x", c.c_int32), ("y", c.c_bool * 2)]

    class B(c.Structure):
        _fields_ = [("x", c.c_int32), ("z", c.c_bool * 2)]

    described = describe_layout(A)
    assert described == "A(x@0+4:c_int=4;y@4+2:c_bool=1[2])=8"
    assert described.replace("A(", "B(") != describe_layout(B)
    assert layout_hash() == layout_hash()
    assert len(layout_hash()) == 64


def test_text_is_cut_between_characters() -> None:
    hli = Hli()
    put_text(hli.channels[0], "name_r", "ä" * 40)
    assert get_text(hli.channels[0], "name_r") == "ä" * 15  # 31 bytes and an end mark
    put_text(hli.channels[0], "name_r", "short")
    assert get_text(hli.channels[0], "name_r") == "short"


@pytest.mark.spec("hli.area.organisation", "hli.area.channel-head", "hli.area.axis-head", "hli.area.platform")
def test_the_demo_machine_is_described() -> None:
    machine = load_machine()
    hli = HliMemory.private().hli
    describe_machine(hli, machine)
    assert get_text(hli.head, "machine_name_r") == "demo mill"
    assert (hli.head.channels_r, hli.head.axes_r, hli.head.cycle_time_r) == (1, 4, 1000)
    assert [get_text(hli.axes[i], "name_r") for i in range(4)] == ["X", "Y", "Z", "S"]
    assert [hli.axes[i].log_ax_n_r for i in range(4)] == [1, 2, 3, 6]
    assert hli.axes[3].axis_type_r == 4
    assert list(hli.channels[0].axis_index_r)[: hli.channels[0].axis_count_r] == [0, 1, 2]
    inputs, outputs = io_bits(machine)
    assert inputs["clamp_closed"] == 0
    assert inputs["e_stop_ok"] == 6
    assert outputs["lamp_red"] == 5


def test_fresh_memory_is_standing_by_with_full_override() -> None:
    hli = HliMemory.private().hli
    assert hli.operator[0].override_w == 1000
    modes = hli.channels[0].control.mode_and_state
    assert (modes.mode_r, modes.state_r) == (layout.Mode.STANDBY, layout.State.SELECTED)


def test_no_path_of_the_tree_is_unaligned() -> None:
    """Unguarded elements are read with one load: every one stands at a multiple of its size."""

    def check(kind: type, base: int, path: str) -> None:
        for element, of, *_ in kind._fields_:  # type: ignore[attr-defined]
            offset = base + getattr(kind, element).offset
            item = of
            while issubclass(item, c.Array):
                item = item._type_
            if issubclass(item, c.Structure):
                check(item, offset, f"{path}.{element}")
            else:
                assert offset % c.sizeof(item) == 0, f"{path}.{element}"

    check(Hli, 0, "hli")
    assert Path(layout.__file__).name == "layout.py"
