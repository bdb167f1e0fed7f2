"""Steady responses far below and far above resonance, and those that grow as long as they are computed."""

from math import pi

import numpy as np
import pytest

from damperlab.studies.variables import Status
from damperlab.worker.point import Design
from damperlab.worker.simulate import simulate
from damperlab.worker.solver.particle import Particle
from damperlab.worker.steady.response.standard_errors import grows
from damperlab.worker.steady.stopping_rules import Settings


@pytest.mark.parametrize(
    "design",
    [
        Design(0.001, 0.00117, 0.0, Particle(2.8e-4, 0.97, 0.1)),
        Design(0.0217, 0.00463, 0.0, Particle(0.00168, 0.8, 5.0)),
    ],
    ids=["light particle", "heavy particle"],
)
def test_the_start_is_not_in_the_averages_of_a_response_to_slow_shaking(design: Design) -> None:
    """From rest the mass lags the base with its velocity r, beside r³ in the response: 10¹¹ times its energy.

    The truth is what a plain run loses in its second hundred cycles.
    """
    stated = simulate(design, followed=False).metrics
    first, both = (simulate(design, cycles).metrics["dissipation_per_cycle"] for cycles in (100, 200))
    lost = 2.0 * both - first
    assert stated["dissipation_per_cycle"] == pytest.approx(lost, rel=0.05)


@pytest.mark.parametrize("friction", [0.98, 0.9585945676051773])
@pytest.mark.parametrize("damping", [0.0038, 0.03])
def test_a_response_that_is_known_no_better_than_its_error_is_not_called_converged(
    damping: float, friction: float
) -> None:
    """Under a force at r = 1000 an amplitude of 10⁻⁹ of the static one is found among roundings and a decay of 10⁻⁵ a cycle."""
    metrics = simulate(Design(damping, 1000.0, friction, forced=True), followed=False).metrics
    known = metrics["amplitude_error"] <= 0.02 * metrics["amplitude_ratio"]
    assert known or metrics["status"] == Status.MAX_CYCLES


@pytest.mark.parametrize("damping", [0.8, 0.85, 0.9])
def test_a_particle_that_a_stuck_mass_carries_strikes_once_a_half_cycle(damping: float) -> None:
    """e = 0, γ_F above r²: it leaves where the base's acceleration changes sign, strikes the other wall, and stays there.

    That it is pushed again in the instant in which it was let go is no impact.
    """
    design = Design(damping, 1.0, 1.5, Particle(0.01, 0.0, 0.1))
    forty, thirty = (simulate(design, cycles).events["impacts"] for cycles in (40, 30))
    assert forty - thirty == 20


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
