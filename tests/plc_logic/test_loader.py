"""Finding the PLC program: every way in which that fails has its error, with the place in the user's file."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from runtime.plc_logic import PlcFailure
from runtime.plc_logic.loader import load_program

GOOD = "from runtime.plc_logic import Program\nclass Mill(Program):\n    pass\n"


@pytest.fixture
def machine(tmp_path: Path) -> Path:
    """The folder of a machine description."""
    return tmp_path


def failure(reference: str, directory: Path) -> PlcFailure:
    with pytest.raises(PlcFailure) as caught:
        load_program(reference, directory)
    return caught.value


def test_a_file_beside_the_description(machine: Path) -> None:
    (machine / "mill.py").write_text(GOOD)
    assert load_program("mill.py", machine).__name__ == "Mill"
    assert load_program("mill.py:Mill", machine).__name__ == "Mill"
    assert load_program(str(machine / "mill.py"), Path("/nowhere")).__name__ == "Mill"
    assert str(machine) not in sys.path


def test_a_file_may_import_its_neighbours_and_use_dataclasses(machine: Path) -> None:
    (machine / "neighbour_of_the_mill.py").write_text("PLACES = 8\n")
    (machine / "mill.py").write_text(
        "from dataclasses import dataclass\nfrom neighbour_of_the_mill import PLACES\n"
        "@dataclass\nclass Tool:\n    number: 'int' = PLACES\n" + GOOD
    )
    assert load_program("mill.py", machine).__name__ == "Mill"


def test_a_changed_file_is_read_again(machine: Path) -> None:
    (machine / "mill.py").write_text(GOOD)
    load_program("mill.py", machine)
    (machine / "mill.py").write_text(GOOD.replace("Mill", "Lathe"))
    assert load_program("mill.py", machine).__name__ == "Lathe"


def test_a_module_and_an_imported_program(machine: Path) -> None:
    assert load_program("runtime.demo.plc:DemoMill", machine).__name__ == "DemoMill"
    assert load_program("runtime.demo.plc", machine).__name__ == "DemoMill"
    (machine / "again.py").write_text("from runtime.demo.plc import DemoMill\n")
    assert load_program("again.py", machine).__name__ == "DemoMill"


def test_of_a_family_the_last_descendant_is_the_program(machine: Path) -> None:
    (machine / "mill.py").write_text(GOOD + "class Big(Mill):\n    pass\n")
    assert load_program("mill.py", machine).__name__ == "Big"


@pytest.mark.parametrize(
    ("reference", "text", "error", "says"),
    [
        ("missing.py", None, 304020, "there is no file"),
        ("no.such.module", None, 304020, "there is no module no"),
        ("runtime.demo.nothing", None, 304020, "there is no module runtime.demo.nothing"),
        ("mill.py:Nobody", GOOD, 304020, "no program class Nobody; known: Mill"),
        ("mill.py:Program", GOOD, 304020, "no program class Program"),
        ("", None, 304024, ""),
        ("mill.py", "class Mill(\n", 304021, "line 1"),
        ("mill.py", b"\x00\x01\x02\xff", 304021, ""),
        ("mill.py", b'x = "\xff\xfe"\n', 304021, ""),
        ("mill.py", "", 304022, "no subclass of Program"),
        ("mill.py", "from runtime.plc_logic import Program\n", 304022, ""),
        ("mill.py", GOOD + "class Lathe(Program):\n    pass\n", 304023, "Lathe, Mill"),
        ("mill.py", "x = 1\ny = x / 0\n" + GOOD, 304024, "division by zero (mill.py:2"),
        ("mill.py", "import no_such_neighbour\n", 304024, "no_such_neighbour"),
        ("mill.py", "raise SystemExit(0)\n", 304024, "SystemExit"),
        (
            "mill.py",
            "from runtime.plc_logic import Program, m_function\nclass Mill(Program):\n"
            "    @m_function(6, 7)\n    def a(self, f): return True\n"
            "    @m_function(7)\n    def b(self, f): return True\n",
            304028,
            "a and b both handle M7",
        ),
    ],
)
def test_failures(machine: Path, reference: str, text: str | bytes | None, error: int, says: str) -> None:
    if text is not None:
        (machine / "mill.py").write_bytes(text if isinstance(text, bytes) else text.encode())
    caught = failure(reference, machine)
    assert caught.problem.entry.id == error
    assert says in caught.problem.text
    assert caught.problem.explained()  # every value that text and remedy need is there


def test_a_syntax_error_has_its_line_and_column(machine: Path) -> None:
    (machine / "mill.py").write_text("from runtime.plc_logic import Program\n\ndef broken(:\n    pass\n")
    caught = failure("mill.py", machine)
    assert caught.problem.place.file == str(machine / "mill.py")
    assert (caught.problem.place.line, caught.problem.place.text) == (3, "def broken(:")
    assert caught.problem.place.column == 12


def test_the_traceback_shows_the_users_frames_only(machine: Path) -> None:
    (machine / "mill.py").write_text("def outer():\n    return inner()\ndef inner():\n    return [][1]\nouter()\n")
    trace = failure("mill.py", machine).trace
    assert "in outer" in trace
    assert "return [][1]" in trace
    assert "IndexError" in trace
    assert "loader.py" not in trace
