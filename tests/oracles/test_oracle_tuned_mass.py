"""The tuned-mass oracle against other forms of itself."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.oracles import transmissibility, tuned_mass


def test_complex_solution_equals_equation_13() -> None:
    r = np.linspace(0.05, 2.0, 79)
    # 1e-12: both are a few dozen roundings, the near-cancellation at r = tuning included.
    np.testing.assert_allclose(
        tuned_mass.amplitude_ratio(r, 0.1, 0.9, 0.17), tuned_mass.equation_13(r, 0.1, 0.9, 0.17), rtol=1e-12
    )


def test_no_absorber_mass_leaves_the_bare_structure() -> None:
    for r in (0.3, 1.0, 1.7):
        bare = transmissibility.absolute_amplitude(0.05, r)
        assert float(tuned_mass.amplitude_ratio(r, 0.0, 0.9, 0.2, 0.05)) == pytest.approx(bare, rel=1e-14)


@pytest.mark.parametrize("mu", [0.01, 0.1, 1.0])
def test_closed_form_optimum_is_the_least_peak(mu: float) -> None:
    tuning, zeta, height = tuned_mass.exact_optimum(mu)
    # The sweep finds the top of a smooth hump to 1e-9 in r, so its height to about 1e-16 times the curvature.
    assert tuned_mass.peak(mu, tuning, zeta) == pytest.approx(height, rel=1e-12)
    for d_tuning, d_zeta in ((1e-4, 0), (-1e-4, 0), (0, 1e-3), (0, -1e-3)):
        assert tuned_mass.peak(mu, tuning + d_tuning, zeta + d_zeta) > height


def test_numerical_minimax_finds_the_closed_form() -> None:
    tuning, zeta, height = tuned_mass.exact_optimum(0.1)
    found = tuned_mass.minimax(0.1)
    # The peak is |.|-shaped in the tuning but flat in no direction: simplex size 1e-9, slope of order 10.
    assert found == pytest.approx((tuning, zeta, height), abs=1e-7)


def test_den_hartog_fixed_points_are_level() -> None:
    mu = 0.1
    tuning, zeta = tuned_mass.den_hartog(mu)
    # At the fixed points r^2 = 1/(1 + mu) (1 -+ sqrt(mu/(2 + mu))) X/Z is sqrt(1 + 2/mu) for any damping.
    for sign in (-1, 1):
        r = math.sqrt((1 + sign * math.sqrt(mu / (2 + mu))) / (1 + mu))
        for damping in (zeta, 0.05):
            height = float(tuned_mass.equation_13(r, mu, tuning, damping))
            assert height == pytest.approx(math.sqrt(1 + 2 / mu), rel=1e-12)
    assert tuned_mass.peak(mu, tuning, zeta) > tuned_mass.exact_optimum(mu)[2]
