from typing import Any

import numpy as np
import pytest

from damperlab.studies.faults import StudyFaults
from damperlab.studies.fit.history.asking import make_history_question
from damperlab.studies.fit.history.history import History
from damperlab.studies.fit.history.question import RELEASE

DECAY = History("decay", 0.01, 0.02 * np.cos(2 * np.pi * 2.5 * 0.01 * np.arange(400)))
KNOWN: dict[str, Any] = {
    "damping_ratio": 0.01,
    "axes": {"restitution": 0.5, "mass_ratio": 0.1},
    "physical": {"mass_kg": 1.6, "natural_frequency_hz": 2.5, "friction_force_n": 0.05, "clearance_m": 0.01},
}


def without(name: str) -> dict[str, Any]:
    return {
        part: {key: value for key, value in inside.items() if key != name}
        if isinstance(inside, dict)
        else inside
        for part, inside in KNOWN.items()
        if part != name
    }


def test_what_is_sought_counts_more_than_what_is_known_and_the_release_is_sought_as_well() -> None:
    question = make_history_question(DECAY, KNOWN, {"restitution": None, "friction_force_n": (0.0, 0.2)})
    assert [each.name for each in question.free] == ["restitution", "friction_force_n", RELEASE]
    given = question.given(question.values(np.full(3, 0.5)))
    assert given["restitution"] == 0.5
    assert given["friction_force_n"] == 0.1
    assert given[RELEASE] == pytest.approx(0.02, rel=1e-12)


def test_an_axis_is_a_range_and_an_option_replaces_a_ratio_or_what_makes_it() -> None:
    known = without("restitution") | {
        "axes": {"restitution": {"start": 0.2, "stop": 0.8, "num": 4}, "mass_ratio": 0.1}
    }
    question = make_history_question(DECAY, known, {}, known={"particle_mass_kg": 0.2})
    assert (question.free[0].low, question.free[0].high) == (0.2, 0.8)
    assert "mass_ratio" not in question.known


def test_a_share_is_one_of_the_largest_displacement() -> None:
    question = make_history_question(DECAY, KNOWN, {"restitution": None}, share=0.01)
    assert question.measured.deviation_m == pytest.approx(np.full(400, 2e-4), rel=1e-12)


@pytest.mark.parametrize(
    ("structure", "fit", "said"),
    [
        (KNOWN, {}, "Nothing is to be estimated."),
        (KNOWN, {"damping": None}, "damping cannot be estimated from a time history"),
        (KNOWN, {"friction_ratio": (0.0, 1.0)}, "a time history knows no base amplitude"),
        (KNOWN, {"friction_force_n": None}, "needs a range to look in"),
        (KNOWN, {"restitution": (0.5, 1.5)}, "a number from 0 to 1"),
        (KNOWN, {"restitution": (0.5, 0.2)}, "a lowest value below the highest"),
        (KNOWN, {"mass_ratio": None, "particle_mass_kg": (0.0, 1.0)}, "are the same parameter"),
        (KNOWN | {"particle": False}, {"restitution": None}, "cannot be estimated in a scene without a particle"),
        (without("restitution"), {"damping_ratio": None}, "`restitution` is neither given nor estimated"),
        (without("mass_kg"), {"restitution": None}, "`mass_kg` is neither given nor estimated"),
        (without("natural_frequency_hz"), {"restitution": None}, "`natural_frequency_hz` is neither given nor"),
        (without("friction_force_n"), {"restitution": None}, "`friction_force_n` is neither given nor estimated"),
        (KNOWN | {"start": {"kind": "continuation", "direction": "up"}}, {"restitution": None}, "says nothing about a time"),
        (KNOWN | {"contact": {"model": "soft"}}, {"restitution": None}, "soft"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_question_is_told(
    structure: dict[str, Any], fit: dict[str, Any], said: str
) -> None:
    with pytest.raises(StudyFaults) as refused:
        make_history_question(DECAY, structure, fit)
    assert said in " ".join(fault.sentence for fault in refused.value.faults)


@pytest.mark.parametrize(
    ("step", "rows", "said"), [(0.06, 400, "samples in a period"), (0.01, 60, "must last at least 2")]
)
def test_a_history_that_is_too_short_or_too_coarse_is_refused(step: float, rows: int, said: str) -> None:
    with pytest.raises(StudyFaults) as refused:
        make_history_question(History("short", step, np.full(rows, 0.02)), KNOWN, {"restitution": None})
    assert said in refused.value.faults[0].sentence
