"""What a study of 10⁸ points on 1,000 worker threads asks of its coordinator and of the Dask scheduler.

A real scheduler, real workers, the real runner and a real catalogue; the blocks alone are not computed: they sleep for
as long as they would take, and write nothing. Many workers share a process here, so that two cores are enough; what
counts is therefore CPU time for each block, of coordinator and scheduler, which holds on a loaded machine too. Its
inverse is the number of blocks a second that a core can see to.

`python -m tests.benchmarks.scale SECONDS PROCESSES WORKERS THREADS` runs so long with so many processes, workers in
each, threads in each worker.
"""

import asyncio
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

import psutil
from distributed import Worker
from sqlalchemy import func, select
from tests.benchmarks.memory import peak_mib
from tests.worker.dask_processes import scheduler_process

from damperlab.studies.definition import parse_study
from damperlab.studies.plan import Block, make_plan
from damperlab.studies.store.catalogue.tables import done_blocks
from damperlab.studies.store.record import BlockOutcome
from damperlab.studies.store.store import Store
from damperlab.worker.cluster.cluster import connect
from damperlab.worker.dispatch.cost_model import seconds_per_point
from damperlab.worker.provenance import provenance
from damperlab.worker.run.runner import run_study

ROOT = Path(__file__).parents[2]
BLOCK_SECONDS = 2.0
POINTS_PER_AXIS = 10_000


def asleep(cube_path: str, digest: str, block: Block, code: str, generation: str, *rest: Any) -> BlockOutcome:
    """Take as long as a block, and come to nothing."""
    time.sleep(BLOCK_SECONDS)
    return BlockOutcome(
        block.index, block.points, 0, BLOCK_SECONDS, BLOCK_SECONDS, generation=generation, checksum="0" * 64
    )


async def _work(scheduler: str, workers: int, threads: int) -> None:
    import damperlab.worker.worker_process.tasks

    # tasks name their function by its place: what is found there runs
    damperlab.worker.worker_process.tasks.run_block = asleep
    started = [Worker(scheduler, nthreads=threads, dashboard=False, memory_limit=0) for _ in range(workers)]
    for at in range(0, workers, 20):
        await asyncio.gather(*started[at : at + 20])
    print("ready", flush=True)
    await asyncio.gather(*(each.finished() for each in started))


def measure(seconds: float, processes: int, workers: int, threads: int) -> dict[str, Any]:
    """Run so long and report."""
    study = parse_study(
        {
            "name": "scale",
            "damping_ratio": 0.01,
            "axes": {
                "friction_ratio": {"start": 0.1, "stop": 0.7, "num": POINTS_PER_AXIS},
                "frequency_ratio": {"start": 0.5, "stop": 1.5, "num": POINTS_PER_AXIS},
            },
            "particle": False,
        }
    )
    imported = peak_mib()
    environment = {**os.environ, "PYTHONPATH": f"{ROOT}{os.pathsep}{ROOT / 'src'}"}
    with tempfile.TemporaryDirectory() as folder, scheduler_process(anew=True) as (address, scheduler):
        hosts: list[subprocess.Popen[str]] = []
        try:
            code = "import asyncio, sys; from tests.benchmarks.scale import _work; "
            code += "asyncio.run(_work(sys.argv[1], int(sys.argv[2]), int(sys.argv[3])))"
            hosts += [
                subprocess.Popen(
                    [sys.executable, "-c", code, address, str(workers), str(threads)],
                    stdout=subprocess.PIPE,
                    stderr=subprocess.DEVNULL,
                    text=True,
                    env=environment,
                    cwd=ROOT,
                )
                for _ in range(processes)
            ]
            for host in hosts:
                assert host.stdout is not None
                assert host.stdout.readline() == "ready\n"
            store = Store.open(Path(folder) / "data")
            plan = make_plan(study, seconds_per_point)
            record = store.submit(study, plan, provenance(), reuse=False)[0]
            stop = threading.Event()
            watched = psutil.Process(scheduler.pid)
            before = time.process_time(), sum(watched.cpu_times()[:2])
            began = time.monotonic()
            threading.Timer(seconds, stop.set).start()
            record = run_study(store, record.id, lambda: connect(scheduler=address), lambda now: None, stop)
            took = time.monotonic() - began
            own, other = time.process_time() - before[0], sum(watched.cpu_times()[:2]) - before[1]
            with store.catalogue.reading() as connection:
                commits = connection.execute(select(func.count(done_blocks.c.at.distinct()))).scalar_one()
            store.close()
            blocks = max(1, record.blocks_done)
            return {
                "points": study.points,
                "blocks": plan.count,
                "workers": processes * workers,
                "threads": processes * workers * threads,
                "seconds": took,
                "blocks_done": record.blocks_done,
                "blocks_a_second": record.blocks_done / took,
                "commits": commits,
                "coordinator_cpu_ms_per_block": 1e3 * own / blocks,
                "scheduler_cpu_ms_per_block": 1e3 * other / blocks,
                "coordinator_mib": peak_mib(),
                "coordinator_after_import_mib": imported,
                "scheduler_mib": watched.memory_info().rss / 2**20,
            }
        finally:
            for host in hosts:
                host.kill()
                host.communicate()


def run() -> dict[str, Any]:
    """Half a minute with 200 workers of five threads."""
    return measure_apart(30.0, 2, 100, 5)


def measure_apart(seconds: float, processes: int, workers: int, threads: int) -> dict[str, Any]:
    """Measure in a process of its own, whose memory is the coordinator's alone."""
    arguments = map(str, (seconds, processes, workers, threads))
    done = subprocess.run(
        [sys.executable, "-m", "tests.benchmarks.scale", *arguments],
        stdout=subprocess.PIPE,
        text=True,
        check=True,
        cwd=ROOT,
    )
    figures: dict[str, Any] = json.loads(done.stdout)
    return figures


if __name__ == "__main__":
    print(json.dumps(measure(float(sys.argv[1]), *map(int, sys.argv[2:5]))))
