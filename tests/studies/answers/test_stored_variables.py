"""Questions that need a variable which the study does not store: refused in one way, or answered without it."""

import json
import math

import pytest

from damperlab.studies.answers.frequency_response import frequency_response
from damperlab.studies.answers.optimal_designs import optimal_designs
from damperlab.studies.answers.pareto import pareto_front
from damperlab.studies.answers.query_fault import QueryFault
from damperlab.studies.answers.refine import refine_boundary, refine_optimum
from damperlab.studies.answers.tmd_comparison import tmd_comparison
from damperlab.studies.answers.work_precision import work_precision
from damperlab.studies.definition import parse_study
from damperlab.studies.questions import Judging, Selection


@pytest.fixture
def study(cube):
    return parse_study(json.loads(cube.attrs["study"]))


@pytest.fixture
def little(cube):
    """The cube of a study with ``metrics: [amplitude_ratio]``."""
    return cube[["amplitude_ratio", "status"]]


LOCKED = Judging(exclude_locked=True)
STUCK = Judging(ranges={"stick_fraction": (0.0, 0.5)})


@pytest.mark.parametrize(
    ("field", "missing", "ask"),
    [
        ("exclude_locked", "response_class", lambda c, s: optimal_designs(c, LOCKED)),
        ("exclude_locked", "response_class", lambda c, s: refine_optimum(s, {"a": c}, judging=LOCKED)),
        (
            "max_impact_speed",
            "impact_speed_max",
            lambda c, s: optimal_designs(c, Judging(max_impact_speed=1.0)),
        ),
        ("stick_fraction", "stick_fraction", lambda c, s: optimal_designs(c, STUCK)),
        ("boundary", "response_class", lambda c, s: refine_boundary(s, {"a": c}, "friction_ratio", {})),
        ("study", "run_time, amplitude_error", lambda c, s: work_precision(c)),
        ("objective", "amplitude_ratio", lambda c, s: optimal_designs(c[["status"]])),
        ("study", "amplitude_ratio", lambda c, s: tmd_comparison(c[["status"]])),
    ],
)
def test_what_is_not_stored_is_named_with_what_to_do(little, study, ask, field, missing):
    with pytest.raises(QueryFault) as caught:
        ask(little, study)
    fault = caught.value.fault
    assert (fault.field, fault.found) == (field, f"a study that does not store {missing}")
    submit = f"add {missing} to `metrics` and submit again"
    needed = field in ("boundary", "study", "objective")
    assert fault.advice == (submit if needed else f"{submit}, or leave {field} out")


def test_a_respect_that_is_not_stored_can_be_left_out(little):
    with pytest.raises(QueryFault) as caught:
        pareto_front(little, ["amplitude", "-dissipation_impact"])
    assert caught.value.fault.field == "pareto"
    assert caught.value.fault.advice.endswith(
        "add dissipation_impact to `metrics` and submit again, or leave dissipation_impact out"
    )


def test_a_metric_that_is_not_stored_is_no_misspelt_one(little):
    with pytest.raises(QueryFault) as caught:
        frequency_response(little, Selection("amplitude_error"))
    fault = caught.value.fault
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
    with pytest.raises(QueryFault) as caught:
        frequency_response(asked, Selection(metric))
    advice = caught.value.fault.advice
    assert needed in advice
    assert ("with `" in advice) == bool(needed)


def test_an_error_that_is_not_stored_is_unknown_not_zero(little):
    answer = tmd_comparison(little, at={"clearance_ratio": 5.0, "restitution": 0.5, "friction_ratio": 0.2})
    assert math.isfinite(answer.attrs["hybrid_peak"])
    assert math.isnan(answer.attrs["hybrid_peak_error"])
