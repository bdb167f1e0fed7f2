"""A ranking says at which friction of its particle the best damper keeps its value, as that damper computed on its own
says.
"""

import json
from typing import Any

import pytest
import xarray as xr
from tests.studies.solving import LEAN, solved

from damperlab.studies.amplitudes import AMPLITUDE
from damperlab.studies.answers.leading import leading
from damperlab.studies.answers.particle_friction import COEFFICIENTS, find_friction
from damperlab.studies.answers.query_fault import QueryFault
from damperlab.studies.answers.ranking import ranked_designs
from damperlab.studies.definition import Study, parse_study
from damperlab.studies.questions import Judging, Ranking
from damperlab.studies.units import with_units

STRUCTURE = {"mass_kg": 250, "natural_frequency_hz": 7.6, "particle_mass_kg": 20}
ONE: dict[str, Any] = {
    "name": "floor",
    "damping_ratio": 0.02,
    "metrics": LEAN,
    "physical": STRUCTURE
    | {"base_amplitude_m": 0.001, "clearance_m": [0.003, 0.004, 0.005], "friction_force_n": 300},
    "axes": {"restitution": 0.5, "frequency_ratio": [0.95, 0.97, 0.99]},
}
SEVERAL: dict[str, Any] = ONE | {
    "physical": STRUCTURE
    | {"base_amplitude_m": [0.0008, 0.001], "clearance_m": [0.003, 0.004], "friction_force_n": [200, 300]}
}


def computed(study: Study) -> xr.Dataset:
    return with_units(solved(study))


def ranked_with(definition: dict[str, Any], *more: xr.Dataset) -> tuple[xr.Dataset, xr.Dataset]:
    """Give a study's cube, and its ranking with further cubes."""
    cube = computed(parse_study(definition))
    cubes = {"study": cube} | {str(place): each for place, each in enumerate(more)}
    ranking = Ranking(with_=tuple(map(str, range(len(more)))))
    return cube, ranked_designs(cube, Judging(), ranking, lambda _: cubes)


def row_of(ranked: xr.Dataset) -> str:
    words = [ranked.attrs, ranked.attrs.get("in_units", ranked.attrs)]
    one, other = (row[2] for each in words for row in each["brief"]["rows"] if row[0] == "acceleration")
    assert one == other
    return str(one)


@pytest.mark.parametrize("definition", [ONE, SEVERAL], ids=["one base amplitude", "several"])
def test_the_friction_up_to_which_the_best_damper_holds_is_that_of_the_damper_on_its_own(
    definition: dict[str, Any],
) -> None:
    cube, ranked = ranked_with(definition)
    assert "`optimum --friction`" in row_of(ranked)
    step = find_friction(cube, ranked, Judging())
    assert (step.known, step.points > 0) == (False, True)
    best = leading(ranked)
    damper = {"clearance_m": best.get("clearance_m", 0.001 * best.get("clearance_ratio", 0.0))}
    damper["friction_force_n"] = best.get("friction_force_n", 300.0)
    measure = "amplitude_m" if AMPLITUDE in cube.sizes else "amplitude_ratio"

    def peak(coefficient: float) -> float:
        physical = definition["physical"] | damper | {"particle_friction_coefficient": coefficient}
        alone = computed(parse_study(definition | {"physical": physical}))
        return float(alone[measure].max())

    promised = ranked["value"].values[0]
    held = [peak(each) <= 1.1 * promised for each in COEFFICIENTS]
    count = held.index(False) if False in held else len(held)
    more = list(map(computed, step.studies))
    _, completed = ranked_with(definition, *more)
    (note,) = (each["values"] for each in completed.attrs["notes"] if each["kind"] == "particle_friction")
    assert note["up_to"] == (0.0, *COEFFICIENTS)[count]
    assert note["fails"] == (*COEFFICIENTS, None)[count]
    assert f"{note['up_to'] or note['fails']:g}" in row_of(completed)
    assert "--friction" not in row_of(completed)
    assert find_friction(cube, completed, Judging()).studies == ()
    # the ranking itself is unchanged
    xr.testing.assert_equal(completed, ranked)


def test_a_damper_that_a_tuned_mass_damper_beats_is_computed_with_friction_too() -> None:
    cube, ranked = ranked_with(ONE | {"physical": ONE["physical"] | {"friction_force_n": 20}})
    assert ranked.attrs["brief"]["damper"] == "tuned_mass_damper"
    assert "`optimum --friction`" in row_of(ranked)
    assert find_friction(cube, ranked, Judging()).points > 0


def test_studies_of_another_damper_say_nothing_of_the_best() -> None:
    cube, ranked = ranked_with(SEVERAL)
    clearance = 0.003 if ranked["clearance_m"].values[0] > 0.0035 else 0.004
    other = Judging(ranges={"clearance_m": (clearance, clearance)})
    of_other = ranked_designs(cube, other, Ranking(), lambda _: {})
    more = map(computed, find_friction(cube, of_other, other).studies)
    assert "`optimum --friction`" in row_of(ranked_with(SEVERAL, *more)[1])


@pytest.mark.parametrize(
    ("change", "field", "found"),
    [
        (
            {
                "physical": None,
                "axes": {"clearance_ratio": [3, 4], "friction_ratio": 0.5, "frequency_ratio": 0.97},
            },
            "physical",
            "a study in ratios",
        ),
        (
            {"physical": ONE["physical"] | {"particle_friction_coefficient": 0.1}},
            "particle_friction_ratio",
            "a study with `particle_friction_ratio`",
        ),
        (
            {"physical": ONE["physical"] | {"friction_force_n": 900}},
            "study",
            "a study whose best damper has no impacts",
        ),
    ],
    ids=["in ratios", "friction given", "clamped by friction"],
)
def test_friction_is_not_added_where_it_cannot_be_computed_or_has_no_effect(
    change: dict[str, Any], field: str, found: str
) -> None:
    definition = {name: value for name, value in (ONE | change).items() if value is not None}
    cube, ranked = ranked_with(definition)
    with pytest.raises(QueryFault) as refused:
        find_friction(cube, ranked, Judging())
    assert (refused.value.fault.field, refused.value.fault.found) == (field, found)
    assert found in refused.value.fault.sentence
    assert all("--friction" not in row[2] for row in ranked.attrs["brief"]["rows"])


def test_friction_is_not_added_to_contact_with_a_duration() -> None:
    cube, ranked = ranked_with(ONE)
    dwelling = parse_study(ONE | {"contact": {"model": "dwell", "contact_time": 0.01}})
    with pytest.raises(QueryFault, match=r"`contact\.model` dwell"):
        find_friction(cube.assign_attrs(study=json.dumps(dwelling.document())), ranked, Judging())
