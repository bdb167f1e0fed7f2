"""Refining on landscapes whose truth is known: several dips, ruggedness, errors that shrink with the tolerance."""

import json
import zlib
from collections.abc import Callable
from itertools import product
from typing import Any

import numpy as np
import pytest
import xarray as xr

from damperlab.studies.answers.follow_up import Refinement, cover
from damperlab.studies.answers.optimal_designs import merged_designs
from damperlab.studies.answers.refine import refine_optimum
from damperlab.studies.definition import Study, parse_study
from damperlab.studies.questions import Judging, Search
from damperlab.studies.variables import DIMENSIONS, ResponseClass

Landscape = Callable[[np.ndarray, np.ndarray], np.ndarray]
CYCLES = 0.36
"""Cycles times the squared relative error."""


def study_of(clearance: Any, friction: Any, tolerance: float = 0.02) -> Study:
    return parse_study(
        {
            "name": "landscape",
            "damping_ratio": 0.01,
            "axes": {
                "restitution": 0.5,
                "mass_ratio": 0.1,
                "clearance_ratio": clearance,
                "friction_ratio": friction,
                "frequency_ratio": [1.0],
            },
            "steady": {"tolerance": tolerance},
        }
    )


def measured(study: Study, landscape: Landscape, noisy: bool, seed: int = 0) -> xr.Dataset:
    """Evaluate a landscape as a solver would: every value off by a normal error of its tolerance."""
    shape = study.shape
    d, g = study.coordinates["clearance_ratio"], study.coordinates["friction_ratio"]
    truth = landscape(d[:, None], g[None, :]).reshape(shape)
    relative = study.steady.tolerance if noisy else 1e-15
    values = truth.copy()
    for place in np.ndindex(d.size, g.size):
        # the same design at the same tolerance is the same run, whatever study asks for it
        text = f"{seed} {d[place[0]]!r} {g[place[1]]!r} {study.steady.tolerance}"
        rng = np.random.default_rng(zlib.crc32(text.encode()))
        at = (0, 0, 0, *place, 0)
        values[at] *= 1 + relative * rng.standard_normal()
    columns = {
        "amplitude_ratio": values,
        "amplitude_error": relative * truth,
        "response_class": np.full(shape, ResponseClass.CHAOTIC, np.int8),
        "cycles": np.full(shape, int(CYCLES / relative**2) if noisy else 300, np.int32),
        "status": np.zeros(shape, np.int8),
    }
    variables = {name: (DIMENSIONS, array) for name, array in columns.items()}
    return xr.Dataset(variables, study.coordinates, {"study": json.dumps(study.document())})


def pursued(
    study: Study, landscape: Landscape, noisy: bool, step: Callable[..., Refinement], seed: int = 0
) -> tuple[Refinement, dict[str, xr.Dataset]]:
    cubes = {"0": measured(study, landscape, noisy, seed)}
    for _ in range(60):
        found = step(study, cubes)
        if not found.studies:
            return found, cubes
        for each in found.studies:
            cubes[str(len(cubes))] = measured(each, landscape, noisy, seed)
    raise AssertionError(f"no end: {found.say()}")


GRID = {"start": 1.0, "stop": 5.0, "num": 9}, {"start": 0.0, "stop": 0.8, "num": 9}


def two_dips(d: np.ndarray, g: np.ndarray) -> np.ndarray:
    """A wide dip whose floor is 1.2 at a grid point, and a narrow one of 0.9 between grid points."""
    wide = 1.2 + (d - 2.0) ** 2 + 20 * (g - 0.6) ** 2
    narrow = 0.9 + 1.6 * np.abs(d - 4.2) + 5 * np.abs(g - 0.23)
    return np.minimum(wide, narrow)


def test_the_deeper_of_two_dips_is_found_though_the_grid_shows_the_other_one() -> None:
    study = study_of(*GRID)
    coarse = merged_designs({"0": measured(study, two_dips, noisy=False)})
    assert coarse["clearance_ratio"].values[0] == 2.0
    found, cubes = pursued(study, two_dips, False, lambda s, c: refine_optimum(s, c, Search(0.01)))
    assert found.known
    # the best of all that was computed, one design once
    merged = merged_designs(cubes, top=3)
    assert merged["value"].values[0] == found.found["value"] < coarse["value"].values[0]
    assert merged.attrs["studies"] == list(cubes)
    assert found.found["clearance_ratio"] == pytest.approx(4.2, abs=0.01)
    assert found.found["friction_ratio"] == pytest.approx(0.23, abs=0.01)
    # a step of 0.01 off in either parameter costs 0.066 at most
    assert 0.9 <= found.found["value"] <= 0.966
    assert found.fine_points == 401 * 81
    computed: set[tuple[float, ...]] = set()  # a study takes over the points that earlier ones hold
    for cube in cubes.values():
        computed.update(product(*(cube[name].values.tolist() for name in DIMENSIONS)))
    assert found.spent["points"] == len(computed) < found.fine_points / 10


@pytest.mark.parametrize(
    "box",
    [
        {"friction_ratio": (0.0, 0.7)},
        {"friction_ratio": (0.43, 1.0), "clearance_ratio": (4.0, 6.5)},
    ],
)
def test_a_box_is_searched_up_to_ends_that_lie_between_the_values_of_the_grid(
    box: dict[str, tuple[float, float]],
) -> None:
    """The landscape falls towards a corner of the box, so its least value there has a closed form."""
    study = study_of([3.0, 5.0, 8.0], [0.0, 0.2, 0.4, 0.6, 0.8])

    def falling(d: np.ndarray, g: np.ndarray) -> np.ndarray:
        return 6.0 - 4.0 * g - 0.1 * d

    found, cubes = pursued(
        study, falling, False, lambda s, c: refine_optimum(s, c, Search(0.02), Judging(ranges=box))
    )
    searched = {}
    for name in ("clearance_ratio", "friction_ratio"):
        axis = study.coordinates[name]
        searched[name] = np.clip(box.get(name, (-np.inf, np.inf)), axis.min(), axis.max())
    assert found.known
    for name, (_, end) in searched.items():
        assert found.found[name] == pytest.approx(end, rel=1e-9)
    for name, (low, high) in box.items():
        computed = [cube[name].values for place, cube in cubes.items() if place != "0"]
        assert all(low - 1e-9 <= each.min() and each.max() <= high + 1e-9 for each in computed)
    sides = [np.ceil((high - low) / 0.02 - 1e-6) + 1 for low, high in searched.values()]
    assert found.fine_points == np.prod(sides)
    # what was computed for one box says nothing false about another
    elsewhere = Judging(ranges={"friction_ratio": (0.0, 0.1)})
    assert not refine_optimum(study, cubes, Search(0.02), elsewhere).known


def test_errors_are_not_taken_for_dips() -> None:
    study = study_of(*GRID)

    def bowl(d: np.ndarray, g: np.ndarray) -> np.ndarray:
        return 1.0 + 0.3 * (d - 3.2) ** 2 + 4 * (g - 0.43) ** 2

    for seed in range(2):
        found, _ = pursued(study, bowl, True, lambda s, c: refine_optimum(s, c, Search(1e-3)), seed)
        assert found.known
        # the search ends where the errors of 2 % end it, far above steps of a thousandth
        assert found.spent["points"] < 3000
        assert found.fine_points == 0
        assert "The errors hide the differences between neighbours" in found.say()
        truth = float(bowl(np.array(found.found["clearance_ratio"]), np.array(found.found["friction_ratio"])))
        assert truth <= 1.08  # four standard errors of the least


def test_designs_are_covered_by_few_grids_with_little_else() -> None:
    rng = np.random.default_rng(2)
    designs = np.unique(rng.integers(0, 12, (20, 2)), axis=0).astype(float)
    grids = cover(designs)
    assert len(grids) <= 8
    held = {
        tuple(map(float, row)) for axes in grids for row in np.stack(np.meshgrid(*axes), -1).reshape(-1, 2)
    }
    assert {tuple(map(float, row)) for row in designs} <= held
    diagonal = np.stack([np.arange(6.0)] * 2, axis=1)
    assert sum(np.prod([axis.size for axis in axes]) for axes in cover(diagonal)) <= 9
    block = np.stack(np.meshgrid([1.0, 2.0], [3.0, 4.0]), -1).reshape(-1, 2)
    assert len(cover(block)) == 1
