"""Kernels that a cluster's workers lack, compiled there before the blocks of a study: side by side, each once a machine."""

import time
from collections.abc import Callable, Collection, Sequence

from distributed import Client

from damperlab.worker.dispatch.tasks import sealed
from damperlab.worker.jit import CACHE_FOLDER
from damperlab.worker.provenance import identity
from damperlab.worker.scenes import Scene
from damperlab.worker.warm import missing, warm

LOOK_SECONDS = 0.2
"""Between two looks at what is compiled: how late a stop is noticed."""


def compile_at_workers(
    client: Client,
    wanted: Sequence[Scene],
    on_progress: Callable[[int, int], None],
    stopping: Callable[[], bool],
    workers: Collection[str],
) -> None:
    """Have every kernel of some scenes compiled at each machine of a cluster.

    What fails here is left to the blocks: they compile what they lack themselves, and say what is wrong.

    Parameters
    ----------
    client : Client
        Of the cluster.
    wanted : sequence of Scene
        What the study needs.
    on_progress : callable
        Told how many scenes are compiled, and of how many; not called where none is missing.
    stopping : callable
        Says whether to stop waiting; what has begun goes on at its worker.
    workers : collection of str
        Addresses of the workers to ask.
    """
    if not wanted:
        return
    places: dict[tuple[str, str], tuple[list[Scene], list[str]]] = {}
    asked = client.run(_lacking, list(wanted), workers=list(workers), on_error="ignore")
    for address, answer in asked.items():
        # one that has left meanwhile
        if answer is None:
            continue
        host, folder, lacking = answer
        places.setdefault((host, folder), (lacking, []))[1].append(address)
    tasks = [
        # another worker may take over from one that dies: machines differ less than that costs
        client.submit(
            *sealed(_warm, scene), pure=False, workers=[there[i % len(there)]], allow_other_workers=True
        )
        for lacking, there in places.values()
        for i, scene in enumerate(lacking)
    ]
    while tasks:
        done = sum(task.done() for task in tasks)  # failed, or lost with its scheduler, is done too
        on_progress(done, len(tasks))
        if done == len(tasks) or stopping():
            return
        time.sleep(LOOK_SECONDS)


def all_ready(client: Client, wanted: Sequence[Scene]) -> bool:
    """Whether every worker of a cluster has the kernels of some scenes."""
    if not wanted:
        return True
    answers = client.run(_lacking, list(wanted), on_error="ignore").values()
    return bool(answers) and not any(lacking for _, _, lacking in answers)


def _lacking(wanted: list[Scene]) -> tuple[str, str, list[Scene]]:
    """Name this machine and its kernels' folder, and what is missing there."""
    return identity()["host"], str(CACHE_FOLDER), missing(wanted)


def _warm(scene: Scene) -> None:
    warm(scene)
