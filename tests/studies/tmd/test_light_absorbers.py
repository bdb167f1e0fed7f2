"""Peaks and tunings of absorbers of any mass, against the equations of motion solved in fifty digits."""

import math

import mpmath as mp
import pytest
from numpy.polynomial import Polynomial

from damperlab.studies.tmd.absorber import Absorber
from damperlab.studies.tmd.minimax import minimax
from damperlab.studies.tmd.transfer import highest
from damperlab.studies.tmd.tunings import exact_hinf

DIGITS = 50


def ratio(lam: mp.mpf, absorber: Absorber, structural: float) -> mp.mpf:
    """|X/Z| by solving the two equations of motion of structure and absorber, base excited."""
    mu, gamma, zeta = (mp.mpf(x) for x in (absorber.mass_ratio, absorber.tuning, absorber.damping_ratio))
    base = 1 + 2j * mp.mpf(structural) * lam
    link = gamma**2 + 2j * zeta * gamma * lam
    # (base + mu link - lam^2) x - mu link y = base z;  link x = (link - lam^2) y
    return abs(base * (link - lam**2) / ((base + mu * link - lam**2) * (link - lam**2) - mu * link**2))


def greatest(absorber: Absorber, structural: float) -> mp.mpf:
    """The largest |X/Z| where |num|²/|den|², a ratio of polynomials in s = lam², is stationary: all roots, in fifty digits."""
    with mp.workdps(DIGITS):
        mu, gamma, zeta, zs = (
            mp.mpf(x) for x in (absorber.mass_ratio, absorber.tuning, absorber.damping_ratio, structural)
        )
        g2, cross = gamma**2, 2 * zeta * gamma
        s = Polynomial([mp.mpf(0), mp.mpf(1)])
        # the determinant det = (1 + 2 i zs l + mu L - s)(L - s) - mu L^2, L = g2 + i cross l, l^2 = s, by parts
        first_re, first_im = 1 + mu * g2 - s, 2 * zs + mu * cross
        link_re, link_im = g2 - s, cross
        den_re = first_re * link_re - s * first_im * link_im - (mu * g2**2 - mu * cross**2 * s)
        den_im = first_re * link_im + first_im * link_re - 2 * mu * g2 * cross
        num = (link_re**2 + s * link_im**2) * (1 + 4 * zs**2 * s)
        den = den_re**2 + s * den_im**2
        stationary = (num.deriv() * den - num * den.deriv()).trim().coef.tolist()
        roots = mp.polyroots(stationary, maxsteps=1000, extraprec=1000, asc=True)
        places = [root.real for root in roots if root.real > 0 and abs(root.imag) < 1e-20 * root.real]
        return max(mp.mpf(1), *(ratio(mp.sqrt(place), absorber, structural) for place in places))


EXTREMES = [
    (1e-4, 1.0, 6e-3, 0.0),
    (1e-10, 1.0, 6e-6, 1e-7),
    (1e-12, 1.000001, 1e-7, 1e-9),
    (0.1, 0.9, 1e-6, 0.0),
    (0.1, 3.0, 0.01, 1e-6),
    (10.0, 0.09, 0.6, 0.0),
    (10.0, 0.0009, 0.3, 1e-4),
    (1e-3, 11.0, 4.0, 1e-5),
]


@pytest.mark.parametrize(("mu", "tuning", "zeta", "structural"), EXTREMES)
def test_the_peak_of_an_extreme_absorber_is_that_in_fifty_digits(mu, tuning, zeta, structural):
    absorber = Absorber(mu, tuning, zeta)
    exact = greatest(absorber, structural)
    found = highest(absorber, structural)
    # lam is a double next to a resonance of relative width w: what is a rounding of it is a rounding/w of the slope
    width = max(zeta, structural, 1e-9)
    assert found.value == pytest.approx(float(exact), rel=1e-11 + 1e-16 / width)
    with mp.workdps(DIGITS):
        there = ratio(mp.mpf(found.frequency_ratio), absorber, structural)
    assert float(there) == pytest.approx(float(exact), rel=1e-8)


@pytest.mark.parametrize("mu", [1e-12, 1e-4, 10.0])
def test_minimax_of_any_mass_is_the_closed_form_without_structural_damping(mu):
    found, exact = minimax(mu, 0.0), exact_hinf(mu)
    width = min(1.0, math.sqrt(mu))
    # the tuning is a double next to 1, the resonance as wide as the root of the mass ratio
    assert abs(found.tuning - exact.tuning) <= width * 1e-9 + 2e-16
    assert found.damping_ratio == pytest.approx(exact.damping_ratio, rel=1e-8)
    with mp.workdps(DIGITS):
        assert highest(found).value == pytest.approx(tuned_mass_peak(mu), rel=1e-10 + 2e-16 / width)


def tuned_mass_peak(mu: float) -> float:
    """Nishihara and Asami's closed form of the peak, in fifty digits: in doubles it cancels."""
    with mp.workdps(DIGITS):
        m = mp.mpf(mu)
        q = mp.sqrt(4 + 3 * m)
        inner = ((8 + 9 * m) ** 2 * (16 + 9 * m) - 128 * q**3) / (3 * (32 + 27 * m))
        return float(mp.sqrt(inner) / (3 * m))


@pytest.mark.parametrize("excitation", ["base", "force"])
def test_a_structure_whose_response_never_exceeds_rest_is_left_at_that(excitation):
    found = minimax(1e-3, 2.0, excitation)
    # a force on an overdamped structure: at most the static deflection, with or without an absorber
    assert highest(found, 2.0, excitation).value <= highest(Absorber(0.0, 1.0, 1.0), 2.0, excitation).value
