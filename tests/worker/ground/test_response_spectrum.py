"""Response spectra of records: closed forms, and a march in small steps."""

import numpy as np
import pytest

from damperlab.studies.ground.motion import GroundMotion
from damperlab.worker.ground.response_spectrum import response_spectrum


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


@pytest.mark.parametrize("zeta", [0.0, 0.6])
def test_the_march_is_that_of_small_steps(zeta: float) -> None:
    a = np.random.default_rng(7).normal(size=60)
    motion, period, parts = GroundMotion("noise", 0.05, a), np.array([0.11, 0.3, 1.7]), 100
    omega, h = 2 * np.pi / period, 0.05 / parts

    def rates(x: np.ndarray, v: np.ndarray, load: float) -> tuple[np.ndarray, np.ndarray]:
        return v, -load - 2 * zeta * omega * v - omega**2 * x

    x, v, largest = np.zeros(3), np.zeros(3), np.zeros(3)
    for k in range(59 * parts):
        at = [float(np.interp((k + part) / parts, np.arange(60), a)) for part in (0.0, 0.5, 1.0)]
        k1 = rates(x, v, at[0])
        k2 = rates(x + h / 2 * k1[0], v + h / 2 * k1[1], at[1])
        k3 = rates(x + h / 2 * k2[0], v + h / 2 * k2[1], at[1])
        k4 = rates(x + h * k3[0], v + h * k3[1], at[2])
        x = x + h / 6 * (k1[0] + 2 * k2[0] + 2 * k3[0] + k4[0])
        v = v + h / 6 * (k1[1] + 2 * k2[1] + 2 * k3[1] + k4[1])
        largest = np.maximum(largest, np.abs(x))
    # of Runge-Kutta the error of a step is (ω h)⁵/120, and there are as many steps as fit; a peak lies between two of them,
    # above both by at most h²/8 of the acceleration, 2 ω² x and that of the base, which is less than 3 of the noise
    error = 59 * parts * (omega * h) ** 5 + h**2 / 8 * (2 * omega**2 + 3 / largest)
    np.testing.assert_allclose(
        response_spectrum(motion, period, zeta).displacement_m, largest, rtol=error.max() + 1e-11
    )
