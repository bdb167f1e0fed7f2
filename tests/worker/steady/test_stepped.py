"""Studies by the paper's fixed steps: what they converge to, how fast, and what they do not know."""

from typing import Any

import numpy as np
import pytest
from tests.studies.documents import fields_of

from damperlab.studies.choices import Rk4Solver
from damperlab.studies.definition import Study, parse_study
from damperlab.studies.plan import Block
from damperlab.studies.variables import STEPPED, Status
from damperlab.worker.block import solve_block
from damperlab.worker.solver.particle import Particle
from damperlab.worker.steady.fixed_steps import settle_stepped
from damperlab.worker.steady.settle import Settings


def study_of(steps: int | None, **changes: Any) -> Study:
    document: dict[str, Any] = {
        "damping_ratio": 0.1,
        "axes": {"frequency_ratio": [0.7, 1.2], "friction_ratio": 0.2},
        "particle": False,
        "steady": {"max_cycles": 400, "tolerance": 1e-8},
    }
    if steps is not None:
        document["solver"] = {"method": "rk4", "steps_per_cycle": steps}
    return parse_study({**document, **changes})


def solved(study: Study) -> dict[str, np.ndarray]:
    return solve_block(study, Block.whole(study.shape))


def test_steps_come_closer_to_the_exact_response_with_their_number() -> None:
    """A step straddles each turn: the error is of first order, so 16 times the steps leave less than an eighth of it."""
    exact = solved(study_of(None))["amplitude_ratio"]
    errors = [np.abs(solved(study_of(steps))["amplitude_ratio"] / exact - 1.0).max() for steps in (100, 1600)]
    assert errors[0] < 0.05
    assert errors[1] < errors[0] / 8.0


def test_a_point_without_friction_and_particle_is_stepped_too_and_meets_the_closed_form() -> None:
    axes = {"frequency_ratio": [0.7, 1.2], "friction_ratio": 0.0}
    values = solved(study_of(400, axes=axes))
    r, zeta = np.array(axes["frequency_ratio"]), 0.1
    exact = np.sqrt((1 + (2 * zeta * r) ** 2) / ((1 - r * r) ** 2 + (2 * zeta * r) ** 2))
    # sampled peaks are low by up to (π/400)²/2, the method itself errs by less
    np.testing.assert_allclose(values["amplitude_ratio"].ravel(), exact, rtol=0.5 * (np.pi / 400) ** 2 + 1e-8)
    assert (values["status"] == Status.CONVERGED).all()
    assert (values["cycles"] > 0).all()


@pytest.mark.parametrize("zeta", [1e-3, 5e-4, 2e-4, 0.0])
def test_a_slow_transient_is_not_taken_for_the_response(zeta: float) -> None:
    """The peaks of 64 cycles agree long before the resonance has risen."""
    found = settle_stepped(zeta, 1.0, None, None, 40, Settings(4000, 0.02, 1e-9, None))
    if zeta == 0.0:
        assert found.status == Status.UNBOUNDED
        return
    exact = np.hypot(1.0, 1.0 / (2.0 * zeta))
    assert abs(found.amplitude_ratio / exact - 1.0) <= found.amplitude_error / exact + 0.01
    assert found.status == Status.MAX_CYCLES or found.amplitude_error <= 0.02 * found.amplitude_ratio


def test_a_study_by_steps_stores_what_steps_tell_and_no_more() -> None:
    study = study_of(400)
    assert isinstance(study.solver, Rk4Solver)
    assert tuple(study.metrics) == STEPPED
    assert set(solved(study)) == set(STEPPED)
    assert study.digest != study_of(200).digest
    assert study.digest != study_of(None).digest


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"metrics": ["amplitude_ratio", "energy_residual"]}, "metrics[1]"),
        ({"metrics": ["acceleration_ratio"]}, "metrics[0]"),
        ({"start": {"kind": "ensemble", "n": 3}}, "start"),
        (
            {
                "particle": True,
                "axes": {"frequency_ratio": 1.0, "clearance_ratio": 2.0},
                "contact": {"model": "dwell", "contact_time": 0.1},
            },
            "contact.model",
        ),
        ({"solver": {"method": "rk4", "steps_per_cycle": 3}}, "solver.steps_per_cycle"),
        ({"solver": {"method": "rk4", "steps": 400}}, "solver.steps"),
    ],
)
def test_what_steps_do_not_know_is_refused_by_field(change: dict[str, Any], field: str) -> None:
    assert field in fields_of(study_of, 400, **change)


@pytest.mark.parametrize("cycles", [64, 65, 70, 129])
def test_peaks_agree_over_whole_stretches_alone(cycles: int) -> None:
    """A limit on cycles that leaves one cycle over does not make it agree with itself."""
    settings = Settings(cycles, 0.002, 1e-9, None)
    found = settle_stepped(0.02, 1.0, None, Particle(5.0, 0.6, 0.1), 100, settings)
    assert found.status == Status.MAX_CYCLES
    assert found.amplitude_error > 0.0
