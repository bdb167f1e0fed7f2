"""What storing costs: writing a block, the size of ten million points, opening them over HTTP and reading a plane.

A client's first read makes xarray load half of its libraries; they are loaded before the clock starts, and said apart.
On a machine where others compute, CPU time tells more than wall time.
"""

import json
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
from tests.benchmarks._service import cpu_seconds, serving

from damperlab.studies.definition import Study, parse_study
from damperlab.studies.plan import Block, make_plan, plan_with_chunk
from damperlab.studies.store.cube.block_file import write_region
from damperlab.studies.store.cube.description import stored_variables
from damperlab.studies.store.record import BlockOutcome
from damperlab.studies.store.store import Store
from damperlab.worker.dispatch.cost_model import seconds_per_point

BLOCK = (1, 1, 1, 200, 200, 1)
"""40,000 points: more than any block of a study has whose points take longer than 50 microseconds."""
SMALL_BLOCK = (1, 1, 1, 32, 32, 1)
"""1,024 points: a block of two seconds at two milliseconds a point."""
BLOCKS = 12
SECONDS_OF_A_BLOCK = 2.0
"""For which the planner cuts: what writing may take is said as a share of it."""


AXES = {
    "restitution": {"start": 0.3, "stop": 0.9, "num": 4},
    "mass_ratio": {"start": 0.02, "stop": 0.3, "num": 4},
    "clearance_ratio": {"start": 1.0, "stop": 25.0, "num": 50},
    "friction_ratio": {"start": 0.0, "stop": 0.8, "num": 50},
    "frequency_ratio": {"start": 0.8, "stop": 1.25, "num": 250},
}
"""Ten million points."""
METRICS = ["amplitude_ratio", "amplitude_error", "response_class"]
"""What a map reads; the rest would only make the writing longer."""
WRITERS = 8


def build(data_dir: Path) -> Study:
    """Make a cube of smooth values, every block done."""
    study = parse_study({"name": "synthetic", "damping_ratio": 0.0038, "axes": AXES, "metrics": METRICS})
    plan = make_plan(study, seconds_per_point)
    with closing(Store.open(data_dir)) as store:
        record, _ = store.submit(study, plan, {})
        path = store.cube_path(record.id)

        def write(index: int) -> BlockOutcome:
            block = plan.block(index)
            write_region(path, block, _values(study, block))
            return BlockOutcome(index, block.points, 0, 0.0, 0.0)

        # writing waits for the disk most of the time
        with ThreadPoolExecutor(WRITERS) as pool:
            for outcome in pool.map(write, range(plan.count)):
                store.mark(record.id, outcome)
        store.set_state(record.id, "done")
    return study


def _values(study: Study, block: Block) -> dict[str, np.ndarray]:
    coordinates = [
        values[part] for values, part in zip(study.coordinates.values(), block.slices, strict=True)
    ]
    *_, clearance, friction, r = np.meshgrid(*coordinates, indexing="ij")
    smooth = 1 / np.hypot(1 - r**2, 0.1 + 0.2 * friction) + np.sin(40 * clearance * r) ** 2
    return {
        v.name: np.zeros(block.shape, v.dtype) if np.dtype(v.dtype).kind == "i" else smooth.astype(v.dtype)
        for v in stored_variables(study)
    }


def writing(folder: Path) -> dict[str, float]:
    """Write blocks of every standard variable with all their bits in use; milliseconds for each, and the share of a block."""
    figures = {}
    for chunk in (SMALL_BLOCK, BLOCK):
        study = parse_study(
            {
                "name": f"writing {chunk}",
                "damping_ratio": 0.0038,
                "axes": {
                    "clearance_ratio": {"start": 1, "stop": 25, "num": chunk[3]},
                    "friction_ratio": {"start": 0.1, "stop": 0.8, "num": chunk[4]},
                    "restitution": 0.47,
                    "mass_ratio": 0.1,
                    "frequency_ratio": {"start": 0.8, "stop": 1.2, "num": BLOCKS},
                },
            }
        )
        plan = plan_with_chunk(study, chunk, lambda _, at: np.ones(len(at["mass_ratio"])))
        store = Store.open(folder)
        record, _ = store.submit(study, plan, {})
        random = np.random.default_rng(1)
        wall, cpu = [], []
        for index in range(BLOCKS):
            block = plan.block(index)
            values = {
                v.name: (random.random(block.shape) * 3).astype(v.dtype) for v in stored_variables(study)
            }
            began, began_cpu = time.perf_counter(), time.process_time()
            write_region(store.cube_path(record.id), block, values, f"g{index}")
            wall.append(time.perf_counter() - began)
            cpu.append(time.process_time() - began_cpu)
        shelf, _ = store.snapshot(record.id)
        kept = sum(entry.size for entry in shelf.entries())
        raw = sum(value.nbytes for value in values.values()) * BLOCKS
        store.close()
        name = f"block of {block.points} points, {len(values)} variables"
        figures[f"{name}, every bit random: stored over raw size"] = kept / raw
        # the first one reads the metadata, once for each worker and study
        figures[f"{name}: first, wall [ms]"] = 1e3 * wall[0]
        figures[f"{name}: wall, median [ms]"] = 1e3 * float(np.median(wall[1:]))
        figures[f"{name}: CPU, median [ms]"] = 1e3 * float(np.median(cpu[1:]))
        figures[f"{name}: wall over {SECONDS_OF_A_BLOCK:g} s"] = (
            float(np.median(wall[1:])) / SECONDS_OF_A_BLOCK
        )
    return figures


def reading(folder: Path) -> dict[str, float]:
    """Serve ten million points; open them from a fresh process and read planes of 50 by 50."""
    study = build(folder)
    with closing(Store.open(folder)) as store:
        study_id = store.find("synthetic").id
        raw = store.usage().bytes
        stored = sum(entry.size for entry in store.shelf.entries())
    figures = {"points": float(study.points), "stored over raw size": stored / raw}
    with serving(folder, None) as (url, pid):
        before = cpu_seconds(pid)
        child = [sys.executable, "-m", "tests.benchmarks.storing", f"{url}/api/v1/studies/{study_id}/zarr"]
        told = subprocess.run(child, capture_output=True, text=True, check=True, timeout=300)
        figures |= json.loads(told.stdout)
        figures["all of it: server, CPU [ms]"] = 1e3 * (cpu_seconds(pid) - before)
    return figures


def read(url: str) -> dict[str, float]:
    """Open and read; this is the child process."""
    figures = {}
    began = time.perf_counter(), time.process_time()

    def lap(name: str) -> None:
        nonlocal began
        now = time.perf_counter(), time.process_time()
        figures[f"{name}: wall [ms]"] = 1e3 * (now[0] - began[0])
        figures[f"{name}: client, CPU [ms]"] = 1e3 * (now[1] - began[1])
        began = time.perf_counter(), time.process_time()

    import aiohttp  # noqa: F401
    import dask.array  # noqa: F401  (which xarray imports as it indexes for the first time)
    import fsspec.implementations.http  # noqa: F401
    import xarray as xr
    import zarr  # noqa: F401

    lap("imports")
    cube = xr.open_zarr(url, chunks=None)
    plane = cube["amplitude_ratio"].isel(damping_ratio=0, restitution=0, mass_ratio=0)
    plane.sel(frequency_ratio=1.0, method="nearest").load()
    lap("open and read clearance x friction")
    plane.sel(frequency_ratio=0.9, method="nearest").load()
    lap("the same at another frequency")
    plane.isel(clearance_ratio=7).load()
    lap("frequency x friction")
    return figures


def run() -> dict[str, Any]:
    """Measure in a temporary folder; TMPDIR names the disk."""
    with tempfile.TemporaryDirectory() as made:
        return writing(Path(made, "writing")) | reading(Path(made, "reading"))


if __name__ == "__main__":
    print(json.dumps(read(sys.argv[1])))
