"""Maps and curves: what is in them is what is in the cube, and they say what was chosen and what is missing."""

import numpy as np
import pytest
from tests.studies.solving import solved

import damperlab.studies.answers.resonance_map
from damperlab.service.cli.words import map_brief, response_brief
from damperlab.studies.answers.frequency_response import frequency_response
from damperlab.studies.answers.phrases import Phrases
from damperlab.studies.answers.resonance_map import resonance_map
from damperlab.studies.definition import parse_study
from damperlab.studies.questions import Selection
from damperlab.studies.variables import Status


def test_a_map_holds_the_slice_with_error_class_and_status(cube, whole):
    answer = resonance_map(
        cube,
        "clearance_ratio",
        "friction_ratio",
        Selection(at={"restitution": 0.55, "frequency_ratio": 1.19}),
    )
    assert answer["amplitude_ratio"].dims == ("friction_ratio", "clearance_ratio")
    for name in ("amplitude_ratio", "amplitude_error", "response_class", "status"):
        expected = whole[name].values[0, 1, 0, :, :, 4].T
        np.testing.assert_array_equal(answer[name], expected)
        assert answer[name].attrs["units"] == whole[name].attrs["units"]
    status = whole["status"].values[0, 1, 0, :, :, 4]
    assert answer.attrs["complete"] == (status >= 0).mean()
    assert answer.attrs["points_failed"] == (status > 1).sum()
    assert answer["restitution"].item() == 0.5
    assert answer["frequency_ratio"].item() == 1.2


@pytest.mark.parametrize(
    ("friction", "damping", "first"),
    [
        (3.0, 0.02, "Friction clamps the structure to its base at every point: nothing is damped."),
        (0.0, 0.0, "The response grows without bound at 1 of 2 points."),
        (0.0, 0.02, "Amplitude ratio X/Z"),
    ],
)
def test_a_locked_or_unbounded_structure_is_the_first_thing_said(friction, damping, first) -> None:
    axes = {"frequency_ratio": [0.9, 1.0], "friction_ratio": [friction]}
    cube = solved(parse_study({"damping_ratio": damping, "particle": False, "axes": axes}))
    curve, plane = frequency_response(cube), resonance_map(cube, "frequency_ratio", "friction_ratio")
    for brief in (
        response_brief(curve, "amplitude_ratio", Phrases.of(cube)),
        map_brief(plane, "amplitude_ratio", Phrases.of(cube), False, cube.sizes),
    ):
        assert brief.sentences[0].startswith(first)


def test_dimensions_that_were_not_asked_for_are_those_of_the_best_design_and_said(whole):
    whole["status"][:] = 0
    whole["response_class"][:] = 3
    whole["amplitude_ratio"] = whole["amplitude_ratio"].fillna(9.0)
    whole["amplitude_error"][:] = 0.0
    worst = whole["amplitude_ratio"].max("frequency_ratio")
    best = {str(name): float(worst[name][at]) for name, at in worst.argmin(list(worst.dims)).items()}
    answer = resonance_map(whole, "friction_ratio", "restitution")
    assert answer["clearance_ratio"].item() == best["clearance_ratio"]
    assert f"d/Z = {best['clearance_ratio']:g} (of the best design)" in answer.attrs["note"]
    curve = frequency_response(whole)
    assert {name: curve[name].item() for name in best} == best
    # among those at what is named
    held = worst.sel(clearance_ratio=2.0)
    curve = frequency_response(whole, Selection(at={"clearance_ratio": 2.0}))
    assert curve["amplitude_ratio"].max() == held.min()
    # nothing leads where nothing is computed: the first point of the grid
    whole["status"][:] = Status.NOT_COMPUTED
    assert frequency_response(whole)["clearance_ratio"].item() == 1.0


def test_a_map_without_a_word_on_the_frequency_is_the_worst_over_the_band_and_says_so(cube):
    answer = resonance_map(cube, "friction_ratio", "restitution")
    worst = resonance_map(cube, "friction_ratio", "restitution", over="frequency_ratio", reduce="max")
    for name in worst.data_vars:
        np.testing.assert_array_equal(answer[name], worst[name])
    assert "largest value over the study's 6 frequencies from r = 0.7 to 1.25" in answer.attrs["note"]
    alone = resonance_map(cube, "friction_ratio", "restitution", Selection(at={"frequency_ratio": 1.0}))
    assert "r = 1 alone; leave out the frequency" in alone.attrs["note"]
    single = resonance_map(cube.isel(frequency_ratio=[3]), "friction_ratio", "restitution")
    assert "Only one frequency was computed, r = 1" in single.attrs["note"]
    codes = resonance_map(cube, "friction_ratio", "restitution", Selection("response_class"))
    assert codes["frequency_ratio"].item() == 1.0
    assert "leave out the frequency" not in codes.attrs["note"]
    assert (
        "Shown at r = 1 alone: a class or a code has no largest value over the band." in codes.attrs["note"]
    )


def test_a_partly_computed_band_says_how_much_of_each_point_is_there(cube, whole):
    answer = resonance_map(cube, "clearance_ratio", "friction_ratio", Selection(at={"restitution": 0.5}))
    expected = (whole["status"].values[0, 1, 0] >= 0).mean(axis=-1).T
    np.testing.assert_allclose(answer["computed_share"], expected, rtol=1e-15)
    assert 0 < answer.attrs["complete"] < 1


def test_any_two_dimensions_make_a_map(cube, whole):
    answer = resonance_map(
        cube,
        "frequency_ratio",
        "restitution",
        Selection("period", at={"friction_ratio": 0.4, "clearance_ratio": 1.0}),
    )
    expected = whole["period"].values[0, :, 0, 0, 2, :].astype(float)
    expected[expected < 0] = np.nan
    np.testing.assert_array_equal(answer["period"], expected)
    one_row = resonance_map(cube, "mass_ratio", "restitution")
    assert one_row["amplitude_ratio"].shape == (3, 1)


@pytest.mark.parametrize("budget", [45, 10**6])
@pytest.mark.parametrize("reduce", ["max", "min"])
def test_an_extremum_over_a_dimension_brings_its_place(cube, whole, monkeypatch, budget, reduce):
    monkeypatch.setattr(damperlab.studies.answers.resonance_map, "BUDGET", budget)
    answer = resonance_map(
        cube,
        "clearance_ratio",
        "friction_ratio",
        Selection(at={"restitution": 0.8}),
        over="frequency_ratio",
        reduce=reduce,
    )
    values = whole["amplitude_ratio"].values[0, 2, 0].transpose(2, 1, 0)
    known = np.isfinite(values).any(axis=0)
    failed = whole["status"].values[0, 2, 0].transpose(2, 1, 0) > Status.MAX_CYCLES
    if reduce == "max":
        # a point that failed may be larger than any other
        hidden = known & failed.any(axis=0)
        assert hidden.any()
        assert np.isnan(answer["amplitude_ratio"].values[hidden]).all()
        assert (answer["status"].values[hidden] > Status.MAX_CYCLES).all()
        known &= ~failed.any(axis=0)
    assert not np.isnan(answer["amplitude_ratio"].values[known]).any()
    fill = -np.inf if reduce == "max" else np.inf
    filled = np.where(np.isnan(values), fill, values)
    place = filled.argmax(axis=0) if reduce == "max" else filled.argmin(axis=0)
    for name in ("amplitude_ratio", "amplitude_error", "response_class", "status"):
        source = whole[name].values[0, 2, 0].transpose(2, 1, 0)
        expected = np.take_along_axis(source, place[None], axis=0)[0]
        np.testing.assert_array_equal(answer[name].values[known], expected[known])
    frequencies = whole["frequency_ratio"].values[place]
    np.testing.assert_array_equal(answer["frequency_ratio_at"].values[known], frequencies[known])
    status = whole["status"].values[0, 2, 0]
    assert answer.attrs["complete"] == (status >= 0).mean() < 1
    assert answer.attrs["points_failed"] == (status > 1).sum() > 0


@pytest.mark.parametrize(("budget", "reduce"), [(45, "max"), (10**6, "min"), (1, "mean"), (10**6, "mean")])
def test_a_reduction_is_that_of_the_worst_frequency(cube, whole, monkeypatch, budget, reduce):
    monkeypatch.setattr(damperlab.studies.answers.resonance_map, "BUDGET", budget)
    answer = resonance_map(cube, "clearance_ratio", "friction_ratio", over="restitution", reduce=reduce)
    part = whole.isel(damping_ratio=0, mass_ratio=0)
    worst = part["amplitude_ratio"].max("frequency_ratio")
    worst = worst.where((part["status"] <= Status.MAX_CYCLES).all("frequency_ratio"))
    if reduce == "max":
        worst = worst.where(
            worst.notnull() | (part["status"] == Status.NOT_COMPUTED).all("frequency_ratio"), np.inf
        )
    expected = getattr(worst, reduce)("restitution").transpose("friction_ratio", "clearance_ratio")
    expected = expected.where(np.isfinite(expected))  # infinite where one failed
    np.testing.assert_allclose(answer["amplitude_ratio"], expected, rtol=4 * np.finfo(float).eps)
    assert (answer.attrs["over"], answer.attrs["worst_over"]) == ("restitution", "frequency_ratio")
    assert answer.attrs["points"] == part["status"].size
    assert answer.attrs["complete"] == float((part["status"] >= 0).mean())
    if reduce == "mean":
        assert "frequency_ratio_at" not in answer
        assert "response_class" not in answer
        return
    known = np.isfinite(expected.values)
    row, column = np.argwhere(known)[0]
    there = {"restitution": "restitution_at", "frequency_ratio": "frequency_ratio_at"}
    place = {name: answer[at].values[row, column] for name, at in there.items()}
    cell = part.isel(friction_ratio=row, clearance_ratio=column).sel(place)
    assert float(cell["amplitude_ratio"]) == expected.values[row, column]


def test_a_map_where_nothing_is_known_is_empty_not_wrong(cube):
    empty = cube.isel(clearance_ratio=slice(0, 2)).copy(deep=True).load()
    empty["amplitude_ratio"][:] = np.nan
    empty["status"][:] = -1
    for reduce in ("max", "min", "mean"):
        answer = resonance_map(empty, "clearance_ratio", "restitution", over="frequency_ratio", reduce=reduce)
        assert np.isnan(answer["amplitude_ratio"]).all()
        assert (answer["status"] == -1).all()
        assert answer.attrs["complete"] == 0


def test_a_value_a_step_beyond_its_axis_is_answered_at_its_end(cube):
    at = {"clearance_ratio": 30.0, "friction_ratio": 0.8, "restitution": 0.9, "mass_ratio": 0.3}
    answer = frequency_response(cube, Selection(at=at))
    ends = {name: answer[name].item() for name in at}
    assert ends == {
        "clearance_ratio": 20.0,
        "friction_ratio": pytest.approx(0.6),
        "restitution": 0.8,
        "mass_ratio": 0.1,
    }
    assert answer.attrs["note"].count("the grid point nearest to the") == 4


def test_a_curve_runs_along_the_frequency(cube, whole):
    at = {"clearance_ratio": 9.0, "friction_ratio": 0.2, "restitution": 0.2}
    answer = frequency_response(cube, Selection("amplitude_ratio_rms", at=at))
    np.testing.assert_array_equal(
        answer["amplitude_ratio_rms"], whole["amplitude_ratio_rms"].values[0, 0, 0, 3, 1]
    )
    for name in ("amplitude_error", "response_class", "status"):
        np.testing.assert_array_equal(answer[name], whole[name].values[0, 0, 0, 3, 1])
    assert answer["clearance_ratio"].item() == 10.0
    assert answer.attrs["complete"] == (whole["status"].values[0, 0, 0, 3, 1] >= 0).mean()


def test_what_was_asked_for_is_said_as_people_write_it(whole):
    whole["status"][:] = 0
    whole["response_class"][:] = 3
    third = np.arange(4) * 0.2
    third[3] = np.nextafter(0.6, 1)
    asked = whole.assign_coords(friction_ratio=third)
    at = {"friction_ratio": 0.6, "clearance_ratio": 3.0}  # the first a rounding off the grid
    note = frequency_response(asked, Selection(at=at)).attrs["note"]
    assert "friction ratio γ_F = 0.6." in note
    assert "clearance ratio d/Z = 2 (the grid point nearest to the 3 asked for)" in note
    assert "coefficient of restitution e = 0.5 (of the best design)" in note
