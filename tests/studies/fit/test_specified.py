"""Specifications made of fits: what they hold is what was measured, and they are accepted."""

import math
from dataclasses import replace
from typing import Any

import pytest
from tests.studies.fit.estimates import BENCH, IN_RATIOS, RATIO_TABLE, estimate, history, response

from damperlab.studies.faults import StudyFaults
from damperlab.studies.fit.fitted import Estimate
from damperlab.studies.fit.prototype import Question, prototype_of
from damperlab.studies.fit.specified import WIDTH, Specified, specification_text, specified
from damperlab.studies.named import named_specifications
from damperlab.studies.specification.reading import parse_specification
from damperlab.studies.text import load_text

OF_HISTORY: dict[str, Any] = {
    "damping_ratio": 0.01,
    "axes": {"restitution": 0.5, "mass_ratio": 0.1},
    "physical": {"natural_frequency_hz": 2.5, "mass_kg": 1.6, "friction_force_n": 0.05},
}
FRICTION = estimate("friction_force_n", 0.2, 0.15, 0.22)


def made(question: Question, *estimates: Estimate) -> Specified:
    found = specified(prototype_of(question, estimates))
    # whatever is written is read back as it was meant, and accepted
    assert load_text(specification_text(found), "yaml") == found.document
    parse_specification(found.document)
    return found


def test_a_response_in_units_makes_one_with_ranges_around_what_was_built() -> None:
    found = made(response(friction_force_n=(0.0, 1.0)), FRICTION)
    assert found.document == {
        "name": "measurement, corrected",
        "structure": {"mass_kg": 1.605, "natural_frequency_hz": 2.5, "damping_ratio": 0.0038},
        "excitation": {"base_amplitude_m": 0.0015, "frequency_hz": {"start": 2.4, "stop": 2.7}},
        "choose": {
            "clearance_m": {"start": 0.00375, "stop": 0.06},
            "friction_force_n": {"start": 0.05, "stop": 0.8},
        },
        "particle_mass_kg": 0.1605,
        "restitution": 0.47,
        "tolerances": {"friction_force_n": "25%"},
        "measure": "worst_displacement",
    }
    assert set(found.guesses) == {"choose.clearance_m", "choose.friction_force_n"}
    assert "GUESS, to be edited: a quarter to four times what was built, 0.015." in specification_text(found)


def test_a_name_of_any_length_and_any_letters_is_a_name() -> None:
    prototype = prototype_of(response(friction_force_n=(0.0, 1.0)), [FRICTION])
    found = specified(replace(prototype, name="a\nb" + "x" * 500))
    assert found.document["name"].startswith("abxx")
    assert found.document["name"].endswith("x, corrected")


def test_tolerances_are_rounded_up_and_hold_the_interval() -> None:
    estimates = [
        estimate("damping_ratio", 0.003, 0.0029, 0.00312345),
        estimate("restitution", 0.4, 0.20056, 0.47),
    ]
    found = made(response(damping_ratio=None, restitution=None), *estimates)
    assert found.document["tolerances"] == {"damping_ratio": "4.12%", "restitution": 0.2}
    asked = parse_specification(found.document)
    assert asked.tolerances["damping_ratio"].of(0.003) >= 0.00012345
    assert all(name in found.words[0] for name in ("the damping ratio", "the restitution", "95 %"))


def test_intervals_that_make_no_tolerance_are_said_in_words() -> None:
    """One wider than a specification takes, one from nothing, and one that says nothing."""
    wide = made(response(damping_ratio=None), estimate("damping_ratio", 0.002, 0.001, 0.005))
    assert wide.document["tolerances"] == {"damping_ratio": "50%"}
    assert "150 %" in wide.words[1]
    estimates = [
        estimate("damping_ratio", 0.0, 0.0, 0.002),
        estimate("restitution", 0.1, 0.0, 1.0, determined=False),
    ]
    found = made(response(damping_ratio=None, restitution=None), *estimates)
    assert found.document["tolerances"] == {"restitution": 0.05}
    for words, told in zip(found.words[1:4], ("begins at 0", "900 %", "nothing about"), strict=True):
        assert told in words
    assert parse_specification(found.document).tolerances["restitution"].size == 0.05


def test_friction_that_may_be_none_is_chosen_from_none() -> None:
    found = made(response(friction_force_n=(0.0, 1.0)), estimate("friction_force_n", 0.1, 0.01, 0.3))
    assert found.document["choose"]["friction_force_n"] == {"start": 0.0, "stop": 0.4}
    nothing = made(response(friction_force_n=(0.0, 1.0)), estimate("friction_force_n", 1e-6, 0.0, 2e-5))
    stiffness = 1.605 * (2 * math.pi * 2.5) ** 2
    most = nothing.document["choose"]["friction_force_n"]
    assert most == {"start": 0.0, "stop": pytest.approx(0.78 * stiffness * 0.0015, rel=5e-3)}
    assert "tolerances" not in nothing.document


def test_without_a_mass_it_is_in_ratios() -> None:
    found = made(
        response(IN_RATIOS, RATIO_TABLE, clearance_ratio=(5.0, 15.0)),
        estimate("clearance_ratio", 10, 9, 10.5),
    )
    assert found.document["structure"] == {"damping_ratio": 0.0038}
    assert found.document["choose"] == {
        "clearance_ratio": {"start": 2.5, "stop": 40.0},
        "friction_ratio": {"start": 0.075, "stop": 1.2},
    }
    assert found.document["mass_ratio"] == 0.1
    assert found.document["tolerances"] == {"clearance_ratio": "10%"}
    assert "It is in ratios: `mass_kg`, `natural_frequency_hz`, `base_amplitude_m` would" in found.words[1]


def test_a_bare_structure_gets_a_damper_that_is_guessed() -> None:
    structure = {"particle": False, "axes": {"friction_ratio": 0}, "physical": {"mass_kg": 2.0}}
    structure["physical"] |= {"natural_frequency_hz": 2.5, "base_amplitude_m": 0.001}
    found = made(response(structure, damping_ratio=None), estimate("damping_ratio", 0.01, 0.009, 0.011))
    assert found.document["choose"]["clearance_m"] == {"start": 0.001, "stop": 0.02}
    assert (found.document["particle_mass_kg"], found.document["restitution"]) == (0.2, 0.5)
    assert {"particle_mass_kg", "restitution", "choose.clearance_m"} <= set(found.guesses)


def test_what_differs_from_row_to_row_is_chosen() -> None:
    table = "frequency (Hz), amplitude (mm), clearance (mm), restitution\n2.4, 9, 5, 0.3\n2.5, 12, 10, 0.3\n2.6, 8, 5, 0.7\n"
    found = made(response(table=table, friction_force_n=(0.0, 1.0)), FRICTION)
    assert found.document["choose"]["clearance_m"] == {"start": 0.00125, "stop": 0.04}
    assert found.document["choose"]["restitution"] == {"start": 0.3, "stop": 0.7}
    assert "restitution" not in found.document


@pytest.mark.parametrize("model", ["dwell", "compliant"])
def test_a_contact_time_comes_along_in_seconds(model: str) -> None:
    structure = BENCH | {"contact": {"model": model, "contact_time": 0.1}}
    found = made(response(structure, friction_force_n=(0.0, 1.0)), FRICTION)
    assert found.document["contact_time_s"] == pytest.approx(0.1 / (2 * math.pi * 2.5), rel=1e-5)
    assert ("of the model dwell" in " ".join(found.words)) == (model == "compliant")
    ratios = made(
        response(IN_RATIOS | {"contact": structure["contact"]}, RATIO_TABLE, restitution=(0.2, 0.8)),
        estimate("restitution", 0.5, 0.4, 0.6),
    )
    assert "contact_time_s" not in ratios.document
    assert "Its impacts take no time" in " ".join(ratios.words)


def test_a_history_is_shaken_as_it_was_or_as_keeps_it_where_it_was_released() -> None:
    clearance = estimate("clearance_m", 0.01, 0.0099, 0.0102)
    shaken = made(history(OF_HISTORY, shaken=True, clearance_m=(0.001, 0.02)), clearance)
    band = {"start": 2.0, "stop": 3.125}
    peak = shaken.document["excitation"].pop("base_acceleration_m_per_s2")
    # of a sine that was sampled 41 times in a period the largest sample is above cos(π/41)
    assert 0.5 * math.cos(math.pi / 41) <= peak <= 0.5
    assert shaken.document["excitation"] == {"frequency_hz": band}
    released = made(history(OF_HISTORY, clearance_m=(0.001, 0.02)), clearance)
    lost = 2 * 0.01 * 0.02 + 4 * 0.05 / (math.pi * 1.6 * (2 * math.pi * 2.5) ** 2)
    assert released.document["excitation"] == {
        "base_amplitude_m": pytest.approx(lost, rel=1e-5),
        "frequency_hz": band,
    }
    assert "excitation" in released.guesses
    assert released.document["tolerances"] == {"clearance_m": "2%"}


def test_a_history_of_an_unknown_mass_makes_none() -> None:
    structure = OF_HISTORY | {"physical": {"natural_frequency_hz": 2.5, "friction_force_n": 0}}
    question = history(structure, clearance_m=(0.001, 0.02))
    with pytest.raises(StudyFaults, match="`mass_kg` is missing: a time history is in metres"):
        specified(prototype_of(question, [estimate("clearance_m", 0.01, 0.0099, 0.0102)]))


DOCUMENT: dict[str, Any] = {
    "name": "bench: 3 % of #noise, corrigée",
    "structure": {"mass_kg": 1.6, "natural_frequency_hz": 2.5, "damping_ratio": 1e-05},
    "choose": {
        "clearance_m": {"start": 1e-4, "stop": 0.02},
        "restitution": [{"name": "rubber", "restitution": 0.3}, {"name": "steel", "restitution": 0.8}],
    },
    "particle_mass_kg": 0.16,
    "tolerances": {"damping_ratio": "50%"},
}


def test_what_is_written_is_read_back_with_comments_where_something_is_guessed() -> None:
    words = ("A sentence. " * 20, "Another one.")
    guesses = {"choose.clearance_m": "from nothing\nat all.", "particle_mass_kg": "a tenth."}
    text = specification_text(Specified(DOCUMENT, words, guesses))
    assert load_text(text, "yaml") == DOCUMENT
    lines = text.splitlines()
    assert lines[0].startswith("# A sentence. ")
    assert all(len(line) <= WIDTH + 4 for line in lines)
    above = lines.index("  clearance_m: {start: 0.0001, stop: 0.02}") - 1
    assert lines[above] == "  # GUESS, to be edited: from nothing at all."
    assert lines[lines.index("particle_mass_kg: 0.16") - 1] == "# GUESS, to be edited: a tenth."


def test_named_specifications_are_written_as_they_were_read() -> None:
    for name, written in named_specifications().items():
        document = load_text(written, "yaml")
        assert load_text(specification_text(Specified(document, (), {})), "yaml") == document, name


def bench_without(*names: str) -> dict[str, Any]:
    """Give the bench's prototype without some of its quantities."""
    return {
        **BENCH,
        "physical": {name: value for name, value in BENCH["physical"].items() if name not in names},
        "axes": {name: value for name, value in BENCH["axes"].items() if name not in names},
    }


def test_a_ratio_becomes_a_force_over_every_corner_of_the_intervals_that_make_it() -> None:
    structure = bench_without("friction_force_n", "natural_frequency_hz")
    question = response(structure, friction_ratio=None, natural_frequency_hz=(2.0, 3.0))
    found = [estimate("friction_ratio", 0.3, 0.27, 0.31), estimate("natural_frequency_hz", 2.5, 2.45, 2.55)]
    prototype = prototype_of(question, found)

    def force(ratio: float, own_hz: float) -> float:
        return ratio * 1.605 * (2 * math.pi * own_hz) ** 2 * 0.0015

    (value,) = prototype.values["friction_force_n"]
    assert value == pytest.approx(force(0.3, 2.5), rel=1e-12)
    assert prototype.off["friction_force_n"] == pytest.approx(1 - force(0.27, 2.45) / value, rel=1e-12)
    assert prototype.off["natural_frequency_hz"] == pytest.approx(0.02, rel=1e-12)


def test_a_damping_coefficient_becomes_a_ratio() -> None:
    structure = bench_without()
    del structure["damping_ratio"]
    question = response(structure, damping_n_s_per_m=(0.0, 1.0))
    prototype = prototype_of(question, [estimate("damping_n_s_per_m", 0.2, 0.18, 0.21)])
    critical = 2 * 1.605 * 2 * math.pi * 2.5
    assert prototype.values["damping_ratio"] == pytest.approx((0.2 / critical,), rel=1e-12)
    assert prototype.off == pytest.approx({"damping_ratio": 0.1}, rel=1e-12)


def test_several_base_amplitudes_are_a_range() -> None:
    table = "frequency (Hz), amplitude (mm), base amplitude (mm)\n2.4, 9, \n2.5, 12,\n2.6, 8, 3\n"
    prototype = prototype_of(
        response(table=table, restitution=None), [estimate("restitution", 0.5, 0.5, 0.5)]
    )
    assert prototype.base_m == (0.0015, 0.003)
    assert prototype.excitation["base_amplitude_m"] == {"start": 0.0015, "stop": 0.003}
    assert prototype.off == {}


@pytest.mark.parametrize(
    ("structure", "table", "said"),
    [
        (
            IN_RATIOS,
            "r, X/Z, damping ratio\n1, 29, 0.01\n1, 9, 0.02\n1.1, 6, 0.02\n",
            "values of damping_ratio",
        ),
        (IN_RATIOS | {"excitation": "force"}, RATIO_TABLE, "A response to a force"),
    ],
)
def test_what_is_not_one_structure_on_a_moving_base_is_refused(
    structure: dict[str, Any], table: str, said: str
) -> None:
    question = response(structure, table, restitution=None)
    with pytest.raises(StudyFaults, match=said):
        prototype_of(question, [estimate("restitution", 0.5, 0.4, 0.6)])
