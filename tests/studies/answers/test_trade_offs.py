"""Pareto fronts, flatness and work against precision: each beside a plain computation of the whole."""

import numpy as np
import pytest
from tests.studies.answers.test_verdict import made

from damperlab.studies.answers.design_question import DESIGN
from damperlab.studies.answers.flatness import LOSS
from damperlab.studies.answers.optimal_designs import optimal_designs
from damperlab.studies.answers.pareto import pareto_front
from damperlab.studies.answers.work_precision import work_precision
from damperlab.studies.questions import Judging
from damperlab.studies.variables import DIMENSIONS, Status


def _rows(whole, band):
    """Every design that has a value everywhere in the band: coordinates and what it is judged by."""
    r = whole["frequency_ratio"].values
    counting = (r >= band[0]) & (r <= band[1])
    rows = []
    for index in np.ndindex(whole["status"].shape[:-1]):
        get = {name: whole[name].values[index][counting] for name in whole.data_vars}
        if not np.isin(get["status"], (0, 1)).all():
            continue
        width = np.ptp(r[counting])
        rows.append(
            (
                tuple(float(whole[name].values[i]) for name, i in zip(DESIGN, index, strict=True)),
                get["amplitude_ratio"].max(),
                get["impact_speed_max"].max(),
                -np.trapezoid(get["dissipation_friction"], r[counting]) / width,
            )
        )
    return rows


@pytest.mark.parametrize("budget", [30, 2**18])
@pytest.mark.parametrize(
    ("respects", "columns"),
    [
        (["amplitude", "impact_speed"], (1, 2)),
        (["amplitude", "impact_speed", "-dissipation_friction"], (1, 2, 3)),
    ],
)
def test_the_front_is_what_no_design_beats(cube, whole, monkeypatch, budget, respects, columns):
    monkeypatch.setattr("damperlab.studies.answers.slab.BUDGET", budget)
    rows = _rows(whole, (0.8, 1.2))
    points = np.array([[row[c] for c in columns] for row in rows])
    beaten = [bool(((points <= p).all(axis=1) & (points < p).any(axis=1)).any()) for p in points]
    expected = {row[0] for row, lost in zip(rows, beaten, strict=True) if not lost}
    assert 2 < len(expected) < len(rows)
    answer = pareto_front(cube, respects, Judging("peak", band=(0.8, 1.2)))
    found = {tuple(answer[name].values[i].item() for name in DESIGN) for i in range(answer.sizes["rank"])}
    assert found == expected
    assert (np.diff(answer["amplitude"]) >= 0).all()
    np.testing.assert_array_equal(answer["amplitude"], answer["value"])


@pytest.mark.parametrize("budget", [30, 2**18])
def test_designs_that_none_is_surely_better_than_may_belong_to_the_front(cube, whole, monkeypatch, budget):
    """Pair by pair: surely better is what is no worse in every respect, and better in one, even at the limits of both."""
    monkeypatch.setattr("damperlab.studies.answers.slab.BUDGET", budget)
    every = optimal_designs(cube, Judging("peak", band=(0.8, 1.2)), top=1000)
    speed = {row[0]: row[2] for row in _rows(whole, (0.8, 1.2))}
    designs = [tuple(every[name].values[i].item() for name in DESIGN) for i in range(every.sizes["rank"])]
    low = np.array([(every["lowest"].values[i], speed[one]) for i, one in enumerate(designs)])
    high = np.array([(every["highest"].values[i], speed[one]) for i, one in enumerate(designs)])
    surely = [bool(((high <= mine).all(axis=1) & (high < mine).any(axis=1)).any()) for mine in low]
    answer = pareto_front(cube, ["amplitude", "impact_speed"], Judging("peak", band=(0.8, 1.2)))
    belong = answer.sizes["rank"] + int(answer["alike"].sum())
    assert answer.attrs["as_good"] == surely.count(False) - belong > 0
    assert (
        f"{answer.attrs['as_good']} more designs may also be unbeaten within the errors"
        in answer.attrs["note"]
    )
    ended = whole["status"].where(whole["status"] != Status.MAX_CYCLES, Status.CONVERGED)
    exact = whole.assign(amplitude_error=0.0 * whole["amplitude_error"], status=ended)
    assert pareto_front(exact, ["amplitude", "impact_speed"]).attrs["as_good"] == 0
    unknown = pareto_front(whole.drop_vars("amplitude_error"), ["amplitude", "impact_speed"])
    assert "as_good" not in unknown.attrs


def test_designs_that_are_equal_in_every_respect_stand_once_and_are_counted(whole):
    whole["amplitude_ratio"][:] = 1.0
    whole["status"][:] = 0
    answer = pareto_front(whole, ["amplitude", "mass"])
    assert answer.sizes["rank"] == 1
    assert answer["alike"].item() == whole["status"].size / whole.sizes["frequency_ratio"] - 1


def test_flatness_ends_where_the_loss_is_exceeded(whole):
    whole["status"][:] = 0
    bowl = (
        1
        + 0.02 * (whole["clearance_ratio"] - 5) ** 2
        + abs(whole["friction_ratio"] - 0.2)
        + 0.0 * whole["status"]
    )
    whole["amplitude_ratio"] = bowl.transpose(*DIMENSIONS)
    answer = optimal_designs(whole)
    assert answer.attrs["objective"] == "peak"
    flat = {entry["dimension"]: entry for entry in answer.attrs["flatness"]}
    # clearance 2 costs 0.18 and 10 costs 0.5, friction a step costs 0.2: more than a tenth
    assert LOSS == 0.1
    assert flat["clearance_ratio"] == {
        "dimension": "clearance_ratio", "value": 5.0, "low": 5.0, "high": 5.0, "below": 2.0, "above": 10.0,
        "resolved": False, "worse": True, "unknown": False,
    }  # fmt: skip
    assert flat["restitution"]["resolved"]
    (rugged,) = [note for note in answer.attrs["notes"] if note["kind"] == "rugged"]
    assert rugged["values"]["dimensions"] == ["clearance_ratio", "friction_ratio"]
    assert (flat["restitution"]["low"], flat["restitution"]["below"]) == (0.2, None)
    assert "mass_ratio" not in flat
    assert (
        "coefficient of restitution e from 0.2 (end of the axis) to 0.8 (end of the axis)"
        in answer.attrs["note"]
    )


def test_a_range_of_what_a_response_does_not_have():
    """No impact is an impact speed of 0; a multiplier that is not defined is in no range."""
    cube = made([1.0, 2.0, 3.0])
    missing = np.full(cube["status"].shape, 0.5)
    missing[..., 1, 1] = np.nan  # of the second design at one frequency
    every, others = cube["friction_ratio"].values, cube["friction_ratio"].values[[0, 2]]
    expected = {
        ("impact_speed_max", (0.0, 0.9)): every,
        ("impact_speed_max", (0.1, 0.9)): others,
        ("dissipation_impact", (0.0, 0.9)): every,
        ("floquet_multiplier", (0.0, 0.9)): others,
        ("floquet_multiplier", (-np.inf, np.inf)): others,
    }
    for (name, limit), left in expected.items():
        answer = optimal_designs(cube.assign({name: (DIMENSIONS, missing)}), Judging(ranges={name: limit}))
        assert sorted(answer["friction_ratio"].values) == left.tolist()
        assert answer.attrs["outside"] == 3 - left.size


def test_work_precision_counts_every_point_that_has_a_value(cube, whole):
    answer = work_precision(cube)
    status = whole["status"].values
    good = np.isin(status, (0, 1))
    assert answer["number"].sum() == good.sum()
    assert answer.attrs["points_failed"] == (status > 1).sum()
    time = whole["run_time"].values[good]
    assert answer.attrs["seconds"] == pytest.approx(time.sum(), rel=1e-12)
    relative = (whole["amplitude_error"].values / whole["amplitude_ratio"].values)[good]
    width = 10 ** (1 / 4)
    for row in range(answer.sizes["run_time"]):
        here = answer.isel(run_time=row)
        centre = here["run_time"].item()
        inside = (time >= centre / width**0.5) & (time < centre * width**0.5)
        assert here["number"] == inside.sum()
        median = np.quantile(relative[inside], 0.5, method="inverted_cdf")
        # the upper edge of the bin that holds it, eight bins a decade
        assert median <= here["error_median"] * (1 + 1e-9) <= median * 10 ** (1 / 8) * (1 + 1e-8)
