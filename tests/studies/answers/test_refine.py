"""Refinement with the real solver: follow-ups, and the optimum beside that of a fine grid."""

import json

import numpy as np
import pytest
import xarray as xr
from tests.studies.solving import LEAN, solved

from damperlab.studies.answers.optimal_designs import optimal_designs
from damperlab.studies.answers.particle_friction import COEFFICIENTS
from damperlab.studies.answers.phrases import Phrases
from damperlab.studies.answers.query_fault import QueryFault
from damperlab.studies.answers.refine import refine_boundary, refine_optimum
from damperlab.studies.definition import Study, parse_study
from damperlab.studies.questions import Judging, Search
from damperlab.studies.units import with_units

FRICTION = {
    "name": "friction alone",
    "particle": False,
    "damping_ratio": 0.02,
    "axes": {
        "friction_ratio": {"start": 0.05, "stop": 1.05, "num": 11},
        "frequency_ratio": {"start": 0.8, "stop": 1.3, "num": 11},
    },
}
"""The worst over this band has its minimum inside: more friction helps at resonance and locks the rest."""


def named(study: Study) -> tuple[str, xr.Dataset]:
    """Name a study, and compute its cube."""
    return study.digest[:12], solved(study)


def with_axis(axis: object) -> Study:
    return parse_study({**FRICTION, "axes": {**FRICTION["axes"], "friction_ratio": axis}})


def test_the_optimum_is_that_of_a_grid_ten_times_finer_within_its_stated_flatness():
    _, coarse = named(parse_study(FRICTION))
    _, fine = named(with_axis({"start": 0.05, "stop": 1.05, "num": 101}))
    best, truth = optimal_designs(coarse, top=1), optimal_designs(fine, top=1)
    assert truth.attrs["objective"] == "peak"
    (flat,) = best.attrs["flatness"]
    low = flat["low"] if flat["below"] is None else flat["below"]
    high = flat["high"] if flat["above"] is None else flat["above"]
    assert low <= truth["friction_ratio"].item() <= high
    assert truth["value"].item() <= best["value"].item()
    # every fine grid point between `low` and `high` is really no more than a tenth worse
    peak = fine["amplitude_ratio"].max("frequency_ratio").values.ravel()
    axis = fine["friction_ratio"].values
    inside = (axis >= flat["low"] - 1e-12) & (axis <= flat["high"] + 1e-12)
    assert peak[inside].max() <= 1.1 * best["value"].item() * (1 + 1e-9)


def test_a_next_step_beyond_the_budget_is_told_as_that_and_no_budget_is_called_spent():
    study = parse_study(FRICTION)
    name, cube = named(study)
    free = refine_optimum(study, {name: cube}, Search(0.001, budget=10**6))
    assert free.points > 2
    step = refine_optimum(study, {name: cube}, Search(0.001, budget=free.points - 1))
    assert not step.studies
    needs = f"the next step takes {free.points} points, more than the budget of {free.points - 1} points."
    assert step.brief.sentences[-1] == f"Not settled: {needs}"
    assert needs in step.say()
    # the next command must suffice for that step, even if four times the budget does not
    step = refine_optimum(study, {name: cube}, Search(0.001, budget=1))
    assert step.brief.next.endswith(f"--budget {max(4, free.points)}")


def test_a_refined_optimum_says_up_to_which_friction_of_its_particle_it_holds() -> None:
    physical = {
        "mass_kg": 250, "natural_frequency_hz": 7.6, "base_amplitude_m": 0.001, "particle_mass_kg": 20,
        "friction_force_n": 300, "clearance_m": {"start": 0.003, "stop": 0.005, "num": 3},
    }  # fmt: skip
    band = {"start": 0.95, "stop": 1.0, "num": 6}
    study = parse_study(
        {
            "damping_ratio": 0.02,
            "metrics": LEAN,
            "physical": physical,
            "axes": {"restitution": 0.5, "frequency_ratio": band},
        }
    )
    name, cube = named(study)
    cubes, search = {name: with_units(cube)}, Search(tolerance=1.0)
    step = refine_optimum(study, cubes, search)
    assert step.known
    # six frequencies do not see the height of a peak, as the ranking says too
    hides = "hidden_peak" in {note["kind"] for note in optimal_designs(cube).attrs["notes"]}
    assert ("a peak may be more than a tenth higher" in step.brief.sentences[0]) is hides
    assert ("hidden_peak" in {note.kind for note in step.notes}) is hides
    (more,) = step.studies
    other, rubbing = named(more)
    step = refine_optimum(study, cubes | {other: rubbing}, search)
    assert not step.studies
    (found,) = [note.values for note in step.notes if note.kind == "particle_friction"]
    worst = rubbing["amplitude_ratio"].max("frequency_ratio").values.ravel()
    held = [
        kept for kept, value in zip(COEFFICIENTS, worst, strict=True) if value <= 1.1 * step.found["value"]
    ]
    assert found["up_to"] == max(held, default=0.0) < found["fails"] == COEFFICIENTS[len(held)]
    _, (_, up_to, what) = step.brief.rows
    assert f"{found['up_to']:g}" in up_to
    assert f"{found['fails']:g}" in what
    assert up_to in step.say()


def test_a_study_whose_designs_all_grow_without_bound_is_refused_with_the_reason_and_the_remedy() -> None:
    axes = {"friction_ratio": [0.1, 0.2], "frequency_ratio": [0.9, 1.0]}
    study = parse_study({"particle": False, "damping_ratio": 0.0, "axes": axes})
    name, cube = named(study)
    with pytest.raises(QueryFault) as refused:
        refine_optimum(study, {name: cube})
    assert refused.value.fault.field == "damping_ratio"


def test_a_class_boundary_is_found_where_friction_locks_the_mass():
    study = parse_study(FRICTION)
    name, cube = named(study)
    cubes = {name: cube}
    for _ in range(5):
        step = refine_boundary(
            study, cubes, "friction_ratio", {"frequency_ratio": 0.9, "friction_ratio": 0.8}
        )
        if not step.studies:
            break
        other, more = named(step.studies[0])
        cubes[other] = more
    assert step.known
    assert step.found["above"] == "locked"
    # the mass moves with the base wherever the friction bears the largest inertia force, r²
    assert step.found["low"] - 1e-12 <= 0.81 <= step.found["high"] + 1e-3
    assert step.found["high"] - step.found["low"] <= 1e-3 * (1 + 1e-9)
    assert "1,001" in step.say()


def test_a_search_is_told_in_the_units_of_the_study() -> None:
    physical = {"mass_kg": 10, "natural_frequency_hz": 5, "base_amplitude_m": 0.002}
    study = parse_study({**with_axis([0.1, 0.3]).document(), "physical": physical})
    name, cube = named(study)
    step = refine_optimum(study, {name: cube}, Search(tolerance=0.01))
    (place,) = [note for note in step.notes if "steps" in note.values]
    newtons = 0.2 * 10 * (2 * np.pi * 5) ** 2 * 0.002
    assert place.values["steps"] == {"friction_ratio": pytest.approx(0.2)}
    assert f"{newtons:.3g} N in friction force F_f" in step.say(Phrases.of(with_units(cube)))


def test_a_follow_up_of_a_hybrid_keeps_everything_but_the_axes():
    study = parse_study(
        {
            "name": "hybrid",
            "damping_ratio": 0.01,
            "axes": {
                "clearance_ratio": [1, 2, 5, 10],
                "friction_ratio": [0, 0.3, 0.6],
                "mass_ratio": 0.1,
                "restitution": 0.5,
                "frequency_ratio": [0.9, 1.0, 1.1],
            },
            "metrics": ["amplitude_ratio", "amplitude_error"],
            "steady": {"max_cycles": 77},
        }
    )
    values = np.abs(study.coordinates["clearance_ratio"][:, None] - 5) + np.abs([-0.3, 0.0, 0.3])
    amplitudes = np.broadcast_to(values[None, None, None, :, :, None], study.shape)
    columns = {"amplitude_ratio": amplitudes, "status": np.zeros(study.shape, np.int8)}
    variables = {name: (tuple(study.coordinates), column) for name, column in columns.items()}
    cube = xr.Dataset(variables, study.coordinates)
    step = refine_optimum(study, {"a": cube}, judging=Judging(band=(0.95, 1.2)))
    (more,) = step.studies
    ours = more.coordinates
    np.testing.assert_allclose(ours["clearance_ratio"], [2, 2.75, 3.5, 4.25, 5, 6.25, 7.5, 8.75, 10])
    np.testing.assert_allclose(ours["friction_ratio"], np.linspace(0, 0.6, 9))
    assert ours["frequency_ratio"].tolist() == [1.0, 1.1]
    assert (more.steady, more.metrics) == (study.steady, study.metrics)
    assert step.points == 9 * 9 * 2


def test_follow_ups_of_a_study_in_units_keep_its_units():
    structure = {"mass_kg": 2.0, "natural_frequency_hz": 4.0, "base_amplitude_m": 0.003}
    force = 2.0 * (2 * np.pi * 4.0) ** 2 * 0.003
    study = parse_study(
        {
            "particle": False,
            "damping_ratio": 0.02,
            "physical": structure | {"friction_force_n": [0.1 * force, 0.4 * force, 0.7 * force]},
            "axes": {"frequency_ratio": {"start": 0.8, "stop": 1.3, "num": 6}},
        }
    )
    name, cube = named(study)
    step = refine_optimum(study, {name: cube})
    assert step.studies
    for each in step.studies:
        other, more = named(each)
        assert json.loads(more.attrs["study"])["physical"] == structure
        units = with_units(more)
        np.testing.assert_allclose(units["friction_force_n"], force * more["friction_ratio"], rtol=1e-15)
        assert refine_optimum(study, {name: cube, other: more}).found["value"] <= step.found["value"]
