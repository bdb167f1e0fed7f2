"""The structure alone under random vibration and shocks: stationary variances and closed forms; and spectra of responses."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.linalg import expm

from damperlab.studies.ground.motion import STANDARD_GRAVITY, GroundMotion
from damperlab.studies.ground.random_vibration import RandomVibration
from damperlab.studies.ground.shock import Shock
from damperlab.worker.ground.design import Damper, Structure
from damperlab.worker.ground.response import ground_history, ground_response
from damperlab.worker.ground.response_spectrum import response_spectrum

OSCILLATOR = Structure(40.0, 10.0, 0.05)


def stationary_variance(structure: Structure, vibration: RandomVibration) -> tuple[float, float]:
    """Variance of x − z [m²] and of x'' [(m/s²)²]: ∫|H|²S df over the table, whatever its pieces."""
    omega, zeta = structure.omega, structure.damping_ratio

    def density(f: float) -> float:
        return math.exp(
            np.interp(math.log(f), np.log(vibration.frequency_hz), np.log(vibration.psd_m2_per_s3))
        )

    def moved(f: float) -> float:
        w = 2 * math.pi * f
        return density(f) / ((omega**2 - w**2) ** 2 + (2 * zeta * omega * w) ** 2)

    def accelerated(f: float) -> float:
        return moved(f) * (omega**4 + (2 * zeta * omega * 2 * math.pi * f) ** 2)

    ends = vibration.frequency_hz[0], vibration.frequency_hz[-1]
    peak = [*vibration.frequency_hz[1:-1], structure.natural_frequency_hz]
    found = [quad(each, *ends, points=peak, limit=400, epsrel=1e-9)[0] for each in (moved, accelerated)]
    return found[0], found[1]


@pytest.mark.parametrize(
    ("frequencies", "levels"),
    [((2.0, 9.0, 12.0, 60.0), (0.05, 2.0, 2.0, 0.1)), ((1.0, 10.4), (0.3, 3.0))],
)
def test_the_structure_alone_has_the_stationary_variances(
    frequencies: tuple[float, ...], levels: tuple[float, ...]
) -> None:
    """Over draws, each after it has forgotten its start: the mean square to four of its own standard errors.

    That error is about 1/√(2ζω·T/2·n) of the variance, 1.5 %, so the rms is checked to 3 %.
    """
    squares = []
    for seed in range(16):
        vibration = RandomVibration(frequencies, levels, 120.0, seed)
        _, history = ground_history(OSCILLATOR, Damper(), vibration.motion())
        time = history["time_s"]
        settled = vibration.ramp_s + 4.0 / (OSCILLATOR.damping_ratio * OSCILLATOR.omega)
        kept = (time > settled) & (time < vibration.ramp_s + vibration.duration_s)
        columns = history["relative_displacement_m"], history["absolute_acceleration_m_s2"]
        squares.append([float(np.mean(column[kept] ** 2)) for column in columns])
    mean, error = np.mean(squares, axis=0), np.std(squares, axis=0, ddof=1) / math.sqrt(len(squares))
    truth = np.array(stationary_variance(OSCILLATOR, RandomVibration(frequencies, levels, 120.0, 0)))
    assert (np.abs(mean - truth) < 4.0 * error).all()
    assert (error < 0.025 * truth).all()


@pytest.mark.parametrize("zeta", [0.0, 0.05, 0.3])
@pytest.mark.parametrize("ratio", [0.2, 0.6, 1.3, 3.4])
def test_a_half_sine_moves_the_structure_alone_as_its_closed_form(zeta: float, ratio: float) -> None:
    """The sine is the motion of an oscillator beside it, so that one exponential crosses the pulse exactly.

    Straight lines miss it by 4.9e-4 of the peak at most, 3.3e-4 of the area, and a dense scan misses no peak by 1e-6.
    """
    duration, peak = 0.02, 3.0 * STANDARD_GRAVITY
    structure = Structure(5.0, ratio / duration, zeta)
    omega, pulse = structure.omega, math.pi / duration
    alone = np.array([[0.0, 1.0], [-(omega**2), -2 * zeta * omega]])
    beside = np.zeros((4, 4))
    beside[:2, :2], beside[1, 2], beside[2, 3], beside[3, 2] = alone, -1.0, 1.0, -(pulse**2)
    steps = 2000
    state, way = np.array([0.0, 0.0, 0.0, peak * pulse]), [0.0]
    across = expm(beside * duration / steps)
    for _ in range(steps):
        state = across @ state
        way.append(state[0])
    after = expm(alone * duration / steps)
    free = state[:2]
    for _ in range(10 * steps):
        free = after @ free
        way.append(free[0])
    shock = Shock("half_sine", 3.0, 1e3 * duration, 10 * duration)
    found = ground_response(structure, Damper(), shock.motion())
    assert found.peak_relative_displacement_m == pytest.approx(np.abs(way).max(), rel=6e-4)


def test_a_sudden_base_acceleration_displaces_by_its_closed_form() -> None:
    """x(t) = −(a/ω²) (1 − e^(−ζωt) (cos ω_d t + ζ/√(1−ζ²) sin ω_d t)): its peak is the first overshoot."""
    h, zeta, a = 0.007, 0.05, 3.0
    motion = GroundMotion("step", h, np.full(501, a))
    period = np.array([0.003, 0.02, 0.2, 0.5, 1.0, 2.0])
    found = response_spectrum(motion, period, zeta)
    omega = 2 * np.pi / period
    overshoot = a / omega**2 * (1 + np.exp(-zeta * np.pi / np.sqrt(1 - zeta**2)))
    # a step holds more than two periods of the stiffest
    np.testing.assert_allclose(found.displacement_m, overshoot, rtol=1e-12)
    np.testing.assert_allclose(found.pseudo_acceleration_m_s2, omega**2 * found.displacement_m, rtol=1e-14)
