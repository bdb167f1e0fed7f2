"""What is said to have ended a search is what ended it."""

from typing import Any

import pytest
from tests.studies.design.test_contenders import driven
from tests.studies.design.test_design import DAMPED

from damperlab.studies.design.book import Book
from damperlab.studies.design.ended import Ended, ended_of
from damperlab.studies.design.known import words_of_ended
from damperlab.studies.design.search import Search
from damperlab.studies.specification.reading import parse_specification

FRICTION: dict[str, Any] = DAMPED | {
    "choose": {"friction_force_n": {"start": 20.0, "stop": 60.0}},
    "clearance_m": 0.004,
}


@pytest.mark.parametrize(
    ("changed", "budget", "criterion", "step"),
    [
        # of friction alone every response repeats
        ({"particle_mass_kg": 0.0, "tolerances": {}}, 20_000, "finest", 1 / 64),
        # ± 4 N at the middle of 40 N: a step of a sixteenth of the range is 2.5 N
        ({"tolerances": {"friction_force_n": "10%"}}, 20_000, "tolerances", 1 / 16),
        ({"tolerances": {}}, 700, "budget", None),
    ],
)
def test_the_criterion_is_the_one_that_held(
    changed: dict[str, Any], budget: int, criterion: str, step: float | None
) -> None:
    asked = parse_specification(FRICTION | changed)
    search = Search(asked, Book(asked, budget))
    driven(search.run(), search.book)
    ended = ended_of(search)
    assert ended.criterion == criterion
    assert ended.step == search.step
    assert step is None or ended.step == step
    assert (ended.criterion == "budget") == bool(search.stopped)


@pytest.mark.parametrize("criterion", ["budget", "tolerances", "finest", "noise", "nothing"])
def test_every_criterion_has_a_sentence_and_none_calls_the_search_complete(criterion: str) -> None:
    told = words_of_ended(Ended(criterion, 1 / 32, 0), 12_345, 40_000)
    assert len(told) == 1
    assert told[0].startswith("12,345 points were computed")
    assert "complete" not in told[0]
    assert ("40,000" in told[0]) == (criterion == "budget")
    left = words_of_ended(Ended(criterion, 1 / 32, 2), 12_345, 40_000)[1]
    assert left.startswith("The budget ended before 2 further dampers")


def test_one_point_is_one() -> None:
    assert words_of_ended(Ended("nothing", 0.5, 0), 1, 100)[0].startswith("1 point was computed.")
