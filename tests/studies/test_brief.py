"""A short answer stays short, and notes come with the gravest first."""

import shlex

import pytest
from hypothesis import given
from hypothesis import strategies as st

from damperlab.studies.brief import Brief, Note, command, lines_of, listed, notes_document
from damperlab.studies.spelling import spelled

WORDS = st.text("abc ", max_size=12)


@given(st.lists(WORDS, max_size=9), st.lists(st.tuples(WORDS, WORDS, WORDS), max_size=12), WORDS)
def test_a_short_answer_has_at_most_ten_lines(
    sentences: list[str], rows: list[tuple[str, str, str]], following: str
):
    brief = Brief(None, tuple(sentences), tuple(rows), following)
    assert len(lines_of(brief.document())) <= 10
    assert list(brief.sentences) == [each for each in sentences if each][:3]


def test_notes_are_sorted_by_severity_and_keep_their_order_within_one() -> None:
    notes = [
        Note("a", "hint"),
        Note("b", "danger", {"value": 1.0}),
        Note("c", "caution"),
        Note("d", "danger"),
    ]
    assert [note["kind"] for note in notes_document(notes)] == ["b", "d", "c", "a"]
    assert notes_document(notes)[0]["values"] == {"value": 1.0}


def test_the_words_of_a_list_are_joined_by_commas_and_an_and() -> None:
    assert [listed(each) for each in (["a"], ["a", "b"], ["a", "b", "c"])] == ["a", "a and b", "a, b and c"]


def test_a_command_is_one_that_a_shell_takes() -> None:
    told = command("refine", "units map; rm", "--exclude-locked")
    assert shlex.split(told) == ["damperlab", "refine", "units map; rm", "--exclude-locked"]
    assert command("run", "pump") == "damperlab run pump"
    assert command("run", "") == "damperlab run STUDY"


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [(5000.0, "N", "5000 N"), (12346.0, "N", "12350 N"), (0.0021, "m", "2.1 mm"), (2e8, "N", "2e+08 N")],
)
def test_a_quantity_has_no_exponent_that_nobody_says(value: float, unit: str, text: str) -> None:
    assert spelled(value, unit) == text
