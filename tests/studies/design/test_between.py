"""What may lie between candidates, against convex functions and against brute force."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from tests.benchmarks.design import drawn, peaks
from tests.studies.design.test_design import pursued
from tests.studies.specification.test_specification import changed

from damperlab.studies.design.answer import answer_document
from damperlab.studies.design.between import Between, dip
from damperlab.studies.design.build import Build
from damperlab.studies.design.lattice import Lattice
from damperlab.studies.design.score import Score
from damperlab.studies.specification.reading import parse_specification

LINES = st.lists(st.tuples(st.integers(-20, 20), st.integers(-5, 5)), max_size=6)


@given(lines=LINES, valley=st.integers(24, 40), x=st.sets(st.integers(1, 63), min_size=1, max_size=9))
def test_a_convex_function_dips_no_further_than_said(
    lines: list[tuple[int, int]], valley: int, x: set[int]
) -> None:
    """The largest of some lines; its least value is at an end of an interval or where two of the lines cross."""
    # two of them make a valley between the ends, which any others only lift
    both = [(-60.0, 60.0 * valley / 64), (60.0, -60.0 * valley / 64)]
    slopes, heights = np.array([*both, *lines]).T
    lines = list(zip(slopes, heights, strict=True))
    places = np.array(sorted({0, *x, 64})) / 64
    crossings = [
        (heights[j] - heights[i]) / (slopes[i] - slopes[j])
        for i in range(len(lines))
        for j in range(i)
        if slopes[i] != slopes[j]
    ]

    def largest(at: np.ndarray) -> np.ndarray:
        return (slopes[:, None] * at + heights[:, None]).max(axis=0)

    values = largest(places)
    place = int(values.argmin())
    # at the end of what is known no chord reaches inwards from outside
    assume(0 < place < places.size - 1)
    low, high = places[place - 1], places[place + 1]
    inside = np.array([places[place], *(each for each in crossings if low <= each <= high)])
    truth = values[place] - largest(inside).min()
    # a few sums of numbers up to 25
    assert dip(places, values, place) >= truth - 1e-12


def test_a_kink_between_two_samples_is_said_to_the_last_digit() -> None:
    """|x − 1/8| beside samples a quarter apart: both chords end in the kink."""
    x = np.array([-0.5, -0.25, 0.0, 0.25, 0.5])
    values = np.abs(x - 0.125)
    # into the right interval it may fall as steeply as it came, over all of its width
    assert dip(x, values, 2) == pytest.approx(0.25, rel=1e-15)


def test_a_ramp_ends_with_its_range() -> None:
    assert dip(np.array([0.5, 0.75, 1.0]), np.array([3.0, 2.0, 1.0]), 2) == 0.0


def scored(value: float) -> Score:
    return Score(value, 0.0, 0.0, 0.0, {}, 1.0, 1.0, Build(1.0, 0.0, 0.0, 0.0), None)


def test_nothing_lies_between_the_values_of_a_list() -> None:
    document = changed(
        "choose", {"restitution": [0.2, 0.5, 0.9], "clearance_m": {"start": 0.002, "stop": 0.01}}
    )
    document |= {"friction_force_n": 0.1, "limits": {}}
    del document["restitution"]
    document["tolerances"] = {}
    lattice = Lattice(parse_specification(document))
    first = lattice.first()
    between = Between(lattice)
    between.begin(first, 1 / 8)
    listed = lattice.names.index("restitution")
    # worst cases that depend on the material alone: however they differ, nothing dips
    dips = between.dips({each: scored(1.0 + each[listed]) for each in first})
    assert dips
    assert set(dips.values()) == {0.0}


@pytest.mark.parametrize("seed", [1, 3])
def test_the_best_of_brute_force_is_within_what_is_stated(seed: int) -> None:
    """Two specifications whose best damper lies at a kink, beside which a lattice ends."""
    document = drawn(seed)
    found, _ = pursued(document, 100_000)
    assert found.shortfall is not None
    stated = found.compared.most - found.shortfall
    # friction is best at the end of its range, as in brute force over both quantities
    stop = document["choose"]["friction_force_n"]["stop"]
    assert found.build.friction_force_n == stop
    clearances = found.build.clearance_m * np.linspace(0.96, 1.04, 17)
    best = float(peaks(document, clearances, np.array([stop]), 401).min())
    assert best >= stated * (1 - 1e-9)
    # and it is no empty statement
    assert found.shortfall <= 0.03 * found.compared.most
    answer = answer_document(found)
    assert answer["shortfall"] == found.shortfall
    assert any("another damper of these ranges may do better by up to" in each for each in answer["words"])
