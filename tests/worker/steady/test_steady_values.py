"""Steady responses against exact solutions: Den Hartog–Hundal friction, two-impact motions, transmissibility."""

import numpy as np
import pytest
from tests.oracles.forced_friction import non_stop, one_stop
from tests.oracles.impact_pair import two_impacts_per_cycle
from tests.oracles.transmissibility import absolute_amplitude, relative_amplitude

from damperlab.studies.variables import ResponseClass, Status
from damperlab.worker.point import Design
from damperlab.worker.simulate import simulate
from damperlab.worker.solver.particle import Particle

ROUNDING = 1e-11
"""Relative, of a response that is periodic to the last digit; the oracles' root finding leaves less."""


def assert_within_stated_error(found: dict[str, float | int], name: str, truth: float) -> None:
    """The distance from periodicity bounds the error: the sum of what further periods would still change."""
    allowed = 1.5 * found["amplitude_error"] + ROUNDING * max(1.0, truth)
    assert found[name] == pytest.approx(truth, rel=0.0, abs=allowed), name


@pytest.mark.parametrize(
    ("damping", "frequency"), [(0.0038, 1.0), (0.0, 0.999), (0.3, 0.1), (0.99, 2.0), (0.0038, 20.0)]
)
def test_structure_alone_is_the_transmissibility(damping: float, frequency: float) -> None:
    found = simulate(Design(damping, frequency)).metrics
    assert found["amplitude_ratio"] == pytest.approx(absolute_amplitude(damping, frequency), rel=1e-9)
    assert found["relative_amplitude_ratio"] == pytest.approx(
        relative_amplitude(damping, frequency), rel=1e-9
    )
    assert found["response_class"] == ResponseClass.LINEAR


@pytest.mark.parametrize(
    ("damping", "frequency", "friction"),
    [
        (0.0038, 1.0, 0.6),
        (0.05, 1.5, 0.3),
        (0.1, 0.8, 0.3),
        (0.3, 2.0, 0.5),
        (0.0, 1.3, 0.4),
        (0.01, 0.95, 0.5),
    ],
)
def test_friction_without_stops_is_den_hartogs_solution(
    damping: float, frequency: float, friction: float
) -> None:
    truth = non_stop(damping, frequency, friction)
    found = simulate(Design(damping, frequency, friction)).metrics
    assert found["status"] == Status.CONVERGED
    assert found["stick_fraction"] == 0.0
    assert_within_stated_error(found, "amplitude_ratio", truth.amplitude_ratio)
    assert_within_stated_error(found, "relative_amplitude_ratio", truth.relative_amplitude_ratio)


@pytest.mark.parametrize(
    ("damping", "frequency", "friction"),
    [(0.0038, 1.0, 0.8), (0.0038, 0.9, 0.7), (0.0038, 0.5, 0.2), (0.02, 0.7, 0.35)],
)
def test_friction_with_a_stop_in_each_half_cycle(damping: float, frequency: float, friction: float) -> None:
    truth = one_stop(damping, frequency, friction)
    found = simulate(Design(damping, frequency, friction)).metrics
    assert found["status"] == Status.CONVERGED
    for name in ("amplitude_ratio", "relative_amplitude_ratio", "stick_fraction"):
        assert_within_stated_error(found, name, getattr(truth, name))


@pytest.mark.parametrize("frequency", [0.5, 0.9, 1.0])
def test_friction_above_the_inertia_force_locks_the_mass(frequency: float) -> None:
    for friction in (frequency**2, 1.5 * frequency**2 + 1.0):
        found = simulate(Design(0.0038, frequency, friction)).metrics
        assert found["response_class"] == ResponseClass.LOCKED
        assert found["status"] == Status.CONVERGED
        # u = v + s with v at rest: anywhere in the band |v| <= γ_F − r², nowhere else.
        beyond = found["amplitude_ratio"] - 1.0
        assert -1e-12 <= beyond <= friction - frequency**2 + 1e-9


@pytest.mark.parametrize(
    ("damping", "frequency", "clearance", "restitution", "mass"),
    [
        (0.0038, 1.0, 10.0, 0.47, 0.1),
        (0.0038, 1.0, 12.0, 0.82, 0.1),
        (0.05, 0.95, 2.0, 0.6, 1.0),
    ],
)
def test_two_impacts_a_cycle_are_the_exact_symmetric_motion(
    damping: float, frequency: float, clearance: float, restitution: float, mass: float
) -> None:
    stable = [
        motion
        for motion in two_impacts_per_cycle(damping, frequency, clearance, restitution, mass)
        if abs(motion.multipliers[0]) < 1.0
    ]
    (truth,) = stable
    found = simulate(Design(damping, frequency, 0.0, Particle(clearance, restitution, mass))).metrics
    assert found["status"] == Status.CONVERGED
    assert found["response_class"] == ResponseClass.SYMMETRIC
    assert found["impacts_per_cycle"] == 2.0
    assert_within_stated_error(found, "amplitude_ratio", truth.amplitude_ratio)
    assert_within_stated_error(found, "relative_amplitude_ratio", truth.relative_amplitude_ratio)
    assert_within_stated_error(found, "impact_speed_max", truth.impact_speed)


def test_an_unstable_two_impact_motion_is_not_reported() -> None:
    (unstable,) = two_impacts_per_cycle(0.0038, 1.0, 6.0, 0.47, 0.1)
    assert abs(unstable.multipliers[0]) > 1.0
    found = simulate(Design(0.0038, 1.0, 0.0, Particle(6.0, 0.47, 0.1))).metrics
    assert abs(found["amplitude_ratio"] - unstable.amplitude_ratio) > 10.0 * found["amplitude_error"]


@pytest.mark.parametrize(
    "design",
    [
        Design(0.05, 0.9),
        Design(0.0038, 1.0, 0.6),
        Design(0.0038, 1.0, 0.8),
        Design(0.0038, 1.0, 0.0, Particle(10.0, 0.47, 0.1)),
        Design(0.0038, 0.95, 0.4, Particle(2.0, 0.47, 0.1)),
        Design(0.0038, 1.0, 0.6, Particle(2.0, 0.47, 0.0)),
    ],
)
def test_history_of_a_steady_response_is_steady(design: Design) -> None:
    found = simulate(design, history=3)
    amplitude = found.metrics["amplitude_ratio"]
    peak = np.abs(found.history["u"]).max()
    # Samples are a quarter of a window apart, a twentieth of a radian at most either side of the peak.
    assert amplitude * (1.0 - 0.05**2) <= peak <= amplitude * (1.0 + 1e-9)
    again = simulate(design, history=1)
    for name in ("u", "u_rate"):
        later, sooner = found.state[name], again.state[name]
        assert later == pytest.approx(sooner, abs=1e-9 * max(1.0, amplitude)), name


def test_a_time_history_is_whole_whatever_room_there_was_at_first(monkeypatch: pytest.MonkeyPatch) -> None:
    design = Design(0.0038, 0.95, 0.4, Particle(2.0, 0.47, 0.1))
    found = simulate(design, 3, history=2)
    monkeypatch.setattr("damperlab.worker.point._LOG_SEGMENTS", 5)
    again = simulate(design, 3, history=2)
    del found.metrics["run_time"], again.metrics["run_time"]
    assert (again.metrics, again.state, again.events) == (found.metrics, found.state, found.events)
    for name, values in found.history.items():
        assert values.tobytes() == again.history[name].tobytes(), name
