"""What is left of a budget, divided: who needs little gets it, and nothing is left that somebody needs."""

from collections.abc import Iterable
from typing import Any, NamedTuple
from uuid import uuid4

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.studies.design.test_design import DAMPED, pursued

from damperlab.studies.design.answer import answer_document
from damperlab.studies.design.book import Book, Wanted
from damperlab.studies.design.steps import Part, Step, share_out
from damperlab.studies.specification.reading import parse_specification


class Counting(NamedTuple):
    """A study of so many points that nobody computes."""

    digest: str
    points: int


class Counted(Book):
    """A book whose studies are not computed: what is wanted is taken for known."""

    def studies(self, wanted: Iterable[Wanted]) -> Any:
        return (Counting(uuid4().hex, len(list(wanted))),)


def drive(step: Step[list[str]], book: Book) -> list[str]:
    try:
        asked = next(step)
        while True:
            points = sum(study.points for study in asked)  # type: ignore[union-attr]
            assert points <= book.left
            book.spent += points
            asked = step.send(points)
    except StopIteration as end:
        return list(end.value)


def needing(points: int, had: dict[int, int], name: int) -> Part:
    """Need so many points, in five looks; what was had before is known."""

    def part(most: int) -> Step[bool]:
        while had[name] < points:
            look = min(max(points // 5, 1), points - had[name])
            assert (yield [None] * look) == look  # type: ignore[list-item]
            had[name] += look
        return True

    return part


@given(st.lists(st.integers(0, 400), min_size=1, max_size=6), st.integers(0, 1500))
def test_who_needs_no_more_than_an_equal_share_gets_it_and_nothing_is_left_that_fits(
    needs: list[int], budget: int
) -> None:
    book = Counted(parse_specification(DAMPED), budget)
    had = dict.fromkeys(range(len(needs)), 0)
    parts = {str(name): needing(need, had, name) for name, need in enumerate(needs)}
    left_out = drive(share_out(book, parts), book)
    assert book.spent == sum(had.values()) <= budget
    for name, need in enumerate(needs):
        assert (str(name) in left_out) == (had[name] < need)
        if need <= budget // len(needs):
            assert had[name] == need
        else:  # cut short only where its next look does not fit any more
            assert had[name] == need or book.left < max(need // 5, 1)


@pytest.mark.parametrize(
    ("budget", "closely"), [(1500, False), pytest.param(20_000, True, marks=pytest.mark.night)]
)
def test_friction_alone_that_is_given_is_one_damper_and_is_said(budget: int, closely: bool) -> None:
    document = DAMPED | {"choose": {"clearance_m": {"start": 0.002, "stop": 0.012}}, "friction_force_n": 30.0}
    found, _ = pursued(document, budget, front=closely)
    assert found.book.spent <= budget
    answer = answer_document(found)
    assert answer["friction_alone"]["design"]["friction_force_n"] == 30.0
    # a small budget knows it with its tolerances, a larger one as closely as can be
    assert "the best of friction alone" not in found.left_out
    assert found.alternatives["friction_alone"].complete == closely
    assert ("the rest of the search for the best of friction alone" in found.left_out) != closely
    assert sum(row[0] == "friction alone" for row in answer["verdict"]["rows"]) == 1
