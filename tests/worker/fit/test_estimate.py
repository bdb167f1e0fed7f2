"""Fits of measurements whose truth is known."""

from typing import Any

import numpy as np
import pytest
from tests.synthetic import NOISE, RANGES, made

from damperlab.studies.fit.asking import make_question
from damperlab.studies.fit.fitted import Fitted
from damperlab.studies.fit.measured import Measurement
from damperlab.studies.fit.verdict import verdict
from damperlab.studies.tmd.transfer import without_absorber
from damperlab.worker.fit import estimate
from damperlab.worker.fit.estimate import fit_response
from damperlab.worker.fit.model import responses_at


def in_halves(fitted: Fitted, truth: dict[str, float]) -> list[float]:
    """How far each truth is from the middle of its interval, in halves of it."""
    return [
        abs(truth[each.name] - 0.5 * (each.low + each.high)) / (0.5 * (each.high - each.low))
        for each in fitted.estimates
    ]


def said(fitted: Fitted) -> str:
    return " ".join(verdict(fitted))


def refitted(
    structure: dict[str, Any],
    fit: dict[str, Any],
    truth: dict[str, float],
    columns: dict[str, Any],
    seed: int = 0,
    share: float | None = 0.02,
) -> Fitted:
    """Compute what a prototype of a truth would show, add 2 % of noise, and fit it."""
    name = "amplitude_m" if "base_amplitude_m" in columns else "amplitude_ratio"
    blank = make_question(
        Measurement("", columns | {name: np.ones(len(next(iter(columns.values()))))}), structure, fit
    )
    true = responses_at(blank, truth).amplitude
    noise = np.random.default_rng(seed).standard_normal(true.size)
    measured = Measurement("made", columns | {name: true * np.exp(0.02 * noise)})
    return fit_response(make_question(measured, structure, fit, share=share))


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few responses and short chains, for what is said of a fit and not for how wide its intervals are."""
    monkeypatch.setattr(estimate, "START", {2: 80})
    monkeypatch.setattr(estimate, "MOST_ROUNDS", 5)
    monkeypatch.setattr(estimate, "STEPS", 80)
    monkeypatch.setattr(estimate, "LAST_STEPS", 300)


@pytest.mark.night
@pytest.mark.parametrize("kind", ["particle", "hybrid"])
def test_parameters_of_a_particle_come_back_though_its_response_jumps(kind: str) -> None:
    one = made(kind, 1)
    fitted = fit_response(one.question)
    # Four times the half interval is eight standard deviations.
    assert max(in_halves(fitted, one.truth)) < 4
    assert all(each.high - each.low < 0.5 * RANGES[kind][each.name][1] for each in fitted.estimates)
    assert fitted.probability > 1e-4


def test_the_linear_structure_gives_its_damping_back_with_the_error_of_least_squares() -> None:
    r = np.linspace(0.9, 1.1, 21)
    zeta = 0.05
    exact = np.array([float(without_absorber(one, zeta)) for one in r])
    measured = Measurement("linear", {"frequency_ratio": r, "amplitude_ratio": exact}, 0.01 * exact)
    structure = {"particle": False, "axes": {"friction_ratio": 0.0}}
    step = 1e-6
    slope = np.array([float(without_absorber(one, zeta + step)) for one in r])
    slope = (slope - np.array([float(without_absorber(one, zeta - step)) for one in r])) / (2 * step)
    expected = 1 / np.sqrt(((slope / (0.01 * exact)) ** 2).sum())
    widths = []
    for seed in range(2):
        asked = make_question(measured, structure, {"damping_ratio": (0.01, 0.2)}, seed=seed)
        (found,) = fit_response(asked).estimates
        assert found.value == pytest.approx(zeta, abs=expected)
        assert found.low < zeta < found.high
        widths.append((found.high - found.low) / (2 * 1.96 * expected))
    # The interval is that of ±1.96 standard errors. Its ends are known to 48·600/30 draws: a width to some 5 %, the mean of
    # two to 4 %. An interval of 90 % is narrower by 16 %.
    assert np.mean(widths) == pytest.approx(1.0, abs=0.08)


@pytest.mark.usefixtures("quick")
def test_without_deviations_the_scatter_is_estimated_and_nothing_is_said_of_chi_square() -> None:
    one = made("friction", 2)
    measured = Measurement("bare", one.question.measured.columns)
    structure = {"particle": False}
    fitted = fit_response(make_question(measured, structure, dict(RANGES["friction"])))
    share = float(np.median(fitted.deviation / measured.amplitude))
    # The root of chi-square over its 23 degrees of freedom is within 1 ± 4/√46.
    assert share == pytest.approx(NOISE, rel=4 / np.sqrt(46))
    assert fitted.probability is None
    assert "standard deviation" in said(fitted)


@pytest.mark.usefixtures("quick")
def test_a_wrong_row_is_named_and_decides_nothing() -> None:
    one = made("friction", 4)
    columns = dict(one.question.measured.columns)
    columns["amplitude_ratio"] = columns["amplitude_ratio"].copy()
    columns["amplitude_ratio"][5] *= 1.5
    measured = Measurement("wrong", columns, one.question.measured.deviation)
    fitted = fit_response(make_question(measured, {"particle": False}, dict(RANGES["friction"])))
    assert fitted.outliers == [5]
    assert "row 6" in said(fitted)
    assert max(in_halves(fitted, one.truth)) < 3


@pytest.mark.usefixtures("quick")
def test_a_particle_that_never_strikes_tells_nothing_about_itself() -> None:
    r = np.linspace(0.5, 0.7, 9)
    structure = {"axes": {"mass_ratio": 0.1, "clearance_ratio": 20.0, "friction_ratio": 0.1}}
    truth = {"restitution": 0.5, "damping_ratio": 0.3}
    fit = {"restitution": None, "damping_ratio": (0.1, 0.9)}
    fitted = refitted(structure, fit, truth, {"frequency_ratio": r})
    restitution, damping = fitted.estimates
    assert fitted.never_strikes
    assert not restitution.determined
    assert damping.determined
    assert "strikes" in said(fitted)


@pytest.mark.night
def test_friction_that_locks_the_structure_is_known_from_below_only() -> None:
    # The first slip from rest leaves an offset that falls with the friction, here from 6 % of Z on: less than the deviation.
    r = np.linspace(0.5, 0.8, 9)
    structure = {"particle": False, "damping_ratio": 0.01}
    fit, truth = {"friction_ratio": (0.0, 2.0)}, {"friction_ratio": 1.5}
    fitted = refitted(structure, fit, truth, {"frequency_ratio": r}, share=0.3)
    (friction,) = fitted.estimates
    assert fitted.always_sticks
    assert not friction.bounded_above
    assert friction.low > 0.1
    assert "locks" in said(fitted)


@pytest.mark.night
def test_parameters_that_only_act_together_are_named_as_a_pair() -> None:
    # With e = 0 and hardly any clearance the particle rides on its wall: the structure has the mass 1 + β, and below
    # resonance nothing but its natural frequency f_n/√(1 + β) shows.
    f = np.linspace(1.6, 2.2, 15)
    structure = {"damping_ratio": 0.01, "axes": {"restitution": 0.0, "clearance_ratio": 0.01, "friction_ratio": 0.0},
                 "physical": {"natural_frequency_hz": 2.5}}  # fmt: skip
    truth = {"mass_ratio": 0.15, "natural_frequency_hz": 2.5}
    fit = {"mass_ratio": (0.1, 0.2), "natural_frequency_hz": (2.4, 2.6)}
    fitted = refitted(structure, fit, truth, {"frequency_hz": f})
    ((first, second, correlation),) = fitted.alike
    assert (first, second) == ("mass_ratio", "natural_frequency_hz")
    assert correlation > 0.95
    assert "apart" in said(fitted)


@pytest.mark.night
def test_two_base_amplitudes_give_force_and_length_of_a_real_damper() -> None:
    f = np.tile(np.linspace(2.2, 2.9, 12), 2)
    base = np.repeat([0.001, 0.003], 12)
    structure = {"damping_ratio": 0.01, "axes": {"restitution": 0.5, "mass_ratio": 0.1},
                 "physical": {"mass_kg": 1.605, "natural_frequency_hz": 2.5}}  # fmt: skip
    truth = {"friction_force_n": 0.2, "clearance_m": 0.012}
    fit = {"friction_force_n": (0.0, 0.4), "clearance_m": (0.004, 0.03)}
    fitted = refitted(structure, fit, truth, {"frequency_hz": f, "base_amplitude_m": base})
    assert max(in_halves(fitted, truth)) < 4
    assert all(each.high - each.low < 0.2 * truth[each.name] for each in fitted.estimates)


@pytest.mark.usefixtures("quick")
def test_deviations_that_are_too_small_are_told_and_the_intervals_are_wider() -> None:
    one = made("friction", 6)
    measured = one.question.measured
    strict = Measurement("strict", measured.columns, 0.2 * measured.deviation)
    fitted = fit_response(make_question(strict, {"particle": False}, dict(RANGES["friction"])))
    assert fitted.probability < 1e-6
    assert fitted.widening > 2
    assert "chi-square" in said(fitted)


@pytest.mark.night
def test_friction_of_the_particle_comes_back() -> None:
    structure: dict[str, Any] = {
        "damping_ratio": 0.0126,
        "axes": {"restitution": 0.47},
        "physical": {
            "mass_kg": 1.605, "natural_frequency_hz": 2.5, "base_amplitude_m": 0.0015,
            "particle_mass_kg": 0.16, "clearance_m": 0.015,
        },
    }  # fmt: skip
    truth = {"particle_friction_coefficient": 0.06, "friction_force_n": 0.2}
    sought = {"particle_friction_coefficient": None, "friction_force_n": (0.0, 0.4)}
    frequency = np.linspace(2.1, 2.9, 25)
    columns = {"frequency_hz": frequency, "amplitude_m": np.ones(frequency.size)}
    true = responses_at(make_question(Measurement("blank", columns), structure, sought), truth).amplitude
    noisy = true * (1.0 + 0.01 * np.random.default_rng(5).standard_normal(true.size))
    measured = Measurement("bench", columns | {"amplitude_m": noisy}, 0.01 * true)
    question = make_question(measured, structure, sought, confidence=0.999)
    fitted = fit_response(question)
    for each in fitted.estimates:
        assert each.low < truth[each.name] < each.high
        assert each.high - each.low < 0.1 * truth[each.name]
