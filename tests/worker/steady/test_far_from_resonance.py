"""Steady responses far below and far above resonance, and of a particle on a mass that friction holds."""

import pytest

from damperlab.studies.variables import Status
from damperlab.worker.point import Design
from damperlab.worker.simulate import simulate
from damperlab.worker.solver.particle import Particle


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
