"""Half of the workers of a real Dask cluster are killed while a study runs: how long it takes beside the ideal time.

24 workers in two processes, blocks that sleep, the runner's own window; at a third of the work one process, with its twelve
workers, gets SIGKILL. Ideal is that the blocks which ran there are lost at that moment and all others go on without a pause.
"""

import asyncio
import json
import os
import signal
import socket
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

from distributed import Worker

from damperlab.studies.store.record import BlockOutcome
from damperlab.worker.backlog import Backlog
from damperlab.worker.cluster import connect
from damperlab.worker.window import Window

ROOT = Path(__file__).parents[2]


def asleep(index: int, seconds: float) -> BlockOutcome:
    """Take as long as a block."""
    time.sleep(seconds)
    return BlockOutcome(index, 1, 0, seconds, seconds)


async def work(scheduler: str, workers: int) -> None:
    """Be so many workers."""
    started = [Worker(scheduler, nthreads=1, dashboard=False, memory_limit=0) for _ in range(workers)]
    await asyncio.gather(*started)
    await asyncio.gather(*(each.finished() for each in started))


def run(blocks: int = 240, seconds: float = 3.0, workers: int = 12) -> dict[str, Any]:
    """Twice so many workers, of which half are killed at a third of the work."""
    environment = {**os.environ, "PYTHONPATH": f"{ROOT}{os.pathsep}{ROOT / 'src'}"}
    quiet: dict[str, Any] = {"env": environment, "cwd": ROOT, "stderr": subprocess.DEVNULL}
    scheduler = subprocess.Popen(
        [sys.executable, "-m", "dask", "scheduler", "--host=127.0.0.1", "--port=8799", "--no-dashboard"],
        stdout=subprocess.DEVNULL,
        **quiet,
    )
    address = "tcp://127.0.0.1:8799"
    code = "import asyncio, sys; from tests.benchmarks.killed import work; asyncio.run(work(sys.argv[1], int(sys.argv[2])))"
    crews = [subprocess.Popen([sys.executable, "-c", code, address, str(workers)], **quiet) for _ in range(2)]
    try:
        while True:
            with suppress(OSError), socket.create_connection(("127.0.0.1", 8799), 1.0):
                break
            time.sleep(0.2)
        with connect(scheduler=address) as client:
            client.wait_for_workers(2 * workers, timeout=120)
            window = Window(client, lambda index, key: (asleep, index, seconds), Backlog(range(blocks)))
            began = time.monotonic()
            killed_at, at_kill, done = 0.0, 0, 0
            window.fill()
            while not window.empty:
                done += sum(1 for _ in window.collect(0.2))
                if not killed_at and done >= blocks // 3:
                    crews[0].send_signal(signal.SIGKILL)
                    killed_at, at_kill = time.monotonic() - began, done
                window.fill()
            took = time.monotonic() - began
        # what is left then is computed by the others, which are half-way through a block each
        ideal = killed_at + ((blocks - at_kill) / workers - 0.5) * seconds
        return {"seconds": took, "killed_at": killed_at, "ideal": ideal, "over": took / ideal - 1.0}
    finally:
        for process in (*crews, scheduler):
            process.kill()
            process.wait()


if __name__ == "__main__":
    print(json.dumps(run(), indent=1))
