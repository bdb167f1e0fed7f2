"""The study that is made of a fitted prototype: it computes what was measured."""

from typing import Any

import numpy as np
import pytest
from tests.synthetic_history import made_history

from damperlab.studies.definition import parse_harmonic
from damperlab.studies.faults import StudyFaults
from damperlab.studies.fit.history.asking import make_history_question
from damperlab.studies.fit.history.fitted import check_study, harmonic_document
from damperlab.studies.fit.history.question import History, HistoryQuestion
from damperlab.studies.plan import Block
from damperlab.worker.block import solve_block
from damperlab.worker.fit.history.estimate import fit_history


@pytest.mark.night
def test_a_fitted_history_makes_a_study() -> None:
    one = made_history("hybrid", 1, shaken=True)
    fitted = fit_history(one.question)
    study = parse_harmonic(fitted.study())
    assert study.coordinates["frequency_ratio"][[0, -1]] == pytest.approx([0.8, 1.25])
    # the sine that shook it, 1.5 mm at 2.4 Hz, has this amplitude at 2.5 Hz
    ratio = fitted.values["clearance_m"] / (0.0015 * (2.4 / 2.5) ** 2)
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
    with pytest.raises(StudyFaults, match="does not determine a base amplitude"):
        check_study(question)
