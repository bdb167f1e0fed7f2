"""Limits on the damper hold for it as built; what is said of limits and of responses without bound is what is known."""

import itertools
import json
import math
import re
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.studies.design.test_design import DAMPED, pursued
from tests.studies.documents import without
from tests.studies.solving import solved

from damperlab.service.design_report import design_report
from damperlab.service.figures.design import draw_alternatives
from damperlab.studies.design.answer import answer_document
from damperlab.studies.design.book import Book, Wanted
from damperlab.studies.design.build import Build
from damperlab.studies.design.found import Found
from damperlab.studies.design.margins import Margin
from damperlab.studies.design.score import score
from damperlab.studies.design.search import FEW
from damperlab.studies.design.space import amplitudes_of
from damperlab.studies.design.spelling import rounded_up
from damperlab.studies.design.verdict import verdict_of
from damperlab.studies.specification.reading import parse_specification

WANTED: dict[str, Any] = DAMPED | {
    "structure": {"mass_kg": 40.0, "natural_frequency_hz": 8.0, "damping_ratio": 0.05},
    "excitation": {"base_amplitude_m": 0.001, "frequency_hz": {"start": 7.5, "stop": 8.5}},
    "choose": {"friction_force_n": {"start": 0.0, "stop": 60.0}},
    "clearance_m": 0.006,
    "particle_mass_kg": 0.4,
    "tolerances": {"friction_force_n": "10%"},
    "builds": 4,
}
"""So light a particle that the more friction there is, the less it moves."""

AT_RESONANCE = {
    "structure": {"mass_kg": 40.0, "natural_frequency_hz": 8.0, "damping_ratio": 0.0},
    "excitation": {"base_amplitude_m": 0.001, "frequency_hz": 8.0},
}
"""Of a structure without damping."""


LIMITED = WANTED | {"limits": {"friction_force_n": 30.0, "displacement_m": 0.02, "cavity_length_m": 0.5}}


@pytest.fixture(scope="module")
def limited() -> Found:
    """A budget that leaves out how far each quantity may be off."""
    found, _ = pursued(LIMITED, 1000, front=False)
    return found


def test_a_build_that_exceeds_one_is_not_counted_as_keeping_it(limited: Found) -> None:
    beyond = Build(0.006, 33.0, 4.0, 0.5)
    assert beyond.excess(limited.asked) == pytest.approx(0.1)
    judged = score(limited.book, beyond, amplitudes_of(limited.asked, FEW))
    assert judged.violation >= 0.1
    # without a particle its cavity is none
    assert Build(1.0, 20.0, 0.0, 0.0).excess(limited.asked) == 0.0


def test_every_limit_is_told_with_what_is_allowed_and_what_is_built(limited: Found) -> None:
    answer = answer_document(limited)
    rows = {row["limit"]: row for row in answer["limits"]}
    assert rows.keys() == {"friction_force_n", "displacement_m", "cavity_length_m"}
    assert rows["friction_force_n"]["allowed"] == 30.0
    assert rows["friction_force_n"]["reached"] == pytest.approx(30.0)
    assert rows["friction_force_n"]["binds"]
    assert (rows["cavity_length_m"]["allowed"], rows["cavity_length_m"]["binds"]) == (0.5, False)
    assert all(row["kept"] for row in rows.values())
    words = " ".join(answer["words"])
    assert "30 N of the 30 N" in words
    assert "12 mm of the 500 mm" in words
    json.dumps(answer, allow_nan=False)


def test_kinds_that_the_budget_did_not_cover_are_named(limited: Found) -> None:
    assert set(limited.not_compared) == limited.others.keys() ^ {"friction_alone", "particle_alone"}
    rows = [row[0] for row in verdict_of(limited)[0].rows]
    assert ("not compared" in rows) is bool(limited.not_compared)
    left = verdict_of(replace(limited, alternatives={}))[0].rows
    assert ("not compared", "", "friction alone and particle alone: the budget was spent") in left


def test_an_end_at_which_nothing_failed_is_called_the_end_of_what_was_examined() -> None:
    ends = [(None, 84.0), (36.0, None), (36.0, 100.0)]
    spans = [Margin(48.0, 84.0, *beyond).span("{:g} N".format) for beyond in ends]
    assert spans == [
        "48 N (the lowest examined) to 84 N",
        "48 N to 84 N (the highest examined)",
        "48 N to 84 N",
    ]


def test_the_stated_worst_case_is_that_of_every_corner_of_many_tolerances() -> None:
    """The search examines 8 of the 16 corners of four tolerances."""
    tolerances = {
        "friction_force_n": "10%",
        "mass_kg": "3%",
        "natural_frequency_hz": "2%",
        "damping_ratio": "5%",
    }
    given = {"choose": {}, "friction_force_n": 20.0, "tolerances": tolerances, "builds": 0}
    found, _ = pursued(WANTED | given, 3000, front=False)
    asked, under = found.asked, amplitudes_of(found.asked, FEW)
    signs = itertools.product((-1.0, 1.0), repeat=4)
    corners = [found.build.moved(asked, dict(zip(asked.toleranced, row, strict=True))) for row in signs]
    assert all(found.book.curve(corner, under[0]).r.size > FEW for corner in corners)
    highest = max(score(found.book, corner, under).value for corner in corners)
    assert found.stated.value == highest


def test_of_a_damper_that_exceeds_a_limit_no_range_is_said_to_keep_the_limits(limited: Found) -> None:
    margins = {
        "friction_force_n": Margin(20.0, 30.0, 15.0, None),
        "particle_friction_coefficient": Margin(0.0, 0.5, None, None),
    }
    keeps = replace(limited, margins=margins, left_out=[])

    def told(found: Found) -> str:
        brief = verdict_of(found)[0]
        return " ".join((*brief.sentences, *(word for row in brief.rows for word in row))).lower()

    assert "limits hold" in told(keeps)
    assert "limits hold" not in told(replace(keeps, stated=replace(keeps.stated, violation=0.1)))


def test_the_value_over_a_limit_is_said_to_be_that_of_the_damper_found(limited: Found) -> None:
    """A tuned mass damper may be recommended that exceeds the same limit by less."""
    reached = limited.stated.reached | {"displacement_m": 0.03}
    stated = replace(limited.stated, reached=reached, at_most=reached, violation=0.5)
    tuned = replace(limited.heaviest, value=1e-6, detuned=1e-6, exceeded={"displacement_m": 0.0212345})
    found = replace(limited, stated=stated, compared=replace(limited.compared, violation=0.5))
    found.__dict__["heaviest"] = tuned
    brief = verdict_of(found)[0]
    assert brief.damper == "tuned_mass_damper"
    row = next(each for each in brief.rows if each[0] == "displacement_m")
    assert row[1:] == ("30 mm", "20 mm allowed, with the best particle with friction")
    assert "relax the limit to `displacement_m: 0.02124`" in brief.next
    found.__dict__["heaviest"] = replace(tuned, exceeded={})
    assert "limit" not in verdict_of(found)[0].next


@given(st.floats(1e-9, 1e9))
def test_what_one_is_told_to_allow_is_enough_and_hardly_more(value: float) -> None:
    told = rounded_up(value)
    assert value * (1 - 1e-11) <= told <= value * (1 + 1.0001e-3)
    assert float(f"{told:.4g}") == told


def test_damping_bounds_a_response_however_little_is_known_of_it() -> None:
    """A chaotic run that ends in a trend: its error exceeds its mean, and the mean is a number all the same."""
    r = 0.95490625
    asked = parse_specification(
        {
            "structure": {"damping_ratio": 0.006},
            "excitation": {"frequency_ratio": r},
            "choose": {"clearance_ratio": {"start": 8.0, "stop": 9.0}},
            "friction_ratio": 0.4469669671889709,
            "mass_ratio": 0.075,
            "restitution": 0.5,
        }
    )
    book, amplitudes = Book(asked, 10), amplitudes_of(asked, FEW)
    friction = asked.choices["friction_force_n"].start
    mass = asked.choices["particle_mass_kg"].start
    build = Build(8.215456333086712, friction, mass, 0.5)
    (cube,) = (solved(each) for each in book.studies([Wanted(build, amplitudes[0], (r,))]))
    assert cube["amplitude_error"].item() > cube["amplitude_ratio"].item()
    book.add([cube])
    found = score(book, build, amplitudes)
    assert math.isfinite(found.value)
    assert found.most > 2.0 * found.value


def test_a_damper_without_bound_is_no_number() -> None:
    document = without(DAMPED | AT_RESONANCE, "tolerances", "choose") | {
        "clearance_m": 1.0,
        "particle_mass_kg": 0.0,
        "friction_force_n": 30.0,
        "limits": {"displacement_m": 0.01},
    }
    found, _ = pursued(document)
    answer = answer_document(found)
    words = " ".join(answer["words"])
    assert answer["notes"][0]["kind"] == "unbounded"
    assert "without bound" in answer["verdict"]["sentences"][0]
    assert "inf" not in words
    assert not answer["feasible"]


def test_what_is_said_to_be_the_most_is_not_less_than_it_is(limited: Found) -> None:
    worst = answer_document(limited)["words"][1]
    told = re.search(r"it is at most ([0-9.]+) mm\.", worst)
    assert float(told[1]) / 1e3 >= limited.stated.most * (1 - 1e-12)


def test_what_wins_is_the_verdict(limited: Found) -> None:
    heaviest = limited.heaviest
    reached = limited.compared.value
    for theirs, better in ((0.5 * reached, True), (2.0 * reached, False)):
        beside = replace(heaviest, value=theirs, detuned=theirs, exceeded={})
        brief, _ = verdict_of(replace(limited, absorber=beside))
        assert (brief.damper == "tuned_mass_damper") is better
        assert ("tuned mass damper" in [row[0] for row in brief.rows]) is not better
    # in tune better, and worse out of it: not recommended
    beside = replace(heaviest, value=0.5 * reached, detuned=2.0 * reached, exceeded={})
    assert verdict_of(replace(limited, absorber=beside))[0].damper != "tuned_mass_damper"


def test_only_the_damper_of_the_verdict_is_called_recommended(limited: Found) -> None:
    heaviest = limited.heaviest
    beside = replace(heaviest, value=0.5 * limited.compared.value, detuned=0.5 * limited.compared.value)
    for beaten, called in ((True, "best particle with friction"), (False, "recommended")):
        found = replace(
            limited, absorber=replace(beside, exceeded={} if beaten else {"displacement_m": 0.03})
        )
        answer = answer_document(found)
        assert answer["called"] == called
        assert ("recommended" in design_report(found)) is not beaten
        labels = draw_alternatives(found, called).axes[0].get_legend_handles_labels()[1]
        assert (labels[-1], len(labels)) == (called, len(set(labels)))
        assert ("damping ratio" in [name for name, *_ in answer["drawing"]]) is beaten
        assert answer["words"][0].startswith("Drawing: tuned mass damper, " if beaten else "Drawing: 400 g")
    lines = {name: value for name, value, *_ in answer_document(replace(limited, absorber=beside))["drawing"]}
    assert lines["mass"] == "400 g"
    hertz = 8.0 * beside.absorber.tuning
    assert float(lines["natural frequency"].removesuffix(" Hz")) == pytest.approx(hertz, rel=1e-3)
    assert float(lines["damping ratio"]) == pytest.approx(beside.absorber.damping_ratio, rel=1e-3)
