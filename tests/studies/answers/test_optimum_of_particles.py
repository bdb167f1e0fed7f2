"""The optimum of drawn particle studies beside brute force on grids ten times finer."""

from itertools import product
from typing import Any

import pytest
import xarray as xr
from tests.benchmarks.optimum import drawn, finer, solved

from damperlab.studies.answers.flatness import LOSS
from damperlab.studies.answers.optimal_designs import optimal_designs
from damperlab.studies.answers.refine import refine_optimum
from damperlab.studies.definition import parse_study
from damperlab.studies.questions import Search
from damperlab.studies.variables import DIMENSIONS

PARAMETERS = ("clearance_ratio", "friction_ratio")


@pytest.fixture(scope="module", params=[1, 2, 5])
def compared(request: pytest.FixtureRequest) -> tuple[dict[str, Any], xr.Dataset, xr.Dataset]:
    document = drawn(request.param, coarse=3, frequencies=3)
    return document, solved(parse_study(document)), solved(finer(document))


def test_the_fine_optimum_lies_within_the_stated_flatness_or_the_grid_is_said_to_be_too_coarse(
    compared: tuple[dict[str, Any], xr.Dataset, xr.Dataset],
) -> None:
    _, cube, fine = compared
    best, truth = optimal_designs(cube, top=1), optimal_designs(fine, top=1)
    assert truth["value"].item() <= best["value"].item()  # the coarse grid is part of the fine one
    inside = True
    for entry in best.attrs["flatness"]:
        low = entry["low"] if entry["below"] is None else entry["below"]
        high = entry["high"] if entry["above"] is None else entry["above"]
        inside &= low <= truth[entry["dimension"]].item() <= high
    close = truth["value"].item() >= (1 - LOSS) * best["value"].item()
    resolved = all(entry["resolved"] for entry in best.attrs["flatness"])
    # a grid that resolves its optimum has the fine one within its flatness, or nothing much better anywhere
    assert not resolved or inside or close
    assert resolved == (
        not {"rugged", "neighbourhood_unknown"} & {note["kind"] for note in best.attrs["notes"]}
    )


@pytest.mark.night
def test_refining_finds_what_brute_force_finds_nearby_with_far_fewer_points(
    compared: tuple[dict[str, Any], xr.Dataset, xr.Dataset],
) -> None:
    document, cube, fine = compared
    study = parse_study(document)
    steps = {name: abs(float(fine[name].values[1] - fine[name].values[0])) for name in PARAMETERS}
    cubes = {"coarse": cube}
    step = refine_optimum(study, cubes, Search(min(steps.values())))
    while step.studies and len(cubes) < 200:
        for follow_up in step.studies:
            cubes[str(len(cubes))] = solved(follow_up)
        step = refine_optimum(study, cubes, Search(min(steps.values())))
    assert step.known
    computed: set[tuple[float, ...]] = set()  # a study takes over the points that earlier ones hold
    for other in cubes.values():
        computed.update(product(*(other[name].values.tolist() for name in DIMENSIONS)))
    assert step.spent["points"] == len(computed) < step.fine_points / 10
    value, coarse = step.found["value"], optimal_designs(cube, top=1)["value"].item()
    assert value <= coarse
    # as good as every fine design between it and its neighbours on the coarse grid that it was known to be better than
    near = fine
    for name in PARAMETERS:
        close = abs(fine[name].values - step.found[name]) <= 1.01 * steps[name]
        near = near.isel({name: close.nonzero()[0]})
    around = optimal_designs(near, top=1)["value"].item()
    assert value <= around * (1 + LOSS)
