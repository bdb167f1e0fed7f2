"""Tuned mass dampers: the transfer function, its peaks and the tunings, against an independent oracle."""

import math

import numpy as np
import pytest
from scipy.linalg import solve_continuous_lyapunov
from scipy.optimize import minimize
from tests.oracles import transmissibility, tuned_mass

from damperlab.studies.tmd.absorber import Absorber
from damperlab.studies.tmd.minimax import minimax
from damperlab.studies.tmd.transfer import amplitude_ratio, highest, peaks, without_absorber
from damperlab.studies.tmd.tunings import den_hartog, den_hartog_table4, exact_hinf, tuned
from damperlab.studies.vocabulary import CRITERIA

MASSES = [0.01, 0.05, 0.1, 0.2, 1.0]


@pytest.mark.parametrize("structural", [0.0, 0.0038, 0.05, 0.3])
def test_transfer_function_is_that_of_the_two_equations_of_motion(structural):
    r = np.linspace(0.0, 2.5, 101)
    absorber = Absorber(0.1, 0.93, 0.12)
    # a few dozen roundings, magnified near the zero of the denominator by less than 100
    np.testing.assert_allclose(
        amplitude_ratio(r, absorber, structural),
        tuned_mass.amplitude_ratio(r, 0.1, 0.93, 0.12, structural),
        rtol=1e-12,
    )
    if structural == 0.0:
        printed = tuned_mass.equation_13(r, 0.1, 0.93, 0.12)
        np.testing.assert_allclose(amplitude_ratio(r, absorber), printed, rtol=1e-12)


def test_force_and_base_differ_by_the_force_of_the_structures_own_dashpot():
    r = np.linspace(0.1, 2.0, 20)
    absorber = exact_hinf(0.1)
    ratio = amplitude_ratio(r, absorber, 0.05, "base") / amplitude_ratio(r, absorber, 0.05, "force")
    np.testing.assert_allclose(ratio, np.hypot(1, 0.1 * r), rtol=1e-13)
    undamped = amplitude_ratio(r, absorber, 0.0, "base"), amplitude_ratio(r, absorber, 0.0, "force")
    np.testing.assert_array_equal(*undamped)


def test_no_absorber_leaves_the_structure():
    for r in (0.3, 1.0, 1.7):
        bare = transmissibility.absolute_amplitude(0.05, r)
        assert float(without_absorber(r, 0.05)) == pytest.approx(bare, rel=1e-14)
    assert highest(Absorber(0.0, 1.0, 1.0), 0.0).value == math.inf


def test_undamped_absorber_moves_the_infinite_peak_and_stills_its_own_frequency():
    absorber = Absorber(0.1, 1.0, 0.0)
    assert float(amplitude_ratio(1.0, absorber)) == 0.0
    assert highest(absorber).value == math.inf
    # between the two poles, 0.854 and 1.171 for this absorber, the response is finite
    inside = highest(absorber, band=(0.95, 1.05))
    sweep = amplitude_ratio(np.linspace(0.95, 1.05, 1001), absorber)
    assert inside.value == pytest.approx(sweep.max(), rel=1e-12)


@pytest.mark.parametrize("mass_ratio", MASSES)
def test_exact_hinf_is_nishihara_and_asami(mass_ratio):
    tuning, damping, peak = tuned_mass.exact_optimum(mass_ratio)
    found = exact_hinf(mass_ratio)
    # the published form cancels to about 1e-16 / mass ratio
    assert found.tuning == pytest.approx(tuning, rel=1e-13)
    assert found.damping_ratio == pytest.approx(damping, rel=1e-11)
    assert highest(found).value == pytest.approx(peak, rel=1e-11)
    level = peaks(found)
    assert level[0].value == pytest.approx(level[2].value, rel=1e-11)


@pytest.mark.parametrize(("mass_ratio", "structural"), [(0.1, 0.0038), (0.2, 0.05)])
def test_minimax_is_the_least_peak_that_a_simplex_over_sweeps_finds(mass_ratio, structural):
    tuning, damping, peak = tuned_mass.minimax(mass_ratio, structural)
    found = minimax(mass_ratio, structural)
    assert highest(found, structural).value == pytest.approx(peak, abs=1e-11)
    # the simplex ends at 1e-9; the peak is flat along the ridge of level peaks, so damping is known to about 1e-8
    assert found.tuning == pytest.approx(tuning, abs=1e-8)
    assert found.damping_ratio == pytest.approx(damping, abs=1e-7)


@pytest.mark.parametrize(
    ("mass_ratio", "structural", "excitation"),
    [(0.01, 0.3, "base"), (1.0, 0.1, "force"), (0.1, 0.0038, "force"), (5.0, 0.0, "base")],
)
def test_no_neighbour_of_the_minimax_is_better(mass_ratio, structural, excitation):
    found = minimax(mass_ratio, structural, excitation)
    best = highest(found, structural, excitation).value
    for angle in np.arange(12) * math.pi / 6:
        near = found.detuned(1e-3 * math.cos(angle), 3e-3 * math.sin(angle))
        assert highest(near, structural, excitation).value > best


def test_table_4_is_den_hartog_in_the_other_convention():
    right = den_hartog(0.1)
    assert (round(right.tuning, 4), round(right.damping_ratio, 4)) == (0.9091, 0.1846)
    assert round(right.damping_over_structure, 4) == 0.1679
    # Table 4 read over the structure's frequency is the same absorber, but for its four digits
    read = Absorber(0.1, 0.9091, 0.1679 / 0.9091)
    assert read.damping_ratio == pytest.approx(right.damping_ratio, abs=1e-4)
    assert round(highest(right).value, 4) == 4.5902
    # and put into (13) unconverted
    assert round(highest(Absorber(0.1, 1 / 1.1, 0.1679)).value, 4) == 4.6765
    assert highest(den_hartog_table4(0.1)).value == pytest.approx(4.6765, abs=5e-4)
    assert round(highest(exact_hinf(0.1)).value, 5) == 4.58917


def mean_square(absorber: Absorber, excitation: str) -> float:
    """Variance of the structure under white noise, by the Lyapunov equation; against the base where that is shaken."""
    mu, link = absorber.mass_ratio, absorber.mass_ratio * absorber.tuning
    spring, dashpot = link * absorber.tuning, 2.0 * absorber.damping_ratio * link
    between = np.array([[1.0, -1.0], [-1.0, 1.0]])
    inertia = np.diag([1.0, mu])
    load = np.array([-1.0, -mu]) if excitation == "base" else np.array([1.0, 0.0])
    motion = np.zeros((4, 4))
    motion[:2, 2:] = np.eye(2)
    motion[2:] = np.linalg.solve(
        inertia, -np.hstack([np.diag([1.0, 0.0]) + spring * between, dashpot * between])
    )
    noise = np.concatenate([np.zeros(2), np.linalg.solve(inertia, load)])
    return float(solve_continuous_lyapunov(motion, -np.outer(noise, noise))[0, 0])


@pytest.mark.parametrize(
    ("excitation", "mass_ratio"), [("base", 0.01), ("base", 0.1), ("force", 0.1), ("force", 1.0)]
)
def test_h2_has_the_least_mean_square(excitation, mass_ratio):
    best = tuned("h2", mass_ratio, excitation=excitation)

    def lost(share):
        return mean_square(best.detuned(*share), excitation)

    found = minimize(lost, [0.05, -0.05], method="Nelder-Mead", options={"xatol": 1e-8, "fatol": 1e-16})
    # the bottom is flat: half the digits of its height are all of its place
    assert found.x == pytest.approx([0.0, 0.0], abs=1e-6)
    if mass_ratio == 0.1:
        assert round(best.tuning, 3) == (0.886 if excitation == "base" else 0.932)


def test_every_criterion_tunes_and_detuning_does_harm():
    for criterion in CRITERIA:
        absorber = tuned(criterion, 0.1, 0.0038)
        assert absorber.mass_ratio == 0.1
    best = tuned("minimax", 0.1, 0.0038)
    heights = [highest(best.detuned(share), 0.0038).value for share in (0.0, 0.02, 0.05, 0.1)]
    assert heights == sorted(heights)
    assert heights[-1] > 1.4 * heights[0]
    assert best.detuned(0.1).tuning == pytest.approx(1.1 * best.tuning, rel=1e-15)


@pytest.mark.parametrize(("mu", "zeta"), [(0.1, 0.0038), (1e-4, 0.0), (0.3, 0.05)])
def test_of_peaks_of_one_height_the_lowest_frequency_is_said(mu, zeta):
    """The best tuning makes two: which of them rounding makes the higher is a matter of the processor."""
    absorber = minimax(mu, zeta)
    every = peaks(absorber, zeta)
    most = max(peak.value for peak in every)
    places = [peak.frequency_ratio for peak in every if peak.value >= most * (1 - 1e-9)]
    assert places[-1] > places[0]
    assert highest(absorber, zeta).frequency_ratio == pytest.approx(places[0], rel=1e-9)
