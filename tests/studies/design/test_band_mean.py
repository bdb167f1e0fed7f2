"""The rms over the band: closed forms, its stated error, and designs by it against brute force."""

import math
from typing import Any

import numpy as np
import pytest
from tests.studies.design.test_design import DAMPED, pursued
from tests.studies.documents import faults_of

from damperlab.studies.design.absorber import tuned_beside
from damperlab.studies.design.answer import answer_document
from damperlab.studies.design.curve import BandMean, band_mean, halved
from damperlab.studies.design.found import Found
from damperlab.studies.design.frequencies import Survey
from damperlab.studies.design.words import details_of
from damperlab.studies.specification.reading import parse_specification

FLOOR: dict[str, Any] = DAMPED | {"measure": "rms_displacement", "tolerances": {}, "builds": 0}


def resonance(r: np.ndarray, zeta: float) -> np.ndarray:
    """A response whose square is a Lorentzian of half width ζ about r = 1."""
    return (1.0 + ((r - 1.0) / zeta) ** 2) ** -0.5


@pytest.mark.parametrize("zeta", [0.002, 0.005, 0.02, 0.1])
def test_a_resonance_sampled_by_the_survey_is_integrated_within_the_stated_error(zeta: float) -> None:
    asked = parse_specification(FLOOR | {"structure": FLOOR["structure"] | {"damping_ratio": zeta}})
    survey = Survey.of(asked, asked.excitations[0])
    r = np.array(survey.sample(0.1, 0.0, True))
    low, high = r[[0, -1]]
    integral = zeta * (math.atan((high - 1.0) / zeta) - math.atan((low - 1.0) / zeta))
    truth = math.sqrt(integral / (high - low))
    before = math.inf
    for _ in range(4):
        found = band_mean(r, resonance(r, zeta), np.zeros_like(r))
        assert abs(found.value - truth) <= found.between < before
        before = found.between
        r = np.union1d(r, halved(r, resonance(r, zeta)))
    assert found.between <= 0.02 * truth


def test_errors_of_the_responses_add_up_as_independent_ones() -> None:
    rng = np.random.default_rng(5)
    r = np.sort(rng.uniform(0.9, 1.1, 60))
    values, errors = 2.0 + np.sin(20.0 * r), 0.02 + 0.05 * rng.uniform(size=60)
    truth = band_mean(r, values, errors)
    drawn = [band_mean(r, values + errors * rng.normal(size=60), errors).value for _ in range(4000)]
    # the standard error of a standard deviation of n normal numbers is 1/√(2n) of it
    assert np.std(drawn) == pytest.approx(truth.error, rel=4.0 / math.sqrt(8000.0))


def test_a_response_that_is_the_same_everywhere_is_its_own_rms() -> None:
    r = np.array([0.9, 0.95, 1.0, 1.3])
    assert band_mean(r, np.full(4, 3.0), np.zeros(4)).value == pytest.approx(3.0, rel=1e-15)
    assert band_mean(r, np.full(4, 3.0), np.zeros(4)).between == pytest.approx(0.0, abs=1e-12)
    assert band_mean(r[:1], np.array([3.0]), np.array([0.1])) == BandMean(3.0, 0.0, 0.1)
    assert band_mean(r, np.zeros(4), np.zeros(4)).value == 0.0
    assert band_mean(r, np.array([1.0, np.inf, 1.0, 1.0]), np.zeros(4)).value == np.inf
    assert halved(r, np.full(4, 3.0)) == ()


@pytest.fixture(scope="module")
def floor() -> Found:
    return pursued(FLOOR)[0]


@pytest.mark.night
def test_an_rms_over_the_band_is_told_without_a_frequency(floor) -> None:
    assert ", near" not in details_of(floor, "hybrid")[1]
    worst = answer_document(floor)["worst"]
    assert worst["measure"] == "rms_displacement"
    assert worst["frequency_hz"] is worst["frequency_ratio"] is None
    assert worst["ratio"] == pytest.approx(worst["value"] / 0.001, rel=1e-12)
    for each in answer_document(floor)["amplitudes"]:
        assert each["worst"] < max(each["value"])
        assert each["worst_ratio"] is each["worst_frequency_hz"] is None


def test_the_tuned_mass_damper_is_held_against_the_limits_too() -> None:
    asked = parse_specification(
        FLOOR | {"measure": "worst_displacement", "limits": {"displacement_m": 0.005}}
    )
    kept = tuned_beside(asked, 0.1)
    assert kept.exceeded == {}
    # tuned for every frequency it would reach 3.994 mm in closed form, for those of the band 3.809 mm
    assert kept.value == pytest.approx(0.003809, rel=3e-3)
    below = {"displacement_m": 0.0038, "impact_speed_m_per_s": 1e-6, "acceleration_m_per_s2": 0.1}
    exceeds = tuned_beside(
        parse_specification(FLOOR | {"limits": below, "measure": "worst_displacement"}), 0.1
    )
    assert list(exceeds.exceeded) == ["displacement_m", "acceleration_m_per_s2"]
    assert exceeds.exceeded["displacement_m"] == exceeds.value


@pytest.mark.parametrize("under", ["records", "both"])
def test_a_record_has_no_band(under: str) -> None:
    band = FLOOR["excitation"] | {"name": "hum"}
    sweep = {
        "name": "test",
        "sweep": {"base_amplitude_m": 0.001, "start_hz": 6.0, "stop_hz": 10.0, "rate_hz_per_s": 1.0},
    }
    excitation = [sweep, band] if under == "both" else [sweep]
    (fault,) = faults_of(parse_specification, FLOOR | {"excitation": excitation})
    assert fault.field == "measure"
    assert "`worst_rms_displacement`" in str(fault)
