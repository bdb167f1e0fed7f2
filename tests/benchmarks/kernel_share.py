"""Share of the workers' time that a study of 10⁵ points spends in kernels; scheduling and storing is the rest.

`kernel_share` is CPU time in kernels over workers times wall time: the figure that counts, on a machine with nothing
else to do. Where others compute too, it falls with what they take; two figures then still say what the Dask side
costs: `block_share`, the share of the wall time in which workers have a block in hand, and `kernel_share_of_cpu`, the
share of the workers' CPU time that is spent in kernels.
"""

import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Event
from typing import Any

from distributed import Client

from damperlab.studies.definition import parse_study
from damperlab.studies.plan import make_plan
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store
from damperlab.worker.cluster.cluster import connect
from damperlab.worker.dispatch.cost_model import seconds_per_point
from damperlab.worker.provenance import provenance
from damperlab.worker.run.progress import Progress
from damperlab.worker.run.runner import run_study


def study_document(clearances: int, frictions: int, frequencies: int) -> dict[str, Any]:
    """A hybrid scene over a band around resonance."""
    return {
        "name": f"kernel share {clearances}x{frictions}x{frequencies}",
        "damping_ratio": 0.0038,
        "axes": {
            "clearance_ratio": {"start": 1, "stop": 25, "num": clearances},
            "friction_ratio": {"start": 0, "stop": 0.8, "num": frictions},
            "restitution": 0.47,
            "mass_ratio": 0.1,
            "frequency_ratio": {"start": 0.8, "stop": 1.2, "num": frequencies},
        },
        "steady": {"max_cycles": 400},
    }


def run(workers: int = 2) -> dict[str, Any]:
    """Run a warm-up study, then one of 102,500 points on the same workers."""
    with tempfile.TemporaryDirectory() as folder, connect(workers=workers) as client:
        store = Store.open(Path(folder))
        _timed(store, client, study_document(8, 4, 4))
        before = sum(client.run(time.process_time).values())
        record, wall = _timed(store, client, study_document(50, 41, 50))
        cpu = sum(client.run(time.process_time).values()) - before
        store.close()
    return {
        "workers": workers,
        "points": record.points_total,
        "points_failed": record.points_failed,
        "blocks": record.blocks_total,
        "wall_seconds": wall,
        "kernel_seconds": record.kernel_seconds,
        "block_seconds": record.seconds,
        "kernel_share": record.kernel_seconds / (workers * wall),
        "block_share": record.seconds / (workers * wall),
        "kernel_share_of_cpu": record.kernel_seconds / cpu,
        "points_per_second": record.points_total / wall,
    }


def _timed(store: Store, client: Client, document: dict[str, Any]) -> tuple[Record, float]:
    study = parse_study(document)
    record, _ = store.submit(study, make_plan(study, seconds_per_point), provenance(), reuse=False)
    first = last = 0.0

    @contextmanager
    def lend() -> Iterator[Client]:
        nonlocal first
        first = time.perf_counter()
        yield client

    def watch(progress: Progress) -> None:
        nonlocal last
        last = time.perf_counter()
        if sys.stderr.isatty():
            print(f"\r  {progress.points_done} of {progress.points_total} points", end="", file=sys.stderr)

    record = run_study(store, record.id, lend, watch, Event())
    if record.state != "done":
        raise RuntimeError(f"the study ended {record.state}: {record.message}")
    # The last report comes after the last mark; the first moment lies before the first submit.
    return record, last - first
