"""Questions of fits: what is known, what is sought within which range, and what cannot be asked."""

from typing import Any

import numpy as np
import pytest
from tests.studies.documents import faults_of, fields_of, without
from tests.studies.fit.estimates import BENCH as PROTOTYPE

from damperlab.studies.faults import StudyFaults
from damperlab.studies.fit.asking import make_question
from damperlab.studies.fit.history.asking import make_history_question
from damperlab.studies.fit.history.question import RELEASE, History
from damperlab.studies.fit.measured import parse_measurement
from damperlab.studies.fit.question import FitQuestion

TABLE = "frequency (Hz), amplitude (mm), base amplitude (mm)\n2.4, 9, \n2.5, 12,\n2.6, 8, 3\n"


def asked(structure: dict[str, Any] = PROTOTYPE, table: str = TABLE, **fit: Any) -> FitQuestion:
    return make_question(parse_measurement(table), structure, fit)


def test_a_row_has_its_own_conditions_then_what_is_estimated_then_what_is_known() -> None:
    question = asked(friction_force_n=(0.0, 1.0), natural_frequency_hz=None)
    assert [free.name for free in question.free] == ["friction_force_n", "natural_frequency_hz"]
    assert (question.free[1].low, question.free[1].high) == (2.0, 3.125)
    conditions = [given for given, _ in question.configurations]
    assert conditions == [{}, {"base_amplitude_m": 0.003}]
    values = question.values(np.array([0.5, 0.5]))
    given = question.given(values, conditions[1])
    study = question.study(given, [1.0])
    # A real damper keeps its force and its length: at twice the base amplitude both ratios are half.
    stiffness = 1.605 * (2 * np.pi * 2.5625) ** 2
    assert study.coordinates["clearance_ratio"] == pytest.approx([0.015 / 0.003], rel=1e-12)
    assert study.coordinates["friction_ratio"] == pytest.approx([0.5 / (stiffness * 0.003)], rel=1e-12)
    assert question.ratios(given, np.array([2])) == pytest.approx([2.6 / 2.5625], rel=1e-15)
    assert question.scale(given) == 0.003


def test_a_ratio_of_a_row_replaces_the_quantity_that_makes_it() -> None:
    question = asked(table="r, X/Z, clearance ratio\n1, 9, 5\n1, 12,\n", friction_force_n=(0.0, 1.0))
    given = question.given({"friction_force_n": 0.3}, question.configurations[0][0])
    assert "clearance_m" not in given
    assert given["clearance_ratio"] == 5.0


def test_an_axis_of_the_structure_is_a_range_to_estimate_within_and_a_number_replaces_it() -> None:
    structure = {**PROTOTYPE, "axes": {"restitution": {"start": 0.2, "stop": 0.8, "num": 5}}}
    (free,) = asked(structure).free
    assert (free.name, free.low, free.high) == ("restitution", 0.2, 0.8)
    question = make_question(
        parse_measurement(TABLE), structure, {"damping_ratio": None}, known={"restitution": 0.5}
    )
    assert [free.name for free in question.free] == ["damping_ratio"]
    assert question.known["restitution"] == 0.5


def test_a_range_of_a_decade_is_searched_in_its_logarithm() -> None:
    (free,) = asked(clearance_m=(0.001, 0.1)).free
    assert free.values(np.array([0.0, 0.5, 1.0])) == pytest.approx([0.001, 0.01, 0.1], rel=1e-12)
    (free,) = asked(clearance_m=(0.01, 0.02)).free
    assert free.values(np.array([0.5])) == pytest.approx([0.015], rel=1e-12)


@pytest.mark.parametrize(
    ("structure", "fit", "said"),
    [
        (PROTOTYPE, {}, "There is no parameter to estimate."),
        (PROTOTYPE, {"restitutoin": None}, "Did you mean `restitution`?"),
        (PROTOTYPE, {"mass_kg": (1.0, 2.0)}, "mass_kg cannot be estimated"),
        (PROTOTYPE, {"restitution": (0.5, 2.0)}, "`fit.restitution` must be a number from 0 to 1, not 2.0."),
        (PROTOTYPE, {"restitution": (0.5, 0.5)}, "a lowest value below the highest"),
        (PROTOTYPE, {"damping_n_s_per_m": None}, "`fit.damping_n_s_per_m` needs a range to search"),
        (PROTOTYPE, {"clearance_m": None, "clearance_ratio": (1, 9)}, "are the same parameter"),
        (PROTOTYPE, dict.fromkeys(("restitution", "damping_ratio", "clearance_m")),
         "3 measured amplitudes cannot determine 3 parameters."),
        ({"axes": {"restitution": 0.5}}, {"damping_ratio": None},
         "`friction_ratio` is neither given nor estimated nor a column of the table"),
        ({"axes": {"restitution": 0.5}}, {"damping_ratio": None}, "Give it (0 for a structure without friction), estimate"),
        ({**PROTOTYPE, "axes": {"restitution": 3}}, {"damping_ratio": None}, "`restitution` must be"),
        ({**PROTOTYPE, "axes": {"speed": 3}}, {"damping_ratio": None}, "`speed` is not a known value of a prototype"),
        ({**PROTOTYPE, "contact": {"model": "soft"}}, {"damping_ratio": None}, "contact.model"),
        ({**PROTOTYPE, "solver": {"method": "rk4"}}, {"damping_ratio": None}, "A fit needs the event solver"),
        ({**PROTOTYPE, "particle": False}, {"restitution": None}, "in a scene without a particle"),
        ({**PROTOTYPE, "particle": False, "particle_friction_ratio": 0.1}, {"damping_ratio": None},
         "a scene without a particle"),
        ({**PROTOTYPE, "physical": {}}, {"damping_ratio": None}, "the amplitudes are measured in metres"),
    ],
)  # fmt: skip
def test_what_cannot_be_asked_is_refused_in_a_sentence(
    structure: dict[str, Any], fit: dict[str, Any], said: str
) -> None:
    with pytest.raises(StudyFaults) as caught:
        asked(structure, **fit)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("known", "fit"),
    [
        ({"clearance_m": 0.01, "clearance_ratio": 5.0}, {"damping_ratio": None}),
        ({"restitution": 0.5}, {"restitution": None}),
        ({"particle_friction_coefficient": 0.05}, {"particle_friction_coefficient": None}),
    ],
)
def test_what_is_given_twice_is_refused(known: dict[str, float], fit: dict[str, Any]) -> None:
    with pytest.raises(StudyFaults, match="given twice"):
        make_question(parse_measurement(TABLE), PROTOTYPE, fit, known=known)


def test_confidence_and_deviation_have_bounds() -> None:
    measured, settings = parse_measurement(TABLE), {"share": 0.0, "confidence": 95.0}
    fields = fields_of(make_question, measured, PROTOTYPE, {"restitution": None}, **settings)
    assert fields == ["confidence", "deviation"]


DECAY = History("decay", 0.01, 0.02 * np.cos(2 * np.pi * 2.5 * 0.01 * np.arange(400)))
KNOWN: dict[str, Any] = {
    "damping_ratio": 0.01,
    "axes": {"restitution": 0.5, "mass_ratio": 0.1},
    "physical": {"mass_kg": 1.6, "natural_frequency_hz": 2.5, "friction_force_n": 0.05, "clearance_m": 0.01},
}


def history_without(name: str) -> dict[str, Any]:
    parts = without(KNOWN, name)
    return {
        part: without(inside, name) if isinstance(inside, dict) else inside for part, inside in parts.items()
    }


def test_what_is_sought_counts_more_than_what_is_known_and_the_release_is_sought_as_well() -> None:
    question = make_history_question(DECAY, KNOWN, {"restitution": None, "friction_force_n": (0.0, 0.2)})
    assert [each.name for each in question.free] == ["restitution", "friction_force_n", RELEASE]
    given = question.given(question.values(np.full(3, 0.5)))
    assert given["restitution"] == 0.5
    assert given["friction_force_n"] == 0.1
    assert given[RELEASE] == pytest.approx(0.02, rel=1e-12)


def test_an_axis_is_a_range_and_an_option_replaces_a_ratio_or_what_makes_it() -> None:
    known = history_without("restitution") | {
        "axes": {"restitution": {"start": 0.2, "stop": 0.8, "num": 4}, "mass_ratio": 0.1}
    }
    question = make_history_question(DECAY, known, {}, known={"particle_mass_kg": 0.2})
    assert (question.free[0].low, question.free[0].high) == (0.2, 0.8)
    assert "mass_ratio" not in question.known


@pytest.mark.parametrize(
    ("structure", "fit", "said"),
    [
        (KNOWN, {"damping": None}, "damping cannot be estimated from a time history"),
        (KNOWN, {"friction_ratio": (0.0, 1.0)}, "a time history has no base amplitude"),
        (KNOWN, {"friction_force_n": None}, "needs a range to search"),
        (KNOWN | {"particle": False}, {"restitution": None}, "cannot be estimated in a scene without a particle"),
        (history_without("mass_kg"), {"restitution": None}, "`mass_kg` is neither given nor estimated"),
        (history_without("friction_force_n"), {"restitution": None}, "Give it (0 for a structure without friction), or"),
        (KNOWN | {"gravity_ratio": 1.0}, {"restitution": None}, "a time history has no base amplitude"),
        (KNOWN | {"particle": False}, {"damping_ratio": None, "tilt_deg": (0.0, 9.0)}, "in a scene without a particle"),
        (
            KNOWN | {"contact": {"model": "dwell", "contact_time": 0.1}},
            {"restitution": None, "particle_friction_coefficient": None},
            "cannot be combined with a contact that takes time",
        ),
        (KNOWN | {"start": {"kind": "continuation", "direction": "up"}}, {"restitution": None}, "does not apply to a time"),
    ],
)  # fmt: skip
def test_what_cannot_be_asked_of_a_history_is_refused_in_a_sentence(
    structure: dict[str, Any], fit: dict[str, Any], said: str
) -> None:
    faults = faults_of(make_history_question, DECAY, structure, fit)
    assert said in " ".join(map(str, faults))


@pytest.mark.parametrize("force", [0.02, 0.05, 0.3])
@pytest.mark.parametrize("noise", [0.0, 2e-4])
def test_a_decay_shows_where_its_frequency_and_its_friction_lie(force: float, noise: float) -> None:
    """Coulomb friction F takes 2F/k in each swing, until k times the amplitude is less."""
    offset, angle = force / (1.6 * (2 * np.pi * 2.5) ** 2), 2 * np.pi * 2.5 * 0.01 * np.arange(300)
    swing = np.floor(angle / np.pi)
    left = 0.02 - (2 * swing + 1) * offset
    moved = np.where(left > offset, left * np.cos(angle) + (-1) ** swing * offset, 0.0)
    moved += noise * np.random.default_rng(0).standard_normal(moved.size)
    fit = {"friction_force_n": None, "natural_frequency_hz": None}
    structure = {"damping_ratio": 0.0, "physical": {"mass_kg": 1.6}, "particle": False}
    friction, frequency, _ = make_history_question(History("decay", 0.01, moved), structure, fit).free
    assert friction.low < force < friction.high < 3.0 * force
    assert frequency.low < 2.5 < frequency.high


@pytest.mark.parametrize(
    ("step", "rows", "said"),
    [
        (0.06, 400, "samples in a period"),
        (0.01, 60, "1.47 periods of the structure; it must have at least 2"),
    ],
)
def test_a_history_that_is_too_short_or_too_coarse_is_refused(step: float, rows: int, said: str) -> None:
    history = History("short", step, np.full(rows, 0.02))
    assert said in faults_of(make_history_question, history, KNOWN, {"restitution": None})[0].sentence
