"""Response against the mass of the particle: dampers by brute force with the real solver, the absorber in closed form."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tests.studies.design.test_design import DAMPED, brute, pursued

from damperlab.studies.design.answer import answer_document
from damperlab.studies.design.build import Build
from damperlab.studies.design.found import Found
from damperlab.studies.design.front import masses_of, undominated
from damperlab.studies.specification.reading import parse_specification

GIVEN: dict[str, Any] = DAMPED | {
    "choose": {"clearance_m": {"start": 0.002, "stop": 0.012}},
    "friction_force_n": 30.0,
    "tolerances": {},
}


@pytest.fixture(scope="module")
def given() -> Found:
    return pursued(GIVEN)[0]


@pytest.mark.night
def test_about_a_mass_that_is_given_lighter_and_heavier_ones_are_looked_at(given: Found) -> None:
    assert [each.mass_kg for each in given.front] == [1.0, 2.0, 4.0, 6.0, 8.0]
    assert [each["recommended"] for each in answer_document(given)["masses"]] == [
        False,
        False,
        True,
        False,
        False,
    ]
    for each in given.front:
        document = GIVEN | {"particle_mass_kg": each.mass_kg}
        alone = brute(document, np.array([each.build.clearance_m]), np.array([30.0])).item()
        # of 101 frequencies none need be at the peak, which is as wide as ζ; what is stated is not exceeded
        assert 0.98 * each.score.value <= alone <= 1.02 * (each.score.value + each.score.error)
        # a step of a sixteenth of the range to either side, which was looked at, is no better
        ratio = 6.0 ** (1 / 16)
        beside = np.clip(each.build.clearance_m * np.array([1 / ratio, ratio]), 0.002, 0.012)
        assert float(brute(document, beside, np.array([30.0])).min()) >= 0.98 * each.score.value
    assert all(each.build.friction_force_n == 30.0 for each in given.front)


@pytest.mark.night
def test_the_tuned_mass_damper_of_every_mass_is_that_of_its_closed_form(given: Found) -> None:
    """Tuned for the band, without tolerances: the least of a grid of tunings and dampings is no less."""
    r = np.linspace(7.0 / 8.0, 9.0 / 8.0, 401)
    structure = 1 + 0.04j * r
    for each in given.front:
        mass = each.mass_kg / 40.0
        tops = []
        for tuning in np.linspace(0.8, 1.1, 121):
            for damping in np.geomspace(0.01, 0.4, 41):
                link = tuning**2 + 2j * damping * tuning * r
                ratio = structure * (link - r**2) / ((structure - r**2) * (link - r**2) - mass * r**2 * link)
                tops.append(np.abs(ratio).max())
        assert each.absorber is not None
        # steps of the grid are a 400th and a tenth; of 401 frequencies one is near enough to each peak
        assert 0.97 * min(tops) <= each.absorber / 0.001 <= 1.003 * min(tops)


@pytest.mark.night
def test_the_particle_alone_is_told_of_the_mass_it_was_looked_for(given: Found) -> None:
    told = {each.mass_kg: each.particle_alone for each in given.front}
    alone = given.alternatives["particle_alone"]
    assert told[4.0] == alone.score.value
    assert {told[each] for each in (1.0, 2.0, 6.0, 8.0)} == {None}


def test_masses_end_at_their_limit_and_lists_are_kept_to() -> None:
    build = Build(0.004, 30.0, 4.0, 0.5)
    assert masses_of(parse_specification(GIVEN | {"limits": {"particle_mass_kg": 7.0}}), build) == [
        1,
        2,
        4,
        6,
        7,
    ]
    assert masses_of(parse_specification(GIVEN | {"limits": {"particle_mass_kg": 4.0}}), build) == [1, 2, 4]
    chosen = {key: value for key, value in GIVEN.items() if key != "particle_mass_kg"}
    listed = chosen | {"choose": GIVEN["choose"] | {"particle_mass_kg": [1.0, 3.0, 4.0]}}
    assert masses_of(parse_specification(listed), build) == [1, 3, 4]
    ranged = chosen | {"choose": GIVEN["choose"] | {"particle_mass_kg": {"start": 2.0, "stop": 6.0}}}
    assert masses_of(parse_specification(ranged), replace(build, particle_mass_kg=3.5)) == [
        2,
        3,
        3.5,
        4,
        5,
        6,
    ]


@pytest.mark.night
def test_what_a_lighter_mass_does_as_well_is_not_on_the_front(given: Found) -> None:
    worse = replace(given.front[1], score=given.front[0].score)
    assert undominated((given.front[0], worse, given.front[2])) == (given.front[0], given.front[2])


@pytest.mark.night
def test_a_budget_that_ends_before_the_masses_says_which_are_left_out() -> None:
    found, _ = pursued(GIVEN, 1200)
    assert found.book.spent <= 1200
    assert len(found.front) < 5
    missing = 5 - len(found.front)
    assert f"response against mass for {missing} of 5 masses" in found.left_out
