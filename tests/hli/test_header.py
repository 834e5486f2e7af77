"""The C header compiles, its asserts hold, and a C program reads a running HLI with it."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from runtime.hli.header import c_header
from runtime.hli.memory import HliMemory, layout_hash, put_text

C_PROGRAM = r"""
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>
#include "tandem_hli.h"

int main(int argc, char **argv) {
    int fd = shm_open(argv[1], O_RDWR, 0);
    if (fd < 0) return 2;
    tandem_hli *hli = mmap(NULL, sizeof *hli, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    if (hli == MAP_FAILED) return 3;
    if (hli->head.magic_r != TANDEM_HLI_MAGIC) return 4;
    if (strcmp(hli->head.layout_hash_r, TANDEM_HLI_LAYOUT_HASH) != 0) return 5;
    printf("%s %d %lld %.1f\n", hli->axes[2].name_r, (int)hli->channels[0].control.mode_and_state.state_r,
           (long long)hli->axes[2].status.actual_position_r, hli->channels[0].status.path_position_r);
    tandem_technology_unit *unit = &hli->channels[0].techno_unit_std_sync[0];
    if (unit->please_rw) {
        unit->please_rw = false;
        printf("M%d\n", (int)unit->number_r);
        unit->done_w = true;
    }
    return 0;
}
"""


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no C compiler")
@pytest.mark.spec("hli.mech.shared-memory", "hli.tech.unit")
def test_a_c_program_attaches_and_takes_a_function(shared: HliMemory, tmp_path: Path) -> None:
    (tmp_path / "tandem_hli.h").write_text(c_header())
    (tmp_path / "main.c").write_text(C_PROGRAM)
    program = tmp_path / "main"
    subprocess.run(
        [
            "gcc",
            "-std=gnu11",
            "-Wall",
            "-Wextra",
            "-Wno-unused-parameter",
            "-Werror",
            "-o",
            program,
            tmp_path / "main.c",
        ],
        check=True,
    )
    hli = shared.hli
    put_text(hli.axes[2], "name_r", "Z")
    hli.axes[2].status.actual_position_r = -(2**40)
    hli.channels[0].status.path_position_r = 2.5
    unit = hli.channels[0].techno_unit_std_sync[0]
    unit.number_r = 20
    unit.please_rw = True
    done = subprocess.run([program, f"/{shared.name}"], capture_output=True, text=True, check=True)
    assert done.stdout == f"Z 2 {-(2**40)} 2.5\nM20\n"
    assert (unit.please_rw, unit.done_w) == (False, True)

    hli.head.layout_hash_r = b"0" * 64
    assert subprocess.run([program, f"/{shared.name}"], check=False).returncode == 5


def test_a_wrong_offset_does_not_compile(tmp_path: Path) -> None:
    if shutil.which("gcc") is None:
        pytest.skip("no C compiler")
    header = c_header().replace("uint32_t owner_pid_r;", "uint64_t owner_pid_r;")
    (tmp_path / "wrong.c").write_text(header)
    done = subprocess.run(["gcc", "-fsyntax-only", tmp_path / "wrong.c"], capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "offset of tandem_head.axes_r" in done.stderr


def test_the_header_carries_hash_enums_and_every_structure() -> None:
    text = c_header()
    assert layout_hash() in text
    assert "TANDEM_STATE_ACTIVE = 0x4" in text
    for name in ("tandem_head", "tandem_channel", "tandem_axis", "tandem_hli", "tandem_technology_unit"):
        assert f"}} {name};" in text
