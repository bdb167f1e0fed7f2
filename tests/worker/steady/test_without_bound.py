"""Responses that grow as long as they are computed: no number is given of them, whatever the run's length."""

from math import pi

import numpy as np
import pytest

from damperlab.studies.variables import Status
from damperlab.worker.point import Design
from damperlab.worker.simulate import simulate
from damperlab.worker.solver.particle import Particle
from damperlab.worker.steady.response.standard_errors import grows
from damperlab.worker.steady.stopping_rules import Settings

FAR = Particle(1e6, 0.5, 0.1)


def ended(
    damping_ratio: float,
    friction_ratio: float,
    cycles: int,
    particle: Particle | None = None,
    forced: bool = False,
) -> int:
    design = Design(damping_ratio, 1.0, friction_ratio, particle, forced=forced)
    return int(simulate(design, settings=Settings(cycles, 0.02, 1e-9), followed=False).metrics["status"])


@pytest.mark.parametrize("cycles", [60, 400, 4000])
@pytest.mark.parametrize("friction_ratio", [0.3, 0.785])
def test_friction_below_a_quarter_of_pi_bounds_no_undamped_resonance(
    friction_ratio: float, cycles: int
) -> None:
    """A cycle of amplitude A takes in π A and loses 4 γ_F A (Den Hartog 1931): it grows for ever, slowly just below π/4."""
    assert friction_ratio < pi / 4
    assert ended(0.0, friction_ratio, cycles) == Status.UNBOUNDED
    assert ended(0.0, 0.8, cycles) == Status.CONVERGED


@pytest.mark.parametrize(("particle", "forced"), [(FAR, False), (None, True)])
def test_undamped_resonance_grows_beside_a_particle_that_meets_no_wall_and_under_a_force(
    particle: Particle | None, forced: bool
) -> None:
    assert ended(0.0, 0.3, 400, particle, forced) == Status.UNBOUNDED


def test_a_bound_that_is_out_of_sight_is_none() -> None:
    """1/(2ζ) (1 − 4γ_F/π) is 3.1e7 at ζ = 1e-8, and 4,000 cycles come to a thousandth of it; at ζ = 0.0038 it is reached."""
    assert ended(1e-8, 0.3, 4000) == Status.UNBOUNDED
    assert ended(0.0038, 0.3, 4000) == Status.CONVERGED


def test_a_series_grows_where_no_end_of_it_is_in_sight() -> None:
    n = np.arange(1000.0)
    noise = np.random.default_rng(3).normal(size=n.size)
    assert grows(n + 100.0 + noise, 0, n.size)
    assert grows(np.exp(n / 500), 0, n.size)
    # an approach whose end is told by its own slowing down, drifts that matter little, and what has no trend
    for bounded in (
        1.0 - np.exp(-n / 300),
        1.0 - 1.0 / (n + 10.0),
        1.0 + 1e-6 * n,
        noise,
        np.cumsum(noise) + 99.0,
    ):
        assert not grows(bounded, 0, n.size)
    assert not grows(n, 0, 79)
