"""The ranking: the same as judging every design of the whole cube by hand."""

import itertools

import numpy as np
import pytest

from damperlab.studies.answers.design_question import DESIGN
from damperlab.studies.answers.optimal_designs import optimal_designs
from damperlab.studies.questions import Judging


def _by_hand(whole, objective, band=(0.0, 9.0), exclude_locked=False, max_impact_speed=np.inf, ranges=None):
    """Every qualifying design as (value, error, coordinates), ranked; plain loops over the cube in memory."""
    frequencies = whole["frequency_ratio"].values
    counting = np.flatnonzero((frequencies >= band[0]) & (frequencies <= band[1]))
    if objective == "resonance":
        counting = np.array([np.abs(frequencies - 1).argmin()])
    near = counting[np.abs(frequencies[counting] - 1).argmin()]
    found = []
    for index in itertools.product(*(range(whole.sizes[name]) for name in DESIGN)):
        coordinates = {name: whole[name].values[i] for name, i in zip(DESIGN, index, strict=True)}
        get = {name: whole[name].values[index] for name in whole.data_vars}
        held = {name: get[name][counting] if name in get else coordinates[name] for name in ranges or {}}
        if any(((held[name] < a) | (held[name] > b)).any() for name, (a, b) in (ranges or {}).items()):
            continue
        if not np.isin(get["status"][counting], (0, 1)).all():
            continue
        if exclude_locked and get["response_class"][near] == 1:
            continue
        if (get["impact_speed_max"][counting] > max_impact_speed).any():
            continue
        a, e, r = get["amplitude_ratio"][counting], get["amplitude_error"][counting], frequencies[counting]
        width = r[-1] - r[0]
        if objective == "resonance":
            value, error = a[0], e[0]
        elif objective == "peak":
            value, error = a.max(), e[a.argmax()]
        elif objective == "band_mean":
            value, error = np.trapezoid(a, r) / width, np.trapezoid(e, r) / width
        else:
            value = np.sqrt(np.trapezoid(a * a, r) / width)
            error = np.trapezoid(a * e, r) / width / value
        found.append((value, error, coordinates, r[a.argmax()]))
    return sorted(found, key=lambda row: row[0])


QUESTIONS = [
    {},
    {"exclude_locked": True},
    {"max_impact_speed": 7.0},
    {"ranges": {"clearance_ratio": (2.0, 10.0), "restitution": (0.4, 1.0)}},
    {"ranges": {"stick_fraction": (2.0, 8.8)}},
]


@pytest.mark.parametrize("budget", [20, 2**18])
@pytest.mark.parametrize(
    ("objective", "question"),
    list(zip(["resonance", "peak", "band_mean", "band_rms", "peak"], QUESTIONS, strict=True)),
)
def test_the_ranking_is_that_of_the_whole_cube(cube, whole, monkeypatch, objective, question, budget):
    monkeypatch.setattr("damperlab.studies.answers.slab.BUDGET", budget)
    asked = question if objective == "resonance" else {"band": (0.8, 1.0)} | question
    answer = optimal_designs(cube, Judging(objective, **asked), top=7)
    expected = _by_hand(whole, objective, **asked)
    assert len(expected) > 3  # else this compares nothing
    assert answer.sizes["rank"] == min(7, len(expected))
    for place, (value, error, coordinates, frequency) in enumerate(expected[:7]):
        row = answer.isel(rank=place)
        assert row["rank"] == place + 1
        # sums of three terms, in another order
        np.testing.assert_allclose(row["value"], value, rtol=1e-14)
        np.testing.assert_allclose(row["error"], error, rtol=1e-14)
        assert {name: row[name].item() for name in DESIGN} == coordinates
        assert row["frequency_ratio"] == frequency
        at = whole["response_class"].sel(coordinates)
        assert row["response_class"] == at.sel(frequency_ratio=frequency)
        counting = [1.0] if objective == "resonance" else [0.8, 0.95, 1.0]
        share = (at.sel(frequency_ratio=counting) == 1).mean()
        np.testing.assert_allclose(row["locked_share"], share, rtol=1e-14)


def test_what_was_left_out_is_counted_and_said(cube, whole):
    answer = optimal_designs(cube, Judging("peak", exclude_locked=True), top=100)
    status = whole["status"].values.reshape(-1, whole.sizes["frequency_ratio"])
    missing = (status == -1).any(axis=1)
    failed = ~missing & (status > 1).any(axis=1)
    assert answer.attrs["designs"] == len(status)
    assert answer.attrs["incomplete"] == missing.sum() > 0
    assert answer.attrs["failed"] == failed.sum() > 0
    assert answer.attrs["complete"] == 1 - missing.mean()
    left = len(status) - missing.sum() - failed.sum() - answer.attrs["locked"]
    assert answer.sizes["rank"] == left
    few = optimal_designs(cube, Judging("peak", ranges={"stick_fraction": (2.0, 8.8)}), top=100)
    assert few.sizes["rank"] + few.attrs["outside"] == len(status) - missing.sum() - failed.sum()


def test_a_study_of_which_a_part_is_computed_recommends_nothing(cube):
    brief = optimal_designs(cube).attrs["brief"]
    assert brief["damper"] is None
    assert brief["sentences"][0].startswith("Only ")
    assert brief["rows"][0][0] == "least so far"
    assert brief["next"] == "damperlab run answers"


def test_a_single_frequency_is_no_judgement_over_a_band_and_the_answer_says_so(cube, finished):
    cube = finished
    alone = cube.isel(frequency_ratio=[3])
    for objective in ("resonance", "peak", "band_mean", "band_rms"):
        answer = optimal_designs(alone, Judging(objective))
        assert (
            "Only one frequency was computed, r = 1: the judgement applies to that frequency alone"
            in (answer.attrs["note"])
        )
        np.testing.assert_allclose(
            answer["value"], optimal_designs(cube, Judging("resonance"))["value"], rtol=1e-15
        )
    near = optimal_designs(cube, Judging("resonance"))
    assert "peak" in near.attrs["brief"]["next"]
    assert "next_frequencies" not in optimal_designs(cube).attrs
    answer = optimal_designs(alone)
    assert answer.attrs["next_frequencies"] == {"start": 0.8, "stop": 1.25, "num": 19}
    assert "{start: 0.8, stop: 1.25, num: 19}" in answer.attrs["brief"]["next"]
    assert "one_frequency" in {note["kind"] for note in answer.attrs["notes"]}
    assert answer.attrs["brief"]["damper"] is None
    band = optimal_designs(alone, Judging(band=(0.9, 1.1)))
    assert (band.attrs["objective"], band.attrs["band"]) == ("peak", [1.0, 1.0])
    np.testing.assert_array_equal(band["value"], optimal_designs(alone)["value"])


def test_a_study_that_keeps_little_is_ranked_by_what_it_keeps(cube):
    answer = optimal_designs(cube[["amplitude_ratio", "status"]], Judging("peak"), top=3)
    assert answer.sizes["rank"] == 3
    assert np.isnan(answer["error"]).all()
    assert (answer["response_class"] == -1).all()
    assert np.isnan(answer["locked_share"]).all()


def test_the_end_of_a_range_is_the_grid_point_that_a_person_means(whole):
    shifted = whole.assign_coords(friction_ratio=np.nextafter([0.0, 0.2, 0.4, 0.7], 1.0))
    narrow = optimal_designs(shifted, Judging("peak", ranges={"friction_ratio": (0.2, 0.7)}), top=1000)
    assert set(narrow["friction_ratio"].values) == set(shifted["friction_ratio"].values[1:])
