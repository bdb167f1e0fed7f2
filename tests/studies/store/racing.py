"""What other processes do to a store: race for one study, from the tables of its catalogue to its blocks, die on the way,
or do something between any two touches of a file.
"""

import os
import signal
import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from multiprocessing.queues import SimpleQueue
from multiprocessing.synchronize import Barrier
from pathlib import Path
from typing import Any

import numpy as np

from damperlab.studies.definition import parse_study
from damperlab.studies.plan import plan_with_chunk
from damperlab.studies.store.catalogue.catalogue import Catalogue
from damperlab.studies.store.files.folder import Folder
from damperlab.studies.store.record import BlockOutcome
from damperlab.studies.store.store import Store

TOUCHES = (
    "get",
    "read",
    "put",
    "put_new",
    "fill",
    "make",
    "entries",
    "shelves",
    "remove",
    "clear",
)


class Watched(Folder):
    """A folder that refuses to be touched while somebody writes to the catalogue, and calls back before it is."""

    catalogue: Catalogue
    before: Callable[[str], None] = staticmethod(lambda name: None)

    def at(self, name: str) -> "Watched":
        below = Watched(self._path / name)
        below.catalogue, below.before = self.catalogue, self.before  # type: ignore[method-assign]
        return below

    def __getattribute__(self, name: str) -> Any:
        if name in TOUCHES:
            assert not self.catalogue._turn.locked(), f"{name} within a transaction"
            self.before(name)
        return super().__getattribute__(name)


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


def die_at(where: str, what: Callable[[Store], object], folder: Path) -> None:
    """Do something to a store, and be killed in place of a method of the store."""

    def die(*given: Any, **named: Any) -> None:
        os.kill(os.getpid(), signal.SIGKILL)

    store = Store.open(folder)
    setattr(store, where, die)
    what(store)
