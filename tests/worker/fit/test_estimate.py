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


@pytest.mark.usefixtures("quick")
def test_deviations_that_are_too_small_are_told_and_the_intervals_are_wider() -> None:
    one = made("friction", 6)
    measured = one.question.measured
    strict = Measurement("strict", measured.columns, 0.2 * measured.deviation)
    fitted = fit_response(make_question(strict, {"particle": False}, dict(RANGES["friction"])))
    assert fitted.probability < 1e-6
    assert fitted.widening > 2
    assert "chi-square" in said(fitted)
