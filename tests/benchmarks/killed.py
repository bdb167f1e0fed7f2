"""Half of the workers of a real cluster are killed while a study runs: how long it takes beside the ideal time.

24 processes of `damperlab admin worker`, blocks that sleep for two to four seconds, the runner's own window; at a third
of the work twelve of them get SIGKILL. Ideal is that the blocks which ran there are lost at that moment, that all
others go on without a pause, and that the workers which are left end together. The last blocks
alone cost up to half a block on average.
"""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from distributed import Client
from tests.worker.dask_processes import scheduler_process

from damperlab.studies.store.record import BlockOutcome
from damperlab.worker.cluster.cluster import connect
from damperlab.worker.dispatch.window import Window

ROOT = Path(__file__).parents[2]


def asleep(index: int, seconds: float) -> BlockOutcome:
    """Take as long as a block."""
    time.sleep(seconds)
    return BlockOutcome(index, 1, 0, seconds, seconds)


def run(blocks: int = 240, workers: int = 24) -> dict[str, Any]:
    """So many workers, of which half are killed at a third of the work."""
    environment = {**os.environ, "PYTHONPATH": f"{ROOT}{os.pathsep}{ROOT / 'src'}"}
    with scheduler_process(anew=True) as (address, _):
        command = [sys.executable, "-m", "damperlab", "admin", "worker", address, "--memory-limit=0"]
        started = [
            subprocess.Popen(
                [*command, f"--name={place}"], env=environment, cwd=ROOT, stderr=subprocess.DEVNULL
            )
            for place in range(workers)
        ]
        try:
            with connect(scheduler=address) as client:
                client.wait_for_workers(workers, timeout=300)
                client.run(asleep, 0, 0.0)  # loads what a block of this benchmark needs
                return _half_killed(client, started[::2], blocks)
        finally:
            for process in started:
                process.kill()
                process.wait()


def _half_killed(client: Client, victims: list[subprocess.Popen[bytes]], blocks: int) -> dict[str, Any]:
    seconds = np.random.default_rng(4).uniform(2.0, 4.0, blocks)
    named = client.scheduler_info(n_workers=-1)["workers"]
    left = [address for address, told in named.items() if int(told["name"]) % 2]
    window = Window(client, lambda index, key: (asleep, index, float(seconds[index])), range(blocks))
    waiting = set(range(blocks))
    ideal = killed_at = 0.0
    began = time.monotonic()
    window.fill()
    while not window.empty:
        waiting -= {one.index for one in window.collect(0.2)}
        if not killed_at and len(waiting) <= 2 * blocks // 3:
            for process in victims:
                process.send_signal(signal.SIGKILL)
            killed_at = time.monotonic() - began
            # those that are left are half-way through a block each, on average
            running = [next(iter(window.workers.states[address].held.values())).index for address in left]
            work = seconds[list(waiting)].sum() - seconds[running].sum() / 2.0
            ideal = killed_at + work / len(left)
        window.fill()
    took = time.monotonic() - began
    return {"seconds": took, "killed_at": killed_at, "ideal": ideal, "over": took / ideal - 1.0}


if __name__ == "__main__":
    print(json.dumps(run(), indent=1))
