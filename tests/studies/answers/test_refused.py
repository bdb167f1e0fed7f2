"""Questions without an answer: each is refused by the field that is wrong, with what may be asked in its place."""

import json
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import xarray as xr

from damperlab.studies.answers.compared_response import compared_response
from damperlab.studies.answers.fragility import fragility
from damperlab.studies.answers.frequency_response import frequency_response
from damperlab.studies.answers.map_difference import map_difference
from damperlab.studies.answers.optimal_designs import merged_designs, optimal_designs
from damperlab.studies.answers.pareto import pareto_front
from damperlab.studies.answers.query_fault import QueryFault
from damperlab.studies.answers.refine import refine_boundary, refine_optimum
from damperlab.studies.answers.resonance_map import resonance_map
from damperlab.studies.answers.tmd_comparison import tmd_comparison
from damperlab.studies.answers.work_precision import work_precision
from damperlab.studies.definition import Study, parse_study
from damperlab.studies.faults import Fault
from damperlab.studies.questions import Fragile, Judging, Search, Selection, Tuning
from damperlab.studies.store.store import Store

Ask = Callable[[xr.Dataset], object]
NAN = float("nan")
PLANE = ("clearance_ratio", "friction_ratio")


def ranked(**judging: Any) -> Ask:
    return lambda cube: optimal_designs(cube, Judging(**judging))


def within(**ranges: tuple[float, float]) -> Ask:
    return ranked(ranges=ranges)


def mapped(x: str = PLANE[0], y: str = PLANE[1], **asked: Any) -> Ask:
    over = {name: asked.pop(name) for name in ("over", "reduce") if name in asked}
    return lambda cube: resonance_map(cube, x, y, Selection(**asked), **over)


def curve(**asked: Any) -> Ask:
    return lambda cube: frequency_response(cube, Selection(**asked))


def compared(at: dict[str, float] | None = None, **tuning: Any) -> Ask:
    return lambda cube: tmd_comparison(cube, Tuning(**tuning), at)


def less(change: Ask, **asked: Any) -> Ask:
    return lambda cube: map_difference(cube, change(cube), *PLANE, Selection(**asked))  # type: ignore[arg-type]


def beside(change: Ask, **asked: Any) -> Ask:
    return lambda cube: compared_response(cube, change(cube), Selection(**asked))  # type: ignore[arg-type]


def moved(cube: xr.Dataset, name: str) -> xr.Dataset:
    """Give the same study with another second value between equal ends."""
    values = cube[name].values.copy()
    values[1] = (values[0] + 3.0 * values[2]) / 4.0
    return cube.assign_coords({name: values})


def study_of(cube: xr.Dataset) -> Study:
    study = parse_study(json.loads(cube.attrs["study"]))
    assert isinstance(study, Study)
    return study


def empty(cube: xr.Dataset) -> dict[str, xr.Dataset]:
    return {"a": cube.assign(status=-1 + 0 * cube["status"])}


REFUSED: list[tuple[str, str, Ask]] = [
    ("objective", "one of peak, resonance", ranked(objective="best")),
    ("band", "resonance", ranked(objective="resonance", band=(0.8, 1.2))),
    ("band", "lower one first", ranked(objective="peak", band=(1.2, 0.8))),
    ("band", "the study has 6 values from 0.7 to 1.25", ranked(objective="peak", band=(0.96, 0.99))),
    ("clearance_ratio", "the nearest value is 20", within(clearance_ratio=(30.0, 40.0))),
    ("clearance_ratio", "lower one first", within(clearance_ratio=(NAN, 4.0))),
    ("clearance", "did you mean clearance_ratio", within(clearance=(1.0, 4.0))),
    ("frequency_ratio", "band", within(frequency_ratio=(1.0, 4.0))),
    ("response_class", "", within(response_class=(0.0, 1.0))),
    ("cycles", "", within(cycles=(2.0, 1.0))),
    ("max_impact_speed", "at least 0", ranked(max_impact_speed=-1.0)),
    ("max_impact_speed", "at least 0", ranked(max_impact_speed=NAN)),
    ("top", "1 to", lambda cube: optimal_designs(cube, top=0)),
    ("top", "1 to", lambda cube: optimal_designs(cube, top=10_001)),
    ("pareto", "amplitude", lambda cube: pareto_front(cube, ["amplitude"])),
    ("pareto", "amplitude", lambda cube: pareto_front(cube, ["amplitude", "-amplitude"])),
    ("pareto", "amplitude", lambda cube: pareto_front(cube, ["amplitude", "beauty"])),
    ("x", "did you mean clearance_ratio", mapped("clearance")),
    ("y", "no other argument", mapped("friction_ratio")),
    ("metric", "did you mean amplitude", mapped(metric="amplitude")),
    ("over", "no other argument", mapped(over="clearance_ratio")),
    ("over", "one of damping_ratio", mapped(over="nothing")),
    ("reduce", "max, min, mean", mapped(over="restitution", reduce="median")),
    ("reduce", "name the dimension", mapped(reduce="max")),
    ("metric", "codes", mapped(over="restitution", metric="response_class")),
    ("gap", "one of", mapped(at={"gap": 1.0})),
    ("clearance_ratio", "it is an axis of the map", mapped(at={"clearance_ratio": 1.0})),
    ("restitution", "finite", mapped(at={"restitution": NAN})),
    ("metric", "", curve(metric="amplitude")),
    ("frequency_ratio", "", curve(metric="cycles", at={"frequency_ratio": 1.0})),
    ("z", "", curve(metric="cycles", at={"z": 1.0})),
    # the nearest grid point would answer another question
    ("clearance_ratio", "axis from 1 to 20", curve(at={"clearance_ratio": 4000.0})),
    ("clearance_ratio", "axis from 1 to 20", curve(at={"clearance_ratio": -20.0})),
    ("restitution", "axis from 0.2 to 0.8", curve(at={"restitution": 47.0})),
    ("mass_ratio", "the only value of the study, 0.1", curve(at={"mass_ratio": 100.0})),
    ("criterion", "minimax", compared(criterion="best")),
    ("mass_ratio", "1e-12 to 10", compared(mass_ratio=0.0)),
    ("mass_ratio", "from 1e-12 to 10, not 5e-324", compared(mass_ratio=5e-324, criterion="den_hartog")),
    ("mass_ratio", "from 0 to 10", compared(mass_ratio=-0.1, tmd_mass_ratio=0.1)),
    ("tmd_mass_ratio", "above 0 and at most 10", compared(mass_ratio=0.1, tmd_mass_ratio=0.0)),
    ("tmd_mass_ratio", "below 2 for h2", compared(tmd_mass_ratio=2.0, criterion="h2")),
    ("detuning", "above -1", compared(detuning=-1.0)),
    ("excitation", "one of base, force", compared(excitation="wind")),
    ("damping_detuning", "above -1", compared(damping_detuning=NAN)),
    ("gap", "one of", compared({"gap": 1.0})),
    ("frequency_ratio", "the curve runs along it. Leave it out", compared({"frequency_ratio": 1.0})),
    ("mass_ratio", "name the mass", lambda cube: tmd_comparison(cube.assign_coords(mass_ratio=[0.0]))),
    ("minus", "3 values from 1 to 5 in the second", less(lambda cube: cube.isel(clearance_ratio=slice(3)))),
    ("minus", r"\(value 2 is", less(lambda cube: moved(cube, "clearance_ratio"))),
    ("with", r"\(value 2 is", beside(lambda cube: moved(cube, "frequency_ratio"))),
    ("minus", "in frequency ratio r", less(lambda cube: cube.isel(frequency_ratio=slice(2, None)))),
    ("minus", "amplitude_ratio", less(lambda cube: cube.drop_vars("amplitude_ratio"))),
    ("minus", "no axes in common", less(lambda cube: cube.rename(restitution="wall"))),
    ("metric", "a quantity", less(lambda cube: cube, metric="response_class")),
    ("with", "", beside(lambda cube: cube.isel(frequency_ratio=slice(3)))),
    ("with", "", beside(lambda cube: cube.assign_coords(mass_ratio=[0.2]))),
    ("metric", "a quantity", beside(lambda cube: cube, metric="response_class")),
    ("study", "needs a ground-motion suite", lambda cube: fragility(cube, Fragile(0.02))),
    ("tolerance", "", lambda cube: refine_optimum(study_of(cube), {"a": cube}, Search(0.0))),
    (
        "value_tolerance",
        "",
        lambda cube: refine_optimum(study_of(cube), {"a": cube}, Search(value_tolerance=2.0)),
    ),
    ("study", "compute the rest", lambda cube: refine_optimum(study_of(cube), empty(cube))),
    ("study", "% of the designs", lambda cube: refine_optimum(study_of(cube), {"a": cube})),
    ("along", "", lambda cube: refine_boundary(study_of(cube), {"a": cube}, "clearance", {})),
    ("boundary", "", lambda cube: refine_boundary(study_of(cube), {"a": cube}, "mass_ratio", {})),
    ("boundary", "", lambda cube: refine_boundary(study_of(cube), empty(cube), PLANE[1], {})),
    ("with", "", lambda cube: merged_designs({"a": cube, "b": cube.isel(frequency_ratio=slice(3))})),
]


@pytest.fixture(scope="module")
def loaded(filled: tuple[Store, str]) -> xr.Dataset:
    store, study_id = filled
    return store.cube(study_id).load()


@pytest.mark.parametrize(("field", "words", "ask"), REFUSED)
def test_a_question_without_an_answer_is_refused_with_what_may_be_asked(
    loaded: xr.Dataset, field: str, words: str, ask: Ask
) -> None:
    with np.errstate(invalid="ignore"), pytest.raises(QueryFault, match=f"(?i){words}") as caught:
        ask(loaded)
    assert caught.value.fault.field == field


def fault_of(ask: Ask, cube: xr.Dataset) -> Fault:
    with pytest.raises(QueryFault) as caught:
        ask(cube)
    return caught.value.fault


@pytest.fixture
def little(cube: xr.Dataset) -> xr.Dataset:
    """The cube of a study with ``metrics: [amplitude_ratio]``."""
    return cube[["amplitude_ratio", "status"]]


UNLOCKED = Judging(exclude_locked=True)


@pytest.mark.parametrize(
    ("field", "missing", "left_out", "ask"),
    [
        ("exclude_locked", "response_class", "exclude_locked", ranked(exclude_locked=True)),
        (
            "exclude_locked",
            "response_class",
            "exclude_locked",
            lambda cube: refine_optimum(study_of(cube), {"a": cube}, judging=UNLOCKED),
        ),
        ("max_impact_speed", "impact_speed_max", "max_impact_speed", ranked(max_impact_speed=1.0)),
        ("stick_fraction", "stick_fraction", "stick_fraction", within(stick_fraction=(0.0, 0.5))),
        (
            "pareto",
            "dissipation_impact",
            "dissipation_impact",
            lambda cube: pareto_front(cube, ["amplitude", "-dissipation_impact"]),
        ),
        (
            "boundary",
            "response_class",
            None,
            lambda cube: refine_boundary(study_of(cube), {"a": cube}, PLANE[1], {}),
        ),
        ("study", "run_time, amplitude_error", None, work_precision),
        ("objective", "amplitude_ratio", None, lambda cube: optimal_designs(cube[["status"]])),
        ("study", "amplitude_ratio", None, lambda cube: tmd_comparison(cube[["status"]])),
    ],
)
def test_what_is_not_stored_is_named_with_what_to_do(
    little: xr.Dataset, field: str, missing: str, left_out: str | None, ask: Ask
) -> None:
    fault = fault_of(ask, little)
    assert (fault.field, fault.found) == (field, f"a study that does not store {missing}")
    submit = f"add {missing} to `metrics` and submit again"
    assert fault.advice == (submit if left_out is None else f"{submit}, or leave {left_out} out")


def test_a_metric_that_is_not_stored_is_no_misspelt_one(little):
    fault = fault_of(curve(metric="amplitude_error"), little)
    assert (fault.field, fault.allowed) == ("metric", "one of amplitude_ratio, status")
    assert fault.found == "amplitude_error, which the study does not store"
    assert "did you mean" not in fault.advice
    with pytest.raises(QueryFault, match="Did you mean amplitude_ratio"):
        frequency_response(little, Selection("amplitude_ration"))


@pytest.mark.parametrize(
    ("solver", "metric", "needed"),
    [
        ("event", "attractors", "`start: {kind: ensemble}`"),
        ("rk4", "response_class", "`solver: {method: event}`"),
        ("rk4", "amplitude_error", ""),
    ],
)
def test_the_advice_is_a_study_that_can_be_submitted(little, solver, metric, needed):
    definition = json.loads(little.attrs["study"])
    asked = little.assign_attrs(study=json.dumps({**definition, "solver": {"method": solver}}))
    advice = fault_of(curve(metric=metric), asked).advice
    assert needed in advice
    assert ("with `" in advice) == bool(needed)


def test_an_error_that_is_not_stored_is_unknown_not_zero(little):
    answer = tmd_comparison(little, at={"clearance_ratio": 5.0, "restitution": 0.5, "friction_ratio": 0.2})
    assert math.isfinite(answer.attrs["hybrid_peak"])
    assert math.isnan(answer.attrs["hybrid_peak_error"])
