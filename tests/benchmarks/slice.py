"""Time and memory of a map's slice of a large cube, against one a hundred times smaller.

The cubes are written through the store's own door, block by block; their values are a cheap formula, since only
reading is measured. Every figure is taken in a process of its own, so that memory is that of the questions alone.
"""

import json
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from damperlab.studies.definition import parse_study
from damperlab.studies.plan import Block, make_plan
from damperlab.studies.questions import Selection
from damperlab.studies.store.cube.cube import stored_variables, write_region
from damperlab.studies.store.record import BlockOutcome
from damperlab.studies.store.store import Store
from damperlab.worker.dispatch.cost_model import seconds_per_point

LARGE = {
    "restitution": 4,
    "mass_ratio": 4,
    "clearance_ratio": 50,
    "friction_ratio": 50,
    "frequency_ratio": 250,
}
"""Ten million points."""
SMALL = {
    "restitution": 4,
    "mass_ratio": 4,
    "clearance_ratio": 10,
    "friction_ratio": 10,
    "frequency_ratio": 63,
}
RANGES = {
    "restitution": (0.3, 0.9),
    "mass_ratio": (0.02, 0.3),
    "clearance_ratio": (1.0, 25.0),
    "friction_ratio": (0.0, 0.8),
    "frequency_ratio": (0.8, 1.25),
}
METRICS = ["amplitude_ratio", "amplitude_error", "response_class"]
"""What a map reads; the rest would only make the writing longer."""
WRITERS = 8
QUESTIONS: dict[str, dict[str, Any]] = {
    "clearance x friction at r = 1": {
        "x": "clearance_ratio",
        "y": "friction_ratio",
        "selection": Selection(at={"frequency_ratio": 1.0}),
    },
    "clearance x friction, worst over the band": {"x": "clearance_ratio", "y": "friction_ratio"},
    "frequency x friction": {"x": "frequency_ratio", "y": "friction_ratio"},
    "frequency x clearance": {"x": "frequency_ratio", "y": "clearance_ratio"},
    "mass x restitution at r = 1": {
        "x": "mass_ratio",
        "y": "restitution",
        "selection": Selection(at={"frequency_ratio": 1.0}),
    },
}


def build(data_dir: Path, sizes: dict[str, int]) -> str:
    """Make a cube of these sizes, every block done; return the study's id."""
    axes = {
        name: {"start": RANGES[name][0], "stop": RANGES[name][1], "num": number}
        for name, number in sizes.items()
    }
    study = parse_study({"name": "synthetic", "damping_ratio": 0.0038, "axes": axes, "metrics": METRICS})
    plan = make_plan(study, seconds_per_point)
    store = Store.open(data_dir)
    try:
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
    finally:
        store.close()
    return record.id


def _values(study: Any, block: Block) -> dict[str, np.ndarray]:
    coordinates = [
        values[part] for values, part in zip(study.coordinates.values(), block.slices, strict=True)
    ]
    *_, clearance, friction, r = np.meshgrid(*coordinates, indexing="ij")
    smooth = 1 / np.hypot(1 - r**2, 0.1 + 0.2 * friction) + np.sin(40 * clearance * r) ** 2
    return {
        v.name: np.zeros(block.shape, v.dtype) if np.dtype(v.dtype).kind == "i" else smooth.astype(v.dtype)
        for v in stored_variables(study)
    }


def ask(data_dir: str, study_id: str) -> dict[str, float]:
    """Ask every question of a cube: the first time, and again; this is the child process."""
    from damperlab.studies.answers.resonance_map import resonance_map

    figures: dict[str, float] = {"megabytes before": _resident()}
    began = time.perf_counter()
    store = Store.open(Path(data_dir))
    for name, question in QUESTIONS.items():
        resonance_map(store.cube(study_id), **question)
        figures[f"{name}: first [ms]"] = 1e3 * (time.perf_counter() - began)
        times = []
        for _ in range(5):
            began = time.perf_counter()
            resonance_map(store.cube(study_id), **question)
            times.append(time.perf_counter() - began)
        figures[f"{name}: warm [ms]"] = 1e3 * min(times)
        began = time.perf_counter()
    store.close()
    figures["megabytes after"] = _resident(peak=True)
    return figures


def _resident(peak: bool = False) -> float:
    wanted = "VmHWM" if peak else "VmRSS"
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith(wanted)) / 1024


def run() -> dict[str, Any]:
    """Build both cubes in a temporary folder and ask each."""
    figures: dict[str, Any] = {}
    for label, sizes in (("small", SMALL), ("large", LARGE)):
        with tempfile.TemporaryDirectory() as folder:
            began = time.perf_counter()
            study_id = build(Path(folder), sizes)
            figures[f"{label}: points"] = int(np.prod(list(sizes.values())))
            figures[f"{label}: written in [s]"] = time.perf_counter() - began
            command = [sys.executable, "-m", "tests.benchmarks.slice", folder, study_id]
            child = subprocess.run(command, capture_output=True, text=True, check=True, timeout=300)
            figures |= {f"{label}: {key}": value for key, value in json.loads(child.stdout).items()}
    return figures


if __name__ == "__main__":
    print(json.dumps(ask(sys.argv[1], sys.argv[2])))
