"""From a measurement whose truth is known to a specification: its tolerances hold the truth, and its study computes it."""

from typing import Any

import numpy as np
import pytest
from tests.synthetic_history import made_history

from damperlab.studies.definition import parse_harmonic
from damperlab.studies.faults import StudyFaults
from damperlab.studies.fit.asking import make_question
from damperlab.studies.fit.fitted import Fitted
from damperlab.studies.fit.history.asking import make_history_question
from damperlab.studies.fit.history.harmonic import harmonic_document
from damperlab.studies.fit.history.history import History
from damperlab.studies.fit.history.question import HistoryQuestion
from damperlab.studies.fit.made import Correction, check_study, made_of
from damperlab.studies.fit.measured import Measurement
from damperlab.studies.plan import Block
from damperlab.studies.specification.reading import parse_specification, read_specification
from damperlab.studies.specification.specification import Specification
from damperlab.worker.block import solve_block
from damperlab.worker.fit.estimate import fit_response
from damperlab.worker.fit.history.estimate import fit_history
from damperlab.worker.fit.model import responses_at

STRUCTURE: dict[str, Any] = {
    "particle": False,
    "physical": {"mass_kg": 1.605, "base_amplitude_m": 0.0015},
}
FIT: dict[str, tuple[float, float]] = {
    "friction_force_n": (0.0, 0.4),
    "damping_ratio": (0.0, 0.05),
    "natural_frequency_hz": (2.3, 2.7),
}
TRUTH = {"friction_force_n": 0.15, "damping_ratio": 0.012, "natural_frequency_hz": 2.52}


@pytest.fixture(scope="module")
def fitted() -> Fitted:
    """Fit what a known prototype shows, with 1 % of noise."""
    frequency = np.linspace(2.2, 2.9, 15)
    columns = {"frequency_hz": frequency, "amplitude_m": np.ones(frequency.size)}
    blank = make_question(Measurement("bench", columns), STRUCTURE, FIT)
    true = responses_at(blank, TRUTH).amplitude
    noise = 0.01 * np.random.default_rng(5).standard_normal(true.size)
    measured = Measurement("bench", columns | {"amplitude_m": true * (1.0 + noise)}, 0.01 * true)
    return fit_response(make_question(measured, STRUCTURE, FIT, confidence=0.999))


def holds(asked: Specification, truth: dict[str, float], built: dict[str, float]) -> None:
    """Check that tolerances about what is written hold the truth, and that no interval is left out."""
    for name, true in truth.items():
        value = built.get(name, getattr(asked.structure, name, None))
        assert value is not None
        tolerance = asked.tolerances[name].of(value)
        assert abs(true - value) <= tolerance < 0.5 * value, name


def test_a_specification_of_a_fitted_response_holds_the_truth_within_its_tolerances(fitted: Fitted) -> None:
    made = made_of(fitted)
    assert made.specification is not None
    asked = parse_specification(made.specification.document)
    holds(asked, TRUTH, {"friction_force_n": fitted.values["friction_force_n"]})
    assert asked.in_units
    assert asked.free == ("clearance_m", "friction_force_n")
    assert asked.choices["friction_force_n"].start < 0.15 < asked.choices["friction_force_n"].stop


def test_a_named_specification_is_corrected_by_the_same_fit(fitted: Fitted) -> None:
    before = read_specification("prototype")
    made = made_of(fitted, Correction(before))
    assert made.specification is not None
    asked = parse_specification(made.specification.document)
    holds(asked, TRUTH, {"friction_force_n": fitted.values["friction_force_n"]})
    assert asked.choices["clearance_m"] == before.choices["clearance_m"]
    assert asked.choices["restitution"] == before.choices["restitution"]
    assert asked.limits == before.limits


@pytest.mark.night
def test_a_fitted_history_makes_a_specification_and_a_study() -> None:
    one = made_history("hybrid", 1, shaken=True)
    fitted = fit_history(one.question)
    made = made_of(fitted)
    assert made.specification is not None
    asked = parse_specification(made.specification.document)
    own = fitted.values
    for name in ("clearance_m", "friction_force_n"):
        assert asked.choices[name].start < one.truth[name] < asked.choices[name].stop
    for name in ("clearance_m", "friction_force_n", "restitution"):
        # twice an interval of 95 % is four standard deviations
        assert abs(one.truth[name] - own[name]) <= 2 * asked.tolerances[name].of(own[name])
    assert made.study is not None
    study = parse_harmonic(made.study)
    assert study.coordinates["frequency_ratio"][[0, -1]] == pytest.approx([0.8, 1.25])
    # the sine that shook it, 1.5 mm at 2.4 Hz, has this amplitude at 2.5 Hz
    ratio = own["clearance_m"] / (0.0015 * (2.4 / 2.5) ** 2)
    assert study.coordinates["clearance_ratio"] == pytest.approx([ratio], rel=1e-3)


def released(structure: dict[str, Any], largest_m: float = 0.02) -> HistoryQuestion:
    """Ask a decay that begins at a displacement."""
    time = 0.01 * np.arange(100)
    decay = History("decay", 0.01, largest_m * np.cos(5 * np.pi * time) * np.exp(-time), True, None)
    return make_history_question(decay, structure, {"natural_frequency_hz": (2.4, 2.6)})


@pytest.mark.parametrize(("damping_ratio", "force_n"), [(0.02, 0.0), (0.02, 0.3), (0.005, 0.1)])
def test_the_base_that_is_guessed_keeps_the_structure_where_it_was_released(
    damping_ratio: float, force_n: float
) -> None:
    physical = {"mass_kg": 1.6, "friction_force_n": force_n}
    question = released({"particle": False, "damping_ratio": damping_ratio, "physical": physical})
    document = harmonic_document(question, {"natural_frequency_hz": 2.5, "initial_displacement_m": 0.02})
    base_m = document["physical"]["base_amplitude_m"]
    document["axes"]["frequency_ratio"] = 1.0
    study = parse_harmonic(document | {"metrics": ["amplitude_ratio", "relative_amplitude_ratio"]})
    block = solve_block(study, Block.whole(study.shape))
    # a balance of energy takes the motion for a sine: exact without friction, close with it
    moved = float(block["relative_amplitude_ratio"].reshape(-1)[0]) * base_m
    assert moved == pytest.approx(0.02, rel=1e-6 if force_n == 0.0 else 0.05)


def test_without_damping_and_friction_no_base_keeps_it_anywhere() -> None:
    question = released({"particle": False, "damping_ratio": 0.0, "physical": {"friction_force_n": 0.0}})
    with pytest.raises(StudyFaults, match="neither damping nor friction says nothing about a base amplitude"):
        check_study(question)
