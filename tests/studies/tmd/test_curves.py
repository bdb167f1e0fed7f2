"""Exact curves for drawing: lines between their points follow the curves, and no peak is missed, however few are asked for."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.oracles import transmissibility, tuned_mass

from damperlab.studies.tmd.absorber import Absorber
from damperlab.studies.tmd.transfer import BEND, exact_curves, highest
from damperlab.studies.tmd.tunings import exact_hinf


@given(
    st.floats(0.01, 0.5),
    st.floats(0.6, 1.2),
    st.floats(0.02, 0.8),
    st.floats(0.005, 0.3),
    st.floats(0.0, 0.9),
    st.floats(1.1, 3.0),
    st.integers(0, 10**6),
)
def test_lines_between_the_points_follow_both_curves(
    mass_ratio, tuning, damping, structural, low, high, seed
):
    curves = exact_curves([low, high], Absorber(mass_ratio, tuning, damping), structural)
    at = np.random.default_rng(seed).uniform(low, high, 50)
    for name, values in (
        ("tmd", tuned_mass.amplitude_ratio(at, mass_ratio, tuning, damping, structural)),
        ("no_damper", [transmissibility.absolute_amplitude(structural, r) for r in at]),
    ):
        drawn = np.exp(np.interp(at, curves["frequency_ratio"], np.log(curves[name])))
        # held to `BEND` at the thirds; in between, a curve whose bend changes may be off by more, but by less than twice that
        np.testing.assert_allclose(drawn, values, rtol=2 * BEND)


@pytest.mark.parametrize("excitation", ["base", "force"])
def test_every_frequency_that_is_asked_for_and_every_peak_are_there(excitation):
    absorber, given_at = exact_hinf(0.1), [0.8, 1.2, 1.6]
    curves = exact_curves(given_at, absorber, 0.01, excitation)
    assert set(given_at) < set(curves["frequency_ratio"])
    assert (np.diff(curves["frequency_ratio"]) > 0).all()
    peak = highest(absorber, 0.01, excitation, (0.8, 1.6))
    assert max(curves["tmd"]) == pytest.approx(peak.value, rel=1e-12)
    # 1/(2 ζ √(1 − ζ²)) under a force; more by √(1 + 4 ζ² r²) on a shaken base
    assert max(curves["no_damper"]) == pytest.approx(50.0, rel=1e-3)


def test_one_frequency_stays_one():
    curves = exact_curves([1.1], exact_hinf(0.1), 0.01)
    assert curves["frequency_ratio"] == [1.1]
    assert len(curves["tmd"]) == len(curves["no_damper"]) == 1


@pytest.mark.parametrize("absorber", [exact_hinf(0.1), Absorber(0.1, 0.9, 0.0), Absorber(1e-12, 1.0, 1e-6)])
def test_splitting_ends_beside_an_undamped_resonance(absorber):
    curves = exact_curves(np.linspace(0.0, 3.0, 31), absorber)
    assert curves["no_damper"][curves["frequency_ratio"].index(1.0)] == np.inf
    assert len(curves["frequency_ratio"]) < 1000
