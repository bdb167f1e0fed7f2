"""What other processes do to a store: race for one study, from the tables of its catalogue to its blocks, or die on the way."""

import os
import signal
import warnings
from concurrent.futures import ThreadPoolExecutor
from multiprocessing.queues import SimpleQueue
from multiprocessing.synchronize import Barrier
from pathlib import Path
from typing import Any

import numpy as np
from tests.filling import enter, make_study

from damperlab.studies.definition import parse_study
from damperlab.studies.plan import plan_with_chunk
from damperlab.studies.store.record import BlockOutcome
from damperlab.studies.store.store import Store


def race(
    folder: Path,
    address: str | None,
    name: str,
    begin: Barrier,
    answers: "SimpleQueue[tuple[str, bool, bool]]",
) -> None:
    """Submit, claim and mark every block; answer the id, whether it was created and whether the claim was won."""
    warnings.simplefilter("error")
    axes = {"friction_ratio": {"start": 0, "stop": 0.8, "num": 5}, "frequency_ratio": [0.9, 1.0, 1.1]}
    study = parse_study({"damping_ratio": 0.0038, "particle": False, "axes": axes})
    plan = plan_with_chunk(study, (1, 1, 1, 1, 1, 1), lambda _, at: np.ones(len(at["mass_ratio"])))
    begin.wait()
    store = Store.open(folder, address)  # the database is empty: they race for its tables too
    record, created = store.submit(study, plan, {})
    won = store.claim(record.id, name)

    def mark(index: int) -> None:
        store.mark(record.id, BlockOutcome(index, 1, 0, 0.1, 0.1, generation=name))

    with ThreadPoolExecutor(3) as threads:
        list(threads.map(mark, range(plan.count)))
    store.close()
    answers.put((record.id, created, won))


def submit_and_die(folder: Path, where: str) -> None:
    """Submit a study, and be killed in place of a method of the store."""

    def die(*given: Any) -> None:
        os.kill(os.getpid(), signal.SIGKILL)

    store = Store.open(folder)
    setattr(store, where, die)
    enter(store, make_study())
