"""The parts of a design against closed forms and independent methods."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import betaincinv
from tests.studies.specification.test_specification import PROTOTYPE, changed

from damperlab.studies.design.absorber_structure import built
from damperlab.studies.design.alternatives import without
from damperlab.studies.design.build import Build
from damperlab.studies.design.builds import clopper_pearson
from damperlab.studies.design.frequencies import CLOSER, SHOWN, Survey, between, brackets, rise
from damperlab.studies.design.space import HADAMARD, corners_of
from damperlab.studies.design.words import words_of_structure
from damperlab.studies.specification.reading import parse_specification
from damperlab.studies.tmd.absorber import Absorber


@pytest.mark.parametrize(("passed", "drawn"), [(0, 10), (3, 10), (10, 10), (57, 60), (60, 60), (1, 1000)])
@pytest.mark.parametrize("confidence", [0.5, 0.9, 0.999])
def test_the_interval_of_a_probability_is_that_of_the_beta_distribution(
    passed: int, drawn: int, confidence: float
) -> None:
    tail = (1 - confidence) / 2
    low = 0.0 if passed == 0 else betaincinv(passed, drawn - passed + 1, tail)
    high = 1.0 if passed == drawn else betaincinv(passed + 1, drawn - passed, 1 - tail)
    assert clopper_pearson(passed, drawn, confidence) == pytest.approx((low, high), rel=1e-9)


@pytest.mark.night
@given(
    zeta=st.floats(0.001, 0.05),
    mass=st.floats(0.0, 0.3),
    low=st.floats(0.3, 0.9),
    high=st.floats(1.02, 3.0),
)
def test_the_peak_of_a_structure_is_found_whether_its_particle_rides_or_not(
    zeta: float, mass: float, low: float, high: float
) -> None:
    """A particle that rides makes the structure one of mass 1 + β: its resonance is as narrow as the structure's own."""
    document = changed("structure.damping_ratio", zeta) | {"particle_mass_kg": mass * 1.605}
    document["excitation"] = {
        "base_amplitude_m": 0.0015,
        "frequency_hz": {"start": 2.5 * low, "stop": 2.5 * high},
    }
    asked = parse_specification(document)
    survey = Survey.of(asked, asked.excitations[0])
    for added in (0.0, mass / 3, mass):

        def response(r: np.ndarray, added: float = added) -> np.ndarray:
            dashpot = 2j * zeta * r
            return np.abs((1 + dashpot) / (1 + dashpot - (1 + added) * r**2))

        r = np.array(survey.sample(mass, 0.0, fine=True))
        for _ in range(2):
            r = np.union1d(r, brackets(r, response(r)))
        values = response(r)
        truth = response(np.linspace(low, high, 200_001)).max()
        # two rounds of brackets leave steps of an eighth of ζ at most: (1/16)² / 2 of the height between two of them
        assert values.max() >= truth * (1 - 0.01)
        assert values.max() + rise(r, values) >= truth * (1 - 0.005)


def test_a_peak_on_a_flank_is_looked_for_between_the_samples() -> None:
    def response(r: np.ndarray) -> np.ndarray:
        return r + 0.1 * np.exp(-(((r - 0.9243) / 0.0015) ** 2))

    r = np.arange(0.8, 1.0, 0.008)
    values = response(r)
    truth = response(np.linspace(0.8, 1.0, 200_001)).max()
    assert response(np.union1d(r, brackets(r, values))).max() < 0.99 * truth
    more = np.union1d(r, between(r, values))
    # at most half a step from the top of a bump of 0.1
    assert response(more).max() >= truth - 0.1 * (1 - np.exp(-((CLOSER / 2 / 0.0015) ** 2)))
    high = values >= SHOWN * values.max()
    near = (more[1:] > r[high][0]) & (more[:-1] < r[high][-1])
    assert np.diff(more)[near].max() <= CLOSER + 1e-9
    assert set(np.setdiff1d(more, r)) == set(between(r, values))
    assert not [each for each in between(r, values) if each < r[high][0] - 0.008]


def test_tolerances_move_the_ratios_as_the_physics_does() -> None:
    asked = parse_specification(
        PROTOTYPE | {"tolerances": {"natural_frequency_hz": "2%", "mass_kg": "5%", "particle_mass_kg": "1%"}}
    )
    nominal = Build(0.006, 0.3, 0.1605, 0.47)
    moved = nominal.moved(asked, {"natural_frequency_hz": 1.0, "mass_kg": -1.0, "particle_mass_kg": 1.0})
    mass = 1.605 * 0.95
    stiffness = mass * (2 * math.pi * 2.5 * 1.02) ** 2
    damping, restitution, ratio, clearance, friction = moved.place(asked.structure, 0.0015)
    assert (damping, restitution, clearance) == (0.0038, 0.47, pytest.approx(4.0))
    assert ratio == pytest.approx(0.1605 * 1.01 / mass, rel=1e-14)
    assert friction == pytest.approx(0.3 / (stiffness * 0.0015), rel=1e-14)
    assert moved.nominal(moved.own(1.1)) == pytest.approx(1.1, rel=1e-15)


@pytest.mark.parametrize("dashpot", [False, True])
@pytest.mark.parametrize("stiffness", [False, True])
def test_a_tolerance_of_the_mass_leaves_what_was_given(stiffness: bool, dashpot: bool) -> None:
    """Ratios of a damper on M ± 10 % from M, k and c themselves; so for the tuned mass damper on the same structure."""
    mass, k, c, omega = 1.605, 400.0, 0.5, math.sqrt(400.0 / 1.605)
    zeta = c / (2.0 * math.sqrt(k * mass))
    spring = {"stiffness_n_per_m": k} if stiffness else {"natural_frequency_hz": omega / (2.0 * math.pi)}
    viscous = {"damping_n_s_per_m": c} if dashpot else {"damping_ratio": zeta}
    asked = parse_specification(
        PROTOTYPE | {"structure": {"mass_kg": mass, **spring, **viscous}, "tolerances": {"mass_kg": "10%"}}
    )
    for side in (-1.0, 1.0):
        own = mass * (1.0 + 0.1 * side)
        own_k = k if stiffness else own * omega**2
        own_omega = math.sqrt(own_k / own)
        own_zeta = c / (2.0 * math.sqrt(own_k * own)) if dashpot else zeta
        moved = Build(0.006, 0.3, 0.1605, 0.47).moved(asked, {"mass_kg": side})
        assert moved.place(asked.structure, 0.0015) == pytest.approx(
            (own_zeta, 0.47, 0.1605 / own, 4.0, 0.3 / (own_k * 0.0015)), rel=1e-13
        )
        assert moved.rate(asked) == pytest.approx(own_omega, rel=1e-13)
        on = built(asked, Absorber(0.1, 0.9, 0.2), {"mass_kg": 0.1 * side})
        assert (on.damping, on.stiffness) == pytest.approx((own_zeta, own_k / k), rel=1e-13)
        assert (on.absorber.mass_ratio, on.absorber.tuning) == pytest.approx(
            (0.1 * mass / own, 0.9 * omega / own_omega), rel=1e-13
        )
    (said,) = words_of_structure(asked)
    assert (
        f"leaves {'stiffness' if stiffness else 'natural frequency'} and {'dashpot' if dashpot else 'damping ratio'}"
        in said
    )


def test_a_band_is_sampled_at_every_frequency_that_a_mass_on_given_springs_may_have() -> None:
    """M ± 30 % on given springs: the lowest frequency of the band is lowest over that of the lightest structure."""
    structure = {"mass_kg": 1.605, "stiffness_n_per_m": 400.0, "damping_ratio": 0.004}
    asked = parse_specification(
        PROTOTYPE
        | {
            "structure": structure,
            "tolerances": {"mass_kg": "30%"},
            "excitation": {"base_amplitude_m": 0.0015, "frequency_ratio": {"start": 0.5, "stop": 2.0}},
        }
    )
    survey = Survey.of(asked, asked.excitations[0])
    step = max(np.diff(np.log([r for r in survey.fine if r < 0.9])))
    assert math.log(survey.fine[0] / (0.5 * math.sqrt(0.7))) < 1.01 * step
    step = max(np.diff(np.log([r for r in survey.fine if r > 1.1])))
    assert math.log(2.0 * math.sqrt(1.3) / survey.fine[-1]) < 1.01 * step


def test_corners_are_all_of_a_few_tolerances_and_a_fraction_of_many() -> None:
    assert len(corners_of(parse_specification(PROTOTYPE))) == 4
    many = dict.fromkeys(("clearance_m", "friction_force_n", "restitution", "mass_kg", "damping_ratio"), "1%")
    corners = corners_of(parse_specification(PROTOTYPE | {"tolerances": many}))
    assert len(corners) == 8
    assert all(set(corner.values()) <= {-1.0, 1.0} and corner.keys() == many.keys() for corner in corners)
    # balanced: each quantity up as often as down, also beside each other one
    signs = np.column_stack((np.ones(8), HADAMARD))
    assert (signs.T @ signs == 8.0 * np.eye(8)).all()
    assert corners_of(parse_specification(PROTOTYPE | {"tolerances": {}})) == []


def test_a_part_that_is_left_out_takes_its_tolerance_along() -> None:
    asked = parse_specification(PROTOTYPE)
    alone = without(asked, ("friction_force_n",))
    assert alone.free == ("clearance_m",)
    assert "friction_force_n" not in alone.tolerances
