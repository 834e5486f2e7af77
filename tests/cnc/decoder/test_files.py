"""Files of programs: #MSG SAVE, #FILE RENAME, DELETE, EXIST. Nothing outside the folders of the channel is ever touched."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from runtime.cnc.decoder import ChannelMemory, Decoder, DecoderSetup, Offline, Outside, ProgramError, load_program
from runtime.cnc.decoder.report_file import Backups
from runtime.diagnostics.catalogue import language as C  # noqa: N812 - a table of constants
from runtime.diagnostics.errors import Problem
from tests.cnc.decoder.programs import SETUP
from tests.cnc.decoder.scripted_outside import Machine

STAMP = "26.11.2026 14:08:10:123"


class Place:
    """A folder of programs, one of subprograms and one of reports, and something outside of them all."""

    def __init__(self, folder: Path) -> None:
        self.programs = folder / "programs"
        self.sub = self.programs / "sub"
        self.reports = folder / "reports"
        self.outside = folder / "outside"
        for made in (self.sub, self.reports, self.outside):
            made.mkdir(parents=True)
        (self.outside / "secret.txt").write_text("secret")
        self.setup: DecoderSetup = replace(SETUP, program_paths=(Path("sub"),), message_paths=(self.reports,))
        self.memory = ChannelMemory(self.setup)
        self.numbers: dict[int, float] = {}
        self.texts: dict[str, float | str] = {}

    def run(
        self, program: str, outside: Outside | None = None, name: str = "", backups: Backups | None = None
    ) -> Problem | None:
        """Execute a program; its error."""
        path = self.programs / "main.nc"
        path.write_text(program)
        opened = None
        try:
            opened = load_program(path, self.setup)
            decoder = Decoder(
                opened,
                self.setup,
                start=np.zeros(3),
                memory=self.memory,
                outside=outside or Machine(),
                idle_limit=10_000,
            )
            if name:
                decoder.execution.file_names["MSG"] = name
            if backups is not None:
                decoder.execution.report_backups = backups
            list(decoder.blocks())
            self.numbers, self.texts = decoder.parameters, dict(decoder.execution.program_scope.scalars)
        except ProgramError as error:
            return error.problem
        finally:
            if opened is not None:
                opened.close()
        return None

    def entry(self, program: str) -> object:
        problem = self.run(program)
        return problem and problem.entry


@pytest.fixture
def place(tmp_path: Path) -> Place:
    return Place(tmp_path)


# -- #MSG SAVE -----------------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.add.msg-save")
def test_reports_are_written_behind_what_is_there(place: Place) -> None:
    report = place.reports / "message.txt"
    report.write_text("old\n")
    program = (
        'P1 = 12345\n#MSG SAVE ["Hello World %d", P1]\n#MSG SAVE EXCLUSIVE ["no stamp"]\n#MSG SAVE CONTINUE ["goes "]\n'
        '#MSG SAVE EXCLUSIVE CONTINUE ["on %f"  , 1.5]\n#MSG SAVE EXCLUSIVE ["!"]'
    )
    assert place.run(program) is None
    assert report.read_text() == (f"old\n{STAMP} Hello World 12345\nno stamp\n{STAMP} goes on 1.5000000000E+000!\n")


@pytest.mark.spec("isg.add.msg-save")
@pytest.mark.parametrize("words", ["SYN", "HMI", "EXCLUSIVE SYN"])
def test_reports_take_no_mode_and_no_receiver(place: Place, words: str) -> None:
    assert place.entry(f'#MSG SAVE {words} ["a"]') is C.WORD_UNKNOWN
    assert list(place.reports.iterdir()) == []


def test_without_a_folder_of_reports_they_go_beside_the_program(place: Place) -> None:
    place.setup = replace(place.setup, message_paths=())
    assert place.run('#MSG SAVE EXCLUSIVE ["a"]') is None
    assert (place.programs / "message.txt").read_text() == "a\n"


def test_a_check_writes_nothing(place: Place) -> None:
    (place.programs / "a.txt").write_text("a")
    program = '#MSG SAVE ["a"]\n#FILE RENAME [PATHOLD="a.txt" PATHNEW="b.txt" OVRMODE=0]\n#FILE DELETE [PATH="a.txt"]'
    assert place.run(program, Offline()) is None
    assert list(place.reports.iterdir()) == []
    assert (place.programs / "a.txt").read_text() == "a"


@pytest.mark.parametrize(
    "name", ["../outside/new.txt", "/tmp/tandem-new.txt", "../programs/main.nc", "C:\\new.txt", "link/x"]
)
def test_reports_stay_in_their_folder(place: Place, name: str) -> None:
    (place.reports / "link").symlink_to(place.outside)
    problem = place.run('#MSG SAVE ["a"]', name=name)
    assert problem is not None
    assert problem.entry in (C.FILE_OUTSIDE, C.FILE_IN_USE)
    assert [path.name for path in place.outside.iterdir()] == ["secret.txt"]


def test_a_link_in_place_of_the_report_file_is_not_followed_outside(place: Place) -> None:
    (place.reports / "message.txt").symlink_to(place.outside / "secret.txt")
    assert place.entry('#MSG SAVE ["a"]') is C.FILE_OUTSIDE
    assert (place.outside / "secret.txt").read_text() == "secret"


def test_a_report_file_that_cannot_be_written(place: Place) -> None:
    (place.reports / "message.txt").mkdir()
    assert place.entry('#MSG SAVE ["a"]') is C.FILE_REFUSED


def test_backups_are_made_after_so_many_writes_and_the_oldest_goes(place: Place) -> None:
    backups = Backups(lines=2, count=2)
    program = "\n".join(f'#MSG SAVE EXCLUSIVE ["{n}"]' for n in range(1, 8))
    assert place.run(program, name="test.log", backups=backups) is None
    assert {path.name: path.read_text() for path in place.reports.iterdir()} == {
        "test.log": "7\n",
        "test1.bak": "5\n6\n",
        "test2.bak": "3\n4\n",
    }
    # lines and number of the last backup are kept until the control is started again
    assert place.run('#MSG SAVE EXCLUSIVE ["8"]\n#MSG SAVE EXCLUSIVE ["9"]', name="test.log", backups=backups) is None
    assert (place.reports / "test2.bak").read_text() == "7\n8\n"
    assert (place.reports / "test.log").read_text() == "9\n"
    # another file begins anew
    three = "\n".join(f'#MSG SAVE EXCLUSIVE ["{n}"]' for n in range(3))
    assert place.run(three, name="other.log", backups=backups) is None
    assert (place.reports / "other1.bak").read_text() == "0\n1\n"


@pytest.mark.spec("isg.add.file-backup")
def test_backups_are_asked_for_by_file_name(place: Place) -> None:
    writes = "\n".join(f'#MSG SAVE EXCLUSIVE ["{n}"]' for n in range(1, 6))
    limits = "BACKUP_LINES_MAX=2 BACKUP_COUNT_MAX=2"
    assert place.run(f'#FILE NAME [MSG="test.log" {limits}]\n{writes}') is None
    assert (place.reports / "test2.bak").read_text() == "3\n4\n"
    assert (place.reports / "test.log").read_text() == "5\n"
    # off at program start, with a zero, and where a file is named without them
    assert place.run(f'#FILE NAME [MSG="test.log"]\n{writes}') is None
    assert (place.reports / "test.log").read_text() == "5\n1\n2\n3\n4\n5\n"
    off = f'#FILE NAME [MSG="b.log" {limits}]\n#FILE NAME [BACKUP_LINES_MAX=0]\n{writes}'
    assert place.run(off) is None
    assert not (place.reports / "b1.bak").exists()
    assert place.entry("#FILE NAME [BACKUP_LINES_MAX=-1 BACKUP_COUNT_MAX=2]") is C.BACKUP_COUNT


# -- #FILE EXIST ---------------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.add.file-exist")
def test_files_are_looked_for_in_programs_subprograms_and_reports(place: Place) -> None:
    for folder, name in (
        (place.programs, "a"),
        (place.sub, "a"),
        (place.sub, "b"),
        (place.reports, "b"),
        (place.reports, "c"),
    ):
        (folder / name).write_text("")
    for name, folder in (("a", place.programs), ("b", place.sub), ("c", place.reports), ("sub/b", place.sub)):
        program = f'#FILE EXIST [PATH="{name}"]\nP1=V.G.FILE_EXIST V.P.N=V.G.FILE_EXIST_PATH_NAME V.P.D=V.G.FILE_EXIST_DIRECTORY'
        assert place.run(program) is None
        assert place.numbers == {1: 1}
        assert place.texts == {"N": str(folder / Path(name).name), "D": f"{folder}/"}


@pytest.mark.spec("isg.add.file-exist")
def test_the_answer_is_kept_until_the_next_question(place: Place) -> None:
    (place.programs / "a").write_text("")
    program = (
        'P1=V.G.FILE_EXIST\nV.P.F = "a"\n#FILE EXIST [PATH V.P.F]\nP2=V.G.FILE_EXIST P3=V.G.FILE_EXIST\n'
        '#FILE EXIST [PATH="nowhere"]\nP4=V.G.FILE_EXIST P5=LEN[V.G.FILE_EXIST_PATH_NAME]\n'
        '#FILE EXIST [PATH="sub"]\nP6=V.G.FILE_EXIST'
    )
    assert place.run(program) is None
    assert [place.numbers[n] for n in range(1, 7)] == [0, 1, 1, 0, 0, 0]


# -- #FILE DELETE and RENAME ---------------------------------------------------------------------------------------


@pytest.mark.spec("isg.add.file-delete")
def test_files_are_deleted(place: Place) -> None:
    (place.programs / "a.txt").write_text("")
    (place.sub / "a.txt").write_text("")
    assert place.run('#FILE DELETE [PATH="a.txt"]') is None
    assert not (place.programs / "a.txt").exists()
    assert place.run(f'#FILE DELETE [PATH="{place.sub / "a.txt"}"]') is None
    assert not (place.sub / "a.txt").exists()
    assert place.entry('#FILE DELETE [PATH="a.txt"]') is C.FILE_NOT_FOUND
    assert place.entry("#FILE DELETE []") is C.KEY_MISSING


@pytest.mark.spec("isg.add.file-delete")
@pytest.mark.spec("isg.add.file-rename")
def test_protected_files_stay(place: Place) -> None:
    (place.programs / "a.txt").write_text("a")
    (place.programs / "a.txt").chmod(0o444)
    (place.programs / "b.txt").write_text("b")
    assert place.entry('#FILE DELETE [PATH="a.txt"]') is C.FILE_PROTECTED
    assert place.entry('#FILE RENAME [PATHOLD="a.txt" PATHNEW="c.txt" OVRMODE=1]') is C.FILE_PROTECTED
    assert place.entry('#FILE RENAME [PATHOLD="b.txt" PATHNEW="a.txt" OVRMODE=1]') is C.FILE_PROTECTED
    assert sorted(path.name for path in place.programs.glob("*.txt")) == ["a.txt", "b.txt"]
    assert C.FILE_PROTECTED.id == 21627


@pytest.mark.spec("isg.add.file-rename")
def test_files_are_renamed_and_moved(place: Place) -> None:
    (place.sub / "old").write_text("1")
    assert place.run('#FILE RENAME [PATHOLD="old" PATHNEW = "new" OVRMODE=0]') is None
    assert (place.sub / "new").read_text() == "1"  # beside the old one
    assert place.run(f'#FILE RENAME [PATHOLD "new" PATHNEW "{place.reports / "moved"}" OVRMODE 0]') is None
    assert (place.reports / "moved").read_text() == "1"
    assert not (place.sub / "new").exists()


@pytest.mark.spec("isg.add.file-rename")
def test_an_existing_file_is_overwritten_only_if_asked_to(place: Place) -> None:
    (place.programs / "a").write_text("a")
    (place.programs / "b").write_text("b")
    assert place.entry('#FILE RENAME [PATHOLD="a" PATHNEW="b" OVRMODE=0]') is C.FILE_THERE
    assert (place.programs / "b").read_text() == "b"
    assert place.run('#FILE RENAME [PATHOLD="a" PATHNEW="b" OVRMODE=1]') is None
    assert (place.programs / "b").read_text() == "a"


@pytest.mark.spec("isg.add.file-rename")
@pytest.mark.parametrize(
    ("keys", "entry"),
    [
        ('PATHOLD="a" PATHNEW="b"', C.KEY_MISSING),
        ('PATHOLD="a" OVRMODE=1', C.KEY_MISSING),
        ('PATHNEW="a" OVRMODE=1', C.KEY_MISSING),
        ('PATHOLD="nowhere" PATHNEW="b" OVRMODE=1', C.FILE_NOT_FOUND),
        ('PATHOLD="a" PATHNEW="none/b" OVRMODE=1', C.FILE_TARGET_FOLDER),
        ('PATHOLD="a" PATHNEW="sub" OVRMODE=1', C.FILE_NAME_INVALID),
        ('PATHOLD="a" PATHNEW="b" OVRMODE=2', C.OVERWRITE_MODE),
        ('PATHOLD="main.nc" PATHNEW="b" OVRMODE=1', C.FILE_IN_USE),
        ('PATHOLD="a" PATHNEW="main.nc" OVRMODE=1', C.FILE_IN_USE),
        ('PATHOLD="" PATHNEW="b" OVRMODE=1', C.FILE_NAME_INVALID),
    ],
)
def test_what_renaming_refuses(place: Place, keys: str, entry: object) -> None:
    (place.programs / "a").write_text("a")
    assert place.entry(f"#FILE RENAME [{keys}]") is entry
    assert (place.programs / "a").read_text() == "a"


OUTSIDE = ("../outside/secret.txt", "{outside}/secret.txt", "link", "sub/../../outside/secret.txt", "folder/secret.txt")


@pytest.mark.parametrize("name", OUTSIDE)
@pytest.mark.parametrize(
    "statement",
    [
        '#FILE DELETE [PATH="{}"]',
        '#FILE EXIST [PATH="{}"]',
        '#FILE RENAME [PATHOLD="{}" PATHNEW="b" OVRMODE=1]',
        '#FILE RENAME [PATHOLD="a" PATHNEW="{}" OVRMODE=1]',
    ],
)
def test_nothing_outside_the_folders_of_the_channel_is_reached(place: Place, name: str, statement: str) -> None:
    (place.programs / "a").write_text("a")
    (place.programs / "link").symlink_to(place.outside / "secret.txt")
    (place.programs / "folder").symlink_to(place.outside)
    assert place.entry(statement.format(name.format(outside=place.outside))) is C.FILE_OUTSIDE
    assert (place.outside / "secret.txt").read_text() == "secret"
    assert [path.name for path in place.outside.iterdir()] == ["secret.txt"]
    assert (place.programs / "a").read_text() == "a"


def test_a_folder_that_refuses_changes(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(self: Path, target: Path) -> Path:
        raise PermissionError(13, os.strerror(13))

    (place.programs / "a").write_text("a")
    monkeypatch.setattr(Path, "replace", refuse)
    assert place.entry('#FILE RENAME [PATHOLD="a" PATHNEW="b" OVRMODE=0]') is C.FILE_REFUSED


# -- programs that are called ---------------------------------------------------------------------------------------


@pytest.fixture
def near() -> Iterator[Place]:
    """A place whose names are short enough for a program to name absolutely."""
    with tempfile.TemporaryDirectory(prefix="t") as name:
        yield Place(Path(name))


@pytest.mark.parametrize("name", [*OUTSIDE, "../outside/nothing.nc", "{outside}/nothing.nc", "/dev/zero", "sub/loop"])
@pytest.mark.parametrize("call", ["L {}", '#FILE NAME [M6="{}"]\nM6', '"A" = "{}"\nL "A"'])
def test_no_program_outside_the_folders_of_the_channel_is_called(near: Place, name: str, call: str) -> None:
    """Not even whether it is there is told, and none of its text."""
    (near.programs / "link").symlink_to(near.outside / "secret.txt")
    (near.programs / "folder").symlink_to(near.outside)
    (near.sub / "loop").symlink_to("loop")
    problem = near.run(f"G90\n{call.format(name.format(outside=near.outside))}\nM30")
    assert problem is not None
    assert problem.entry is (C.GLOBAL_MISSING if name == "sub/loop" else C.FILE_OUTSIDE)
    assert "secret" not in problem.text.replace("secret.txt", "").replace(str(near.outside), "")


@pytest.mark.parametrize(
    ("name", "entry"),
    [
        ("a" * 84, C.GLOBAL_MISSING),
        ("a" * 300, C.GLOBAL_MISSING),
        ("a" * 30_000, C.BLOCK_TOO_LONG),
        ("a\0b", C.FILE_BINARY),
        ("sub", C.GLOBAL_MISSING),
    ],
)
def test_names_that_no_program_can_have(near: Place, name: str, entry: object) -> None:
    assert near.entry(f"L {name}\nM30") is entry


def test_programs_inside_are_called_by_any_name(near: Place) -> None:
    (near.sub / "deep").mkdir()
    (near.sub / "deep" / "a.nc").write_text("P1 = P1 + 1\nM17")
    (near.programs / "inside").symlink_to(near.sub / "deep" / "a.nc")
    names = ("deep/a.nc", "sub/deep/a.nc", "sub/../sub/deep/a.nc", "inside", str(near.sub / "deep" / "a.nc"))
    assert near.run("P1 = 0\n" + "\n".join(f"L {name}" for name in names) + "\nM30") is None
    assert near.numbers == {1: len(names)}


def test_the_configuration_names_programs_anywhere(near: Place) -> None:
    change = near.outside / "change.nc"
    change.write_text("P1 = P1 + 1\nM17")
    near.setup = replace(near.setup, tool_change_program=str(change))
    assert near.run("P1 = 0\nM6\nM30") is None
    assert near.numbers == {1: 1}
    assert near.entry(f"L {near.outside}/secret.txt\nM30") is C.FILE_OUTSIDE
