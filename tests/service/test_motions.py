"""Forces and spectra of motions in closed form."""

import numpy as np
import pytest

from damperlab.service.motions import drift_spectrum, forces_on, harmonics_of
from damperlab.worker.point import Design


def motion(r, u, u_rate, v, v_rate):
    phase = np.linspace(0.0, 2.0 * np.pi, 257)
    columns = {"u": u, "u_rate": u_rate, "v": v, "v_rate": v_rate}
    nothing = np.full(phase.size, np.nan)
    return {"time": phase / r, "p": nothing} | {name: np.asarray(of(phase)) for name, of in columns.items()}


def total(forces):
    return sum(forces.values())


def test_forces_accelerate_the_structure_where_it_moves_and_where_friction_holds_it():
    r, zeta = 0.8, 0.1
    # the structure alone, v = u - sin a with (1 - r²) v + 2ζr v' = r² sin a
    c, d = 1.0 - r * r, 2.0 * zeta * r
    s, q = r * r * c / (c * c + d * d), -r * r * d / (c * c + d * d)
    v, v_rate = lambda a: s * np.sin(a) + q * np.cos(a), lambda a: r * (s * np.cos(a) - q * np.sin(a))
    swings = motion(r, lambda a: v(a) + np.sin(a), lambda a: v_rate(a) + r * np.cos(a), v, v_rate)
    forces = forces_on(swings, Design(zeta, r))
    np.testing.assert_allclose(total(forces), -r * r * swings["u"], atol=1e-12)
    rubs = forces_on(swings, Design(zeta, r, 0.3))["friction"]
    np.testing.assert_array_equal(rubs, -0.3 * np.sign(swings["v_rate"]))


def test_friction_that_holds_carries_the_structure_along_or_bears_the_force_as_far_as_it_reaches():
    r = 0.8
    locked = motion(r, np.sin, lambda a: r * np.cos(a), np.zeros_like, np.zeros_like)
    forces = forces_on(locked, Design(0.1, r, 1.0))
    np.testing.assert_allclose(total(forces), -r * r * locked["u"], atol=1e-12)
    still = motion(r, *(np.zeros_like,) * 4)
    borne = forces_on(still, Design(0.1, r, 0.5, forced=True))
    np.testing.assert_allclose(borne["friction"], np.clip(-np.sin(r * still["time"]), -0.5, 0.5), atol=1e-12)


def test_a_spectrum_has_the_amplitudes_of_its_harmonics():
    r = 0.5
    phase = np.linspace(0.0, 4.0 * np.pi, 1025)  # two cycles
    found = harmonics_of({"time": phase / r, "u": 2.0 * np.sin(phase) + 0.5 * np.sin(3.0 * phase)}, r)
    at = dict(zip(found["multiple"], found["amplitude"], strict=True))
    assert [at[1.0], at[3.0], at[2.0], at[0.5]] == pytest.approx([2.0, 0.5, 0.0, 0.0], abs=1e-3)
    assert max(at) == 8.0
    time = np.linspace(0.0, 10.0, 4001)
    drift = {"time_s": time, "relative_displacement_m": 0.01 * np.sin(2.0 * np.pi * 2.5 * time)}
    found = drift_spectrum(drift, 2.5)
    largest = found["amplitude_m"].argmax()
    assert found["frequency_hz"][largest] == pytest.approx(2.5)
    assert found["amplitude_m"][largest] == pytest.approx(0.01, rel=1e-3)
    assert found["frequency_hz"][-1] == pytest.approx(10.0)
