"""Compiles missing kernels at the workers of a cluster before the first block, once on each machine."""

import time
from collections.abc import Collection, Iterator, Sequence

from distributed import Client

from damperlab.worker.dispatch.tasks import sealed
from damperlab.worker.jit import CACHE_FOLDER
from damperlab.worker.provenance import identity
from damperlab.worker.scenes import Scene
from damperlab.worker.warm import missing, warm

LOOK_SECONDS = 0.2
"""Interval between checks of the progress [s]. A request to stop is noticed after this time at the latest."""


def compile_at_workers(
    client: Client, wanted: Sequence[Scene], workers: Collection[str]
) -> Iterator[tuple[int, int]]:
    """Compile the missing kernels of the given scenes on each machine of a cluster.

    Compilation errors are ignored here, because the first block compiles the kernel again and reports the error. If the
    caller stops the iteration, running compilations continue at their workers.

    Yields
    ------
    done, total : int
        Number of ended compilations, and number of all compilations, yielded every `LOOK_SECONDS`. Nothing is
        yielded if no kernel is missing.
    """
    if not wanted:
        return
    places: dict[tuple[str, str], tuple[list[Scene], list[str]]] = {}
    asked = client.run(_lacking, list(wanted), workers=list(workers), on_error="ignore")
    for address, answer in asked.items():
        # the worker has left in the meantime
        if answer is None:
            continue
        host, folder, lacking = answer
        places.setdefault((host, folder), (lacking, []))[1].append(address)
    tasks = [
        # if the worker is lost, any other worker may compile the scene, because waiting would take longer
        client.submit(
            *sealed(warm, scene), pure=False, workers=[there[i % len(there)]], allow_other_workers=True
        )
        for lacking, there in places.values()
        for i, scene in enumerate(lacking)
    ]
    while tasks:
        done = sum(task.done() for task in tasks)  # includes failed and lost compilations
        yield done, len(tasks)
        if done == len(tasks):
            return
        time.sleep(LOOK_SECONDS)


def all_ready(client: Client, wanted: Sequence[Scene]) -> bool:
    """Return whether every worker of a cluster has all kernels of the given scenes."""
    if not wanted:
        return True
    answers = client.run(_lacking, list(wanted), on_error="ignore").values()
    return bool(answers) and not any(lacking for _, _, lacking in answers)


def _lacking(wanted: list[Scene]) -> tuple[str, str, list[Scene]]:
    """Return the name of this machine, the folder of its kernels, and the scenes whose kernels are missing."""
    return identity()["host"], str(CACHE_FOLDER), missing(wanted)
