"""The file of texts for #ERROR."""

from __future__ import annotations

from pathlib import Path

import pytest

from runtime.cnc.blocks import Source, UserError
from runtime.config.error_texts import MEANINGS, ErrorTexts, ErrorTextsError, load_error_texts
from runtime.config.loader import ConfigurationError, load_machine
from tests.config.test_loader import GOOD

S = Source("p", 1)


def test_a_file_has_a_number_and_a_text_per_line(tmp_path: Path) -> None:
    file = tmp_path / "errors.txt"
    file.write_text("; comment\n\n1 first\n  1000   gripper is open; close it  \n7\n")
    assert load_error_texts(file) == {1: "first", 1000: "gripper is open; close it", 7: ""}


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("1 a\ntext only\n", "line 2 does not begin with a number from 1 to 1000"),
        ("0 a", "line 1 does not"),
        ("1001 a", "line 1 does not"),
        ("² a", "line 1 does not"),
        ("5 a\n\n5 b", "line 3: number 5 stands twice"),
    ],
)
def test_a_mistake_is_told_at_load_time_with_its_line(tmp_path: Path, text: str, reason: str) -> None:
    (tmp_path / "errors.txt").write_text(text)
    file = tmp_path / "m.yaml"
    file.write_text(GOOD + "error_texts: errors.txt\n")
    with pytest.raises(ConfigurationError) as caught:
        load_machine(file)
    (problem,) = caught.value.problems
    assert problem.entry.id == 302090
    assert reason in problem.text
    assert problem.place.line == GOOD.count("\n") + 1


def test_a_file_that_is_missing_is_told_at_load_time(tmp_path: Path) -> None:
    file = tmp_path / "m.yaml"
    file.write_text(GOOD + "error_texts: nothing.txt\n")
    with pytest.raises(ConfigurationError, match="No such file"):
        load_machine(file)
    with pytest.raises(ErrorTextsError):
        load_error_texts(tmp_path)


@pytest.mark.spec("isg.add.error")
def test_the_values_follow_with_their_meanings() -> None:
    texts = ErrorTexts({455: "part is not in its place"})
    assert len(MEANINGS) == 22
    cases = {
        "user error 1": UserError(S, 1, 0, 0),
        "user error 1/10": UserError(S, 1, 0, 10),
        "user error 455: part is not in its place": UserError(S, 455, 0, 0),
        "user error 455: part is not in its place; limit value 2.5": UserError(S, 455, 0, 0, (2.5,)),
        "user error 9; expected value Text-A, error value Text-B": UserError(S, 9, 0, 0, ("Text-A", "Text-B"), (4, 3)),
        "user error 9; final value 4": UserError(S, 9, 0, 0, (3.0, 4.0), (0, 21)),
        "user error 9; further 1, 0.5": UserError(S, 9, 0, 0, (), (), (1.0, 0.5)),
    }
    assert {texts.describe(error) for error in cases.values()} == set(cases)
    assert all(texts.describe(error) == text for text, error in cases.items())
