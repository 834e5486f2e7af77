"""Where compiled kernels are kept."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from runtime import kernel_cache
from runtime.kernel_cache import KernelCache, find_cache, fingerprint, places


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A small package with a kernel, its constants, and a module that has nothing to do with it."""
    folder = tmp_path / "runtime"
    (folder / "sub").mkdir(parents=True)
    (folder / "kernel.py").write_text(
        "from runtime.sub.numbers import (\n    LIMIT,\n    other,\n)\n\n@kernel\ndef f(): ...\n"
    )
    (folder / "sub" / "numbers.py").write_text("LIMIT = 3\n")
    (folder / "unrelated.py").write_text("import os\n")
    return folder


@pytest.mark.parametrize(("file", "changes"), [("kernel.py", True), ("sub/numbers.py", True), ("unrelated.py", False)])
def test_the_fingerprint_follows_kernels_and_their_constants(package: Path, file: str, changes: bool) -> None:
    before = fingerprint(package)
    assert fingerprint(package) == before
    with (package / file).open("a") as source:
        source.write("# changed\n")
    assert (fingerprint(package) != before) is changes


def test_the_places_in_their_order(package: Path) -> None:
    environment = {"HOME": "/home/me", "NUMBA_CACHE_DIR": "/var/cache/tandem"}
    beside = package / "__pycache__"
    assert places(environment, package) == [Path("/var/cache/tandem"), beside, Path("/home/me/.cache/tandem")]
    assert places({"HOME": "/home/me", "XDG_CACHE_HOME": "/x"}, package) == [beside, Path("/x/tandem")]
    assert places({}, package) == [beside]


def test_the_first_place_that_can_be_written_is_taken(package: Path, tmp_path: Path) -> None:
    (package / "__pycache__").write_text("a file, no folder: nothing can be kept there, whoever asks")
    cache = find_cache({"HOME": str(tmp_path)}, package)
    assert cache.lasting
    assert cache.folder == tmp_path / ".cache/tandem" / f"kernels-{fingerprint(package)}"


def test_without_any_place_the_folder_is_temporary_private_and_shared_with_children(
    package: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", "")
    (package / "__pycache__").write_text("")
    cache = find_cache({}, package)
    assert not cache.lasting
    assert cache.refused == (package / "__pycache__",)
    base = Path(os.environ["NUMBA_CACHE_DIR"])
    assert cache.folder.is_relative_to(base)
    assert stat.S_IMODE(base.stat().st_mode) == 0o700
    assert find_cache(os.environ, package).folder == cache.folder


def test_a_folder_is_warm_after_it_has_been_filled_once(tmp_path: Path) -> None:
    cache = KernelCache(tmp_path)
    with pytest.raises(ZeroDivisionError), cache.filling(everything=True):
        raise ZeroDivisionError
    assert not cache.warm
    with cache.filling(everything=True):
        assert not cache.warm
    assert cache.warm


def test_what_only_some_kernels_were_compiled_into_is_not_complete(tmp_path: Path) -> None:
    cache = KernelCache(tmp_path)
    with cache.filling(everything=False):
        pass
    assert not cache.warm


def test_a_first_start_compiles_every_kernel_and_a_machine_that_finds_them_loads_no_compiler() -> None:
    """In processes of their own: this one has imported whatever other tests need."""
    package = kernel_cache.PACKAGE
    with_kernels = {
        ".".join(("runtime", *path.relative_to(package).with_suffix("").parts))
        for path in package.rglob("*.py")
        if b"\n@warms(" in path.read_bytes()
    }
    assert len(with_kernels) > 20
    assert with_kernels <= _imported_with("runtime.scheduler.all_kernels")
    service = _imported_with("runtime.cli.run, runtime.cli.preparing, runtime.scheduler.session")
    assert service.isdisjoint(
        {"numba", "lark", "can", "canopen", "ruckig", "matplotlib", "multiprocessing", *with_kernels}
    )


def _imported_with(modules: str) -> set[str]:
    code = f"import sys, {modules}; print(*sys.modules)"
    return set(subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout.split())


def test_old_folders_are_removed_but_a_few(tmp_path: Path) -> None:
    for i in range(10):
        (tmp_path / f"kernels-{i}").mkdir()
        os.utime(tmp_path / f"kernels-{i}", (i, i))
    with KernelCache(tmp_path / "kernels-0").filling(everything=True):
        pass
    assert {path.name for path in tmp_path.iterdir()} == {f"kernels-{i}" for i in (0, 6, 7, 8, 9)}


def test_another_process_waits_until_the_first_has_compiled(tmp_path: Path) -> None:
    """The lock is the file system's: here the second one is told at once that it is taken."""
    code = "import fcntl, sys; fcntl.flock(open(sys.argv[1], 'w'), fcntl.LOCK_EX | fcntl.LOCK_NB)"
    command = [sys.executable, "-c", code, str(tmp_path / "lock")]
    with KernelCache(tmp_path).filling(everything=True):
        assert subprocess.run(command, check=False, capture_output=True).returncode != 0
    assert subprocess.run(command, check=False).returncode == 0


def test_the_kernels_of_the_product_are_in_the_fingerprint() -> None:
    sources = {
        path.relative_to(kernel_cache.PACKAGE).as_posix() for path in kernel_cache._sources(kernel_cache.PACKAGE)
    }
    assert {"cnc/interpolator/cycle.py", "cnc/language/isg/scan.py", "cnc/motion_queue.py"} <= sources


@pytest.mark.skipif(bool(os.environ.get("NUMBA_DISABLE_JIT")), reason="nothing is compiled")
def test_a_second_process_loads_what_the_first_has_compiled(tmp_path: Path) -> None:
    script = (
        "import runtime.cnc.axes.supervision as s\n"
        "from runtime.kernels import warm_up\n"
        "warm_up()\n"
        "print(sum(s._supervise.stats.cache_hits.values()), sum(s._supervise.stats.cache_misses.values()))\n"
    )
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    counts = [
        subprocess.run(
            [sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True
        ).stdout
        for _ in range(2)
    ]
    assert counts == ["0 1\n", "1 0\n"]
