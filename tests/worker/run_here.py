"""A study in twelve blocks, and studies that are run in the process of a test, where no cluster may be asked for."""

import threading
import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from multiprocessing.queues import SimpleQueue
from pathlib import Path
from typing import Any

from distributed import Client

from damperlab.studies.definition import Study, parse_study
from damperlab.studies.plan import Block, Plan, make_plan, plan_with_chunk
from damperlab.studies.store.cube.block_file import write_region
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store
from damperlab.worker.block import solve_block
from damperlab.worker.dispatch.cost_model import seconds_per_point
from damperlab.worker.provenance import provenance
from damperlab.worker.run.lease import hold
from damperlab.worker.run.progress import Progress
from damperlab.worker.run.runner import run_study
from damperlab.worker.worker_process.examination import bits_of
from damperlab.worker.worker_process.tasks import failed_values

CHUNK = (1, 1, 1, 1, 1, 4)
BLOCKS = 12

AMPLE_SECONDS = 60.0
"""What any study of a test is expected to take at most."""


def friction_study() -> Study:
    return parse_study(
        {
            "name": "friction",
            "damping_ratio": 0.05,
            "axes": {
                "friction_ratio": [0.0, 0.2, 0.4, 0.6],
                "frequency_ratio": {"start": 0.7, "stop": 1.3, "num": 12},
            },
            "particle": False,
            "steady": {"max_cycles": 200},
        }
    )


def linear_study(frequencies: list[float], damping_ratio: float = 0.05) -> Study:
    """Ask for a structure alone, in closed form."""
    axes = {"friction_ratio": 0, "frequency_ratio": frequencies}
    return parse_study({"damping_ratio": damping_ratio, "axes": axes, "particle": False})


def planned(study: Study, chunk: int | tuple[int, ...] | None = None) -> Plan:
    """Plan blocks of a shape, or of so many frequencies; as a command does where nothing is given."""
    if chunk is None:
        return make_plan(study, seconds_per_point)
    shape = (1, 1, 1, 1, 1, chunk) if isinstance(chunk, int) else chunk
    return plan_with_chunk(study, shape, seconds_per_point)


def submit(
    store: Store,
    study: Study | None = None,
    chunk: int | tuple[int, ...] | None = CHUNK,
    reuse: bool = True,
    **facts: str,
) -> Record:
    """Enter a study, with today's provenance but for the facts that are given."""
    study = study or friction_study()
    return store.submit(study, planned(study, chunk), provenance() | facts, reuse=reuse)[0]


def give_up(store: Store, record: Record, study: Study, index: int) -> None:
    """Mark a block as one that was given up."""
    block = planned(study, record.chunk).block(index)
    values = failed_values(study, block)
    told = {"message": "its worker died"}
    store.mark(record.id, write_region(store.cube_path(record.id), block, values, "g", told))


def of_one_piece(store: Store, study_id: str, study: Study) -> bool:
    """Whether a cube has the bits of one block that holds everything and is solved undisturbed, run times aside."""
    whole = solve_block(study, Block.whole(study.shape))
    cube = store.cube(study_id)
    return bits_of(whole) == bits_of({name: cube[name].values for name in whole})


def never() -> AbstractContextManager[Client]:
    raise AssertionError("a cluster was asked for")


def ignore(progress: Progress) -> None:
    pass


def run_here(
    store: Store,
    study_id: str,
    tell: Callable[[Progress], None] = ignore,
    stop: threading.Event | None = None,
    **more: Any,
) -> Record:
    """Run a study in this process to its end, or until it is stopped."""
    return run_study(
        store, study_id, never, tell, stop or threading.Event(), here_seconds=AMPLE_SECONDS, **more
    )


def hold_for_good(folder: Path, study_id: str, told: "SimpleQueue[str]") -> None:
    """Claim a study and keep it, in a process that is killed."""
    with hold(Store.open(folder), study_id):
        told.put("held")
        time.sleep(600)
