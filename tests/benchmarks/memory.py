"""Peak memory of the process that plans, submits, runs and reports a study, as the study grows.

`python -m tests.benchmarks.memory POINTS` measures one size in a fresh process.
"""

import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from threading import Event
from typing import Any

from damperlab.studies.definition import parse_study
from damperlab.studies.plan import make_plan
from damperlab.studies.store.store import Store
from damperlab.worker.cluster.cluster import connect
from damperlab.worker.dispatch.cost_model import seconds_per_point
from damperlab.worker.provenance import provenance
from damperlab.worker.run.progress import Progress
from damperlab.worker.run.runner import run_study

SIZES = (10_000, 100_000, 1_000_000, 10_000_000)
BLOCKS = 4
"""Blocks that are computed before the study is stopped."""


def peak_mib() -> float:
    """Largest resident set so far of this process, its workers left out [MiB].

    Linux: of this program alone. What getrusage says begins with the size of the process that started it.
    """
    status = Path("/proc/self/status")
    if status.exists():
        line = next(line for line in status.read_text().splitlines() if line.startswith("VmHWM"))
        return int(line.split()[1]) / 2**10
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    # Kibibytes everywhere but on macOS.
    return peak / 2**20 if sys.platform == "darwin" else peak / 2**10


def measure(points: int) -> dict[str, Any]:
    """Submit a study of about `points` friction-only points, compute a few blocks, stop, and report."""
    num = round((points / 10) ** 0.5)
    study = parse_study(
        {
            "name": f"memory {points}",
            "damping_ratio": {"start": 0.01, "stop": 0.1, "num": 10},
            "axes": {
                "friction_ratio": {"start": 0.1, "stop": 0.7, "num": num},
                "frequency_ratio": {"start": 0.5, "stop": 1.5, "num": num},
            },
            "particle": False,
            "steady": {"max_cycles": 100},
        }
    )
    imported = peak_mib()
    began = time.perf_counter()
    plan = make_plan(study, seconds_per_point)
    planned = time.perf_counter()
    stop = Event()

    def watch(progress: Progress) -> None:
        if progress.blocks_done >= min(BLOCKS, progress.blocks_total):
            stop.set()

    with tempfile.TemporaryDirectory() as folder:
        store = Store.open(Path(folder))
        record, _ = store.submit(study, plan, provenance())
        submitted = time.perf_counter()
        record = run_study(store, record.id, lambda: connect(workers=1), watch, stop)
        store.close()
    return {
        "points": record.points_total,
        "blocks": record.blocks_total,
        "blocks_done": record.blocks_done,
        "state": record.state,
        "plan_seconds": planned - began,
        "submit_seconds": submitted - planned,
        "after_import_mib": imported,
        "peak_mib": peak_mib(),
    }


def run() -> dict[str, Any]:
    """Measure every size in a process of its own."""
    return {f"{points} points": measure_apart(points) for points in SIZES}


def measure_apart(points: int) -> dict[str, Any]:
    """Measure one size in a fresh process, whose peak is not another size's."""
    command = [sys.executable, "-m", "tests.benchmarks.memory", str(points)]
    done = subprocess.run(command, check=True, capture_output=True, text=True, cwd=Path(__file__).parents[2])
    figures: dict[str, Any] = json.loads(done.stdout)
    return figures


if __name__ == "__main__":
    print(json.dumps(measure(int(sys.argv[1]))))
