"""The table of kinds is all that tells one kind of study from the other, and questions keep to it."""

from dataclasses import fields

import numpy as np
import pytest
import xarray as xr

from damperlab.studies.answers.query_fault import QueryFault
from damperlab.studies.answers.ranking import ranked_designs
from damperlab.studies.kinds import AMPLITUDES, HARMONIC, KINDS, SUITE, Kind, kind_of, shown_axes
from damperlab.studies.questions import Judging, Ranking
from damperlab.studies.unit_names import RESULTS


def cube_of(kind: Kind) -> xr.Dataset:
    shape = (1,) * len(kind.dimensions)
    said = {"units": "1", "long_name": "of this test"}
    values = {
        kind.metric: (kind.dimensions, np.ones(shape), said),
        "status": (kind.dimensions, np.zeros(shape, np.int8)),
    }
    axes = {
        name: (name, np.array(["el-centro"]) if name == "record" else np.ones(1), said)
        for name in kind.dimensions
    }
    return xr.Dataset(values, axes)


@pytest.mark.parametrize("kind", KINDS, ids=["harmonic", "suite", "amplitudes"])
def test_a_kind_is_told_by_its_dimensions_and_speaks_of_its_own(kind: Kind) -> None:
    assert kind_of(kind.dimensions) is kind
    assert kind.uncontrolled in kind.dimensions
    assert kind.metric in {*kind.variables, *RESULTS}
    assert set(kind.axes) <= set(kind.dimensions)
    assert kind.ranking <= {each.name for question in (Judging, Ranking) for each in fields(question)}
    answer = ranked_designs(cube_of(kind), Judging(), Ranking(), lambda others: {})
    assert answer["value"].values.tolist() == [1.0]


@pytest.mark.parametrize(
    ("kind", "judging", "ranking", "field"),
    [
        (SUITE, Judging("peak"), Ranking(), "objective"),
        (SUITE, Judging(exclude_locked=True), Ranking(), "exclude_locked"),
        (SUITE, Judging(), Ranking(pareto=("amplitude", "mass")), "pareto"),
        (SUITE, Judging(), Ranking(with_=("abc",)), "with"),
        (AMPLITUDES, Judging("peak"), Ranking(), "objective"),
        (AMPLITUDES, Judging(), Ranking(records=("el-centro",)), "records"),
        (HARMONIC, Judging(), Ranking(metric="amplitude_ratio"), "metric"),
        (HARMONIC, Judging(), Ranking(records=("el-centro",)), "records"),
    ],
)
def test_what_applies_to_the_other_kind_alone_is_refused(
    kind: Kind, judging: Judging, ranking: Ranking, field: str
) -> None:
    with pytest.raises(
        QueryFault, match=rf"^`{field}` applies to a .*, but this study is {kind.words}"
    ) as caught:
        ranked_designs(cube_of(kind), judging, ranking, lambda others: {})
    assert caught.value.fault.field == field


def test_an_axis_in_units_is_not_shown_twice() -> None:
    sizes = dict.fromkeys(HARMONIC.dimensions, 3)
    assert shown_axes(sizes, "clearance_m", None, ()) == ("clearance_m", "friction_ratio")
    assert shown_axes(sizes, None, "friction_force_n", ()) == ("clearance_ratio", "friction_force_n")
    assert "friction_ratio" not in shown_axes(sizes, "clearance_m", None, ("friction_force_n",))
