"""Designs under several excitations: the worst over all of them, computed point by point with the solver itself."""

from typing import Any

import numpy as np
import pytest
from tests.studies.design.test_design import DAMPED, pursued, solved

from damperlab.studies.definition import parse_study
from damperlab.studies.design.answer import answer_document
from damperlab.studies.design.build import Build
from damperlab.studies.design.found import Found
from damperlab.studies.specification.excitation import Excitation

FREQUENCIES = 61
AT_REST = {"name": "at rest", **DAMPED["excitation"]}
STARTING = {
    "name": "starting",
    "base_velocity_m_per_s": 0.08,
    "frequency_hz": {"start": 6.0, "stop": 8.5},
}
"""1.6 mm at 8 Hz: more than the millimetre of the other one, over a band of its own."""
CHOSEN: dict[str, Any] = {
    **{key: value for key, value in DAMPED.items() if key not in ("choose", "tolerances", "builds")},
    "choose": {"friction_force_n": {"start": 0.0, "stop": 60.0}},
    "clearance_m": 0.006,
}
BUDGET = 20_000


@pytest.fixture(scope="module")
def both() -> Found:
    return pursued(CHOSEN | {"excitation": [AT_REST, STARTING]}, BUDGET)[0]


def worst_m(found: Found, build: Build, excitation: Excitation, *more: float) -> float:
    """The largest displacement [m] over the band of an excitation, and at more frequencies, each a point of its own."""
    values = []
    for r in (*np.linspace(excitation.low, excitation.high, FREQUENCIES), *more):
        base_m = excitation.highest_m / r**excitation.motion.order
        damping, restitution, mass, clearance, friction = build.place(found.asked.structure, base_m)
        axes = {"restitution": restitution, "mass_ratio": mass, "clearance_ratio": clearance}
        document = {"damping_ratio": damping, "metrics": ["amplitude_ratio"]}
        axes |= {"friction_ratio": friction, "frequency_ratio": float(r)}
        values.append(
            base_m * float(solved(parse_study(document | {"axes": axes}))["amplitude_ratio"].item())
        )
    return max(values)


@pytest.mark.night
def test_the_worst_over_every_excitation_is_stated_and_what_binds_is_named(both: Found) -> None:
    truth = [
        worst_m(both, both.build, each, judged.frequency_ratio)
        for each, judged in zip(both.asked.excitations, both.under, strict=True)
    ]
    for judged, value in zip(both.under, truth, strict=True):
        assert judged.value - judged.error <= value * (1 + 1e-9)
        assert judged.most >= value * (1 - 1e-6)
    assert both.nominal.value == pytest.approx(max(each.value for each in both.under))
    assert both.binding.name == ("at rest", "starting")[int(np.argmax(truth))]
    answer = answer_document(both)
    assert answer["worst"]["excitation"] == both.binding.name
    assert [each["excitation"] for each in answer["excitations"]] == ["at rest", "starting"]
    told = " ".join(answer["words"])
    assert f"Of 2 excitations `{both.binding.name}` binds" in told
    assert "80 mm/s" in told
    assert "from 7 Hz to 9 Hz" in told


@pytest.mark.night
def test_no_other_force_keeps_both_lower(both: Found) -> None:
    stated = both.nominal.most
    for force in np.linspace(0.0, 60.0, 13):
        other = Build(0.006, float(force), 4.0, 0.5)
        assert max(worst_m(both, other, each) for each in both.asked.excitations) > stated * 0.98


@pytest.mark.night
def test_one_excitation_in_a_list_is_that_excitation() -> None:
    alone = pursued(CHOSEN, BUDGET)[1]
    listed = pursued(CHOSEN | {"excitation": [DAMPED["excitation"]]}, BUDGET)[1]
    assert listed.keys() == alone.keys()


@pytest.mark.night
def test_an_excitation_that_never_binds_changes_no_damper(both: Found) -> None:
    weak = {"name": "weak", "base_amplitude_m": 1e-4, "frequency_hz": {"start": 7.5, "stop": 8.5}}
    with_it = pursued(CHOSEN | {"excitation": [DAMPED["excitation"], weak]}, BUDGET)[0]
    without = pursued(CHOSEN, BUDGET)[0]
    assert with_it.build == without.build
    assert with_it.nominal.value == without.nominal.value
    assert with_it.binding == with_it.asked.excitations[0]
