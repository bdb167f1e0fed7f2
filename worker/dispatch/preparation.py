"""Compiles missing kernels at the workers of a cluster before the blocks of a study: in parallel, each once per
machine.
"""

import time
from collections.abc import Callable, Collection, Sequence

from distributed import Client

from damperlab.worker.dispatch.tasks import sealed
from damperlab.worker.jit import CACHE_FOLDER
from damperlab.worker.provenance import identity
from damperlab.worker.scenes import Scene
from damperlab.worker.warm import missing, warm

LOOK_SECONDS = 0.2
"""Interval between checks of the progress, and so the delay of a stop."""


def compile_at_workers(
    client: Client,
    wanted: Sequence[Scene],
    on_progress: Callable[[int, int], None],
    stopping: Callable[[], bool],
    workers: Collection[str],
) -> None:
    """Compile every kernel of some scenes at each machine of a cluster.

    Failures here are left to the blocks: they compile missing kernels themselves, and report errors.

    Parameters
    ----------
    client : Client
        Of the cluster.
    wanted : sequence of Scene
        The scenes of the study.
    on_progress : callable
        Called with the number of compiled scenes, and their total; not called if none is missing.
    stopping : callable
        Returns whether to stop waiting; running compilations continue at their workers.
    workers : collection of str
        Addresses of the workers to ask.
    """
    if not wanted:
        return
    places: dict[tuple[str, str], tuple[list[Scene], list[str]]] = {}
    asked = client.run(_lacking, list(wanted), workers=list(workers), on_error="ignore")
    for address, answer in asked.items():
        # the worker has left meanwhile
        if answer is None:
            continue
        host, folder, lacking = answer
        places.setdefault((host, folder), (lacking, []))[1].append(address)
    tasks = [
        # if a worker dies, another may continue, even on another machine: this costs less than waiting
        client.submit(
            *sealed(_warm, scene), pure=False, workers=[there[i % len(there)]], allow_other_workers=True
        )
        for lacking, there in places.values()
        for i, scene in enumerate(lacking)
    ]
    while tasks:
        done = sum(task.done() for task in tasks)  # failed or lost compilations count as done too
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
    """Give the name of this machine with its kernels' folder, and the missing kernels."""
    return identity()["host"], str(CACHE_FOLDER), missing(wanted)


def _warm(scene: Scene) -> None:
    warm(scene)
