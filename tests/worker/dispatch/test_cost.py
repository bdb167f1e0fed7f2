"""The cost model against the solver's own cycles: order and bounds, never run times."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from tests.benchmarks import model
from tests.worker.run_here import planned, run_here, submit

from damperlab.service.estimates import estimate_document
from damperlab.studies.definition import Study, parse_study
from damperlab.studies.digest import family_digest
from damperlab.studies.plan import plan_with_chunk
from damperlab.studies.store.reuse import done_of_family
from damperlab.studies.store.store import Store
from damperlab.worker.block import solve_block
from damperlab.worker.dispatch.cost_model import (
    HYBRID_CYCLE_SECONDS,
    LINEAR_SECONDS,
    MOST_RIDING,
    family_factor,
    seconds_per_point,
)


def scene(particle: bool, max_cycles: int = 500, damping: object = 0.0038, friction: object = 0.4) -> Study:
    axes = {"friction_ratio": friction, "frequency_ratio": {"start": 0.9, "stop": 1.1, "num": 5}}
    if particle:
        axes |= {"clearance_ratio": 5, "restitution": 0.47, "mass_ratio": 0.1}
    return parse_study(
        {
            "name": "cost",
            "damping_ratio": damping,
            "axes": axes,
            "particle": particle,
            "steady": {"max_cycles": max_cycles},
        }
    )


def expected(study: Study) -> float:
    return plan_with_chunk(study, (1, 1, 1, 1, 1, 1), seconds_per_point).seconds


def cycles(study: Study) -> int:
    block = plan_with_chunk(study, study.shape, seconds_per_point).block(0)
    return int(solve_block(study, block)["cycles"].sum())


@pytest.mark.parametrize("particle", [False, True])
def test_cost_is_positive_and_bounded_over_everything_that_is_allowed(particle: bool) -> None:
    study = scene(particle)
    corners = {
        "damping_ratio": (0.0, 0.99),
        "restitution": (0.0, 1.0),
        "mass_ratio": (0.0, 10.0),
        "clearance_ratio": (0.01, 1000.0),
        "friction_ratio": (0.0, 2.0),
        "frequency_ratio": (0.01, 1.0, 100.0),
    }
    points = np.array(list(itertools.product(*corners.values()))).T
    seconds = seconds_per_point(study, dict(zip(corners, points, strict=True)))
    assert seconds.shape == points[0].shape
    assert (seconds > 0.0).all()
    assert seconds.max() <= study.steady.max_cycles * HYBRID_CYCLE_SECONDS * (1.0 + MOST_RIDING)


def test_points_without_friction_and_particle_cost_the_closed_form() -> None:
    for particle in (False, True):
        study = scene(particle, friction=0)
        weightless = {name: np.full(3, values[0]) for name, values in study.coordinates.items()}
        weightless["mass_ratio"] = np.zeros(3)
        np.testing.assert_array_equal(seconds_per_point(study, weightless), LINEAR_SECONDS)


@pytest.mark.parametrize(
    ("cheap", "dear"),
    [
        (scene(True, damping=0.2), scene(True, damping=0.002)),
        (scene(False, damping=0.02), scene(True, friction=0)),
        (scene(True, max_cycles=100), scene(True, max_cycles=2000)),
    ],
    ids=["damping shortens the transient", "a particle may never settle", "the limit on cycles"],
)
def test_what_is_expected_to_cost_more_takes_more_cycles(cheap: Study, dear: Study) -> None:
    assert expected(cheap) < expected(dear)
    assert cycles(cheap) < cycles(dear)


def test_a_tighter_tolerance_is_expected_to_take_what_it_takes() -> None:
    axes = {"clearance_ratio": [20, 22, 24], "friction_ratio": [0.05, 0.1], "frequency_ratio": 1}

    def restless(tolerance: float) -> Study:
        return parse_study({"axes": axes, "steady": {"max_cycles": 20_000, "tolerance": tolerance}})

    loose, tight, tightest = (restless(each) for each in (0.02, 0.005, 1e-8))
    # the relative error of a chaotic mean falls as the inverse root of its cycles: up to sixteen times as many
    assert cycles(tight) > 4 * cycles(loose)
    assert 4 * expected(loose) < expected(tight) < 16 * expected(loose)
    # what nothing meets is paid to the last cycle; without chatter a cycle costs what the model says
    assert cycles(tightest) == 6 * 20_000
    assert expected(tightest) == pytest.approx(HYBRID_CYCLE_SECONDS * cycles(tightest), rel=0.01)


ROWS = (1, 1, 1, 1, 1, 8)


def friction_study(rows: int, **more: object) -> Study:
    axes = {
        "friction_ratio": {"start": 0.1, "stop": 0.7, "num": rows},
        "frequency_ratio": {"start": 0.7, "stop": 1.3, "num": 8},
    }
    return parse_study({"damping_ratio": 0.05, "axes": axes, "particle": False, **more})


def test_studies_of_a_family_tell_what_blocks_take_and_others_do_not(store: Store) -> None:
    coarse = run_here(store, submit(store, friction_study(5), ROWS).id)
    # other settings: no family
    run_here(store, submit(store, friction_study(5, steady={"max_cycles": 50}), ROWS).id)
    finer = friction_study(16)
    plan, record = planned(finer, ROWS), submit(store, finer, ROWS)
    earlier = done_of_family(store, family_digest(finer, record.provenance))
    assert [each.id for each in earlier] == [coarse.id]
    factor = coarse.kernel_seconds / planned(friction_study(5), ROWS).seconds
    assert family_factor(earlier) == pytest.approx(factor, rel=1e-12)
    # known before it is submitted
    blind, told = estimate_document(finer, plan), estimate_document(finer, plan, store)
    assert told["seconds"] - told["compiling_seconds"] == pytest.approx(factor * plan.seconds, rel=1e-12)
    assert blind["seconds"] - blind["compiling_seconds"] == pytest.approx(plan.seconds, rel=1e-12)
    for each in (blind, told):
        assert each["seconds_low"] < each["seconds"] < each["seconds_high"]
    # who knows more is surer
    assert told["seconds_high"] / told["seconds_low"] < blind["seconds_high"] / blind["seconds_low"]
    assert done_of_family(store, "") == []
    # what cannot be says nothing, and half of the points took twice as long for each
    assert family_factor([replace(coarse, kernel_seconds=math.inf)]) is None
    half = replace(coarse, points_reused=coarse.points_done // 2)
    assert family_factor([half]) == pytest.approx(2 * factor, rel=1e-12)


def test_an_earlier_study_tells_what_a_finer_one_takes() -> None:
    """With what real points took: a study of 23 × 11 × 39 points before one of 96 × 48 × 160."""
    estimate = model.estimates(4)
    assert estimate["family"] == pytest.approx(estimate["true"], rel=0.1)
