"""A part of a block: computed by one worker, handed back as values, stored with the others once the block is whole."""

import time
from dataclasses import dataclass

import numpy as np

from damperlab.studies.plan import Block
from damperlab.worker.provenance import computing, require_code, require_identity
from damperlab.worker.worker_process.tasks import solve_stored


@dataclass(frozen=True)
class PartOutcome:
    """What a worker reports about a part of a block.

    Parameters
    ----------
    part : Block
        The box, with the index of its block.
    values : dict of ndarray
        Every stored variable, shaped `part.shape`.
    seconds, kernel_seconds : float
        Wall time, and CPU time of the thread that computed [s].
    identity : str
        What computed it.
    """

    part: Block
    values: dict[str, np.ndarray]
    seconds: float
    kernel_seconds: float
    identity: str

    @property
    def index(self) -> int:
        """Of the block."""
        return self.part.index


def run_part(cube_path: str, digest: str, part: Block, code: str, solver: str) -> PartOutcome:
    """Solve a part of a block and store nothing; the value of the Dask task.

    Parameters
    ----------
    cube_path, digest, code, solver : str
        As for `damperlab.worker.worker_process.tasks.run_block`.
    part : Block
        The box.

    Raises
    ------
    WrongCode
        If this worker's sources differ from the coordinator's, or its results would differ from the study's.
    OSError
        If the cube cannot be read.
    """
    require_code(code)
    require_identity(solver)
    began, began_thread = time.perf_counter(), time.thread_time()
    values = solve_stored(cube_path, digest, part)
    assert values is not None
    return PartOutcome(
        part,
        values,
        time.perf_counter() - began,
        time.thread_time() - began_thread,
        computing()["identity"],
    )
