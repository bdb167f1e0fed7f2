"""The optimum of coarse particle studies beside brute force on grids ten times finer, and what refining costs.

Each study is a seeded draw of a structure, a particle and axes of clearance and friction, judged by the largest
amplitude in a band. Every point is computed by the solver; nothing is fitted.
"""

from concurrent.futures import ProcessPoolExecutor
from typing import Any

import numpy as np
import xarray as xr

from damperlab.studies.answers.optimal_designs import optimal_designs
from damperlab.studies.answers.refine import refine_optimum
from damperlab.studies.definition import Study, parse_study
from damperlab.studies.plan import Block
from damperlab.studies.variables import DIMENSIONS
from damperlab.worker.block import solve_block

COARSE = 4
FINER = 10
"""Steps of the fine grid to one of the coarse."""
ROUNDS = 20
FREQUENCIES = 5


def drawn(seed: int, coarse: int = COARSE, frequencies: int = FREQUENCIES) -> dict[str, Any]:
    """Draw a study of the hybrid damper with two parameters to choose."""
    rng = np.random.default_rng(seed)
    low, high = rng.uniform(0.85, 0.95), rng.uniform(1.05, 1.15)
    clearance, friction = rng.uniform(1, 4), rng.uniform(0.05, 0.3)
    return {
        "name": f"drawn {seed}",
        "damping_ratio": float(rng.uniform(0.002, 0.03)),
        "axes": {
            "restitution": float(rng.uniform(0.2, 0.8)),
            "mass_ratio": float(rng.uniform(0.03, 0.25)),
            "clearance_ratio": {
                "start": clearance,
                "stop": clearance + rng.uniform(3, 12),
                "num": coarse,
            },
            "friction_ratio": {
                "start": friction,
                "stop": friction + rng.uniform(0.2, 0.45),
                "num": coarse,
            },
            "frequency_ratio": {"start": low, "stop": high, "num": frequencies},
        },
        "steady": {"max_cycles": 400, "tolerance": 1e-2},
    }


def finer(document: dict[str, Any]) -> Study:
    """Give the same study with both parameters in steps ten times finer, the coarse points among them."""
    axes = dict(document["axes"])
    for name in ("clearance_ratio", "friction_ratio"):
        axes[name] = axes[name] | {"num": (axes[name]["num"] - 1) * FINER + 1}
    return parse_study(document | {"axes": axes})


def solved(study: Study) -> xr.Dataset:
    """Compute a study here; the cube as the store would give it, without its attributes."""
    values = solve_block(study, Block(0, (0,) * 6, study.shape))
    return xr.Dataset({name: (DIMENSIONS, array) for name, array in values.items()}, study.coordinates)


def compare(seed: int) -> dict[str, Any]:
    """Compare one drawn study with brute force, and refine it to the fine grid's steps."""
    document = drawn(seed)
    study = parse_study(document)
    cube = solved(study)
    fine = solved(finer(document))
    best, truth = optimal_designs(cube, top=1), optimal_designs(fine, top=1)
    found: dict[str, Any] = {
        "seed": seed,
        "coarse": best["value"].item(),
        "fine": truth["value"].item(),
        "inside": True,
        "resolved": all(entry["resolved"] for entry in best.attrs["flatness"]),
    }
    for entry in best.attrs["flatness"]:
        value = truth[entry["dimension"]].item()
        low = entry["low"] if entry["below"] is None else entry["below"]
        high = entry["high"] if entry["above"] is None else entry["above"]
        found["inside"] &= bool(low <= value <= high)
        found[entry["dimension"]] = (entry["value"], value)
    steps = {name: float(np.diff(fine[name].values)[0]) for name in ("clearance_ratio", "friction_ratio")}
    cubes = {"0": cube}
    step = refine_optimum(study, cubes, min(steps.values()))
    while step.study is not None and len(cubes) < ROUNDS:
        cubes[str(len(cubes))] = solved(step.study)
        step = refine_optimum(study, cubes, min(steps.values()))
    found["refined"] = step.found["value"]
    found["refined points"] = sum(other["status"].size for other in cubes.values())
    found["fine points"] = fine["status"].size
    found["fine points at refined steps"] = step.fine_points
    return found


def run(seeds: int = 8, processes: int = 2) -> dict[str, Any]:
    """Compare a number of drawn studies, and count."""
    with ProcessPoolExecutor(processes) as pool:
        rows = list(pool.map(compare, range(seeds)))
    figures: dict[str, Any] = {f"drawn {row['seed']}": row for row in rows}
    figures["optimum of the fine grid within the stated flatness"] = sum(row["inside"] for row in rows)
    figures["of"] = seeds
    figures["more than a tenth better than the coarse one, though the grid was said to resolve it"] = sum(
        row["resolved"] and row["fine"] < 0.9 * row["coarse"] for row in rows
    )
    figures["the same, and it was said not to"] = sum(
        not row["resolved"] and row["fine"] < 0.9 * row["coarse"] for row in rows
    )
    ratios = [row["refined points"] / row["fine points at refined steps"] for row in rows]
    figures["points of refining over a grid as fine, median"] = float(np.median(ratios))
    return figures
