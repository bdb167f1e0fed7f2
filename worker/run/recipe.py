"""The data sent with every block of a study. Before the first block, the workers' solvers are compared with each other
and with that of the existing blocks.
"""

from collections.abc import Mapping
from contextlib import suppress
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.plan import Block, Plan
from damperlab.studies.store.cube.cube import stored_variables
from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.record import Record
from damperlab.studies.store.reuse.reuse import Overlaps
from damperlab.studies.store.store import Store
from damperlab.worker.provenance import code_hash, one_identity, require_begun_alike
from damperlab.worker.run.lease import Lease
from damperlab.worker.worker_process.examination import canary_of, stored_bits
from damperlab.worker.worker_process.tasks import run_block


class Recipe:
    """Makes the calls that compute blocks.

    Parameters
    ----------
    store : Store
        Where the study is.
    lease : Lease
        The claim on it.
    plan : Plan
        Its blocks.
    record : Record
        The study in its present state.
    """

    def __init__(self, store: Store, lease: Lease, plan: Plan, record: Record) -> None:
        self._store = store
        self._lease = lease
        self._plan = plan
        self._record = record
        self._cube_path = store.cube_path(lease.study_id)

    @property
    def begun(self) -> str:
        """The identity of the existing blocks; empty if there are none."""
        return self._record.provenance.get("identity", "") if self._record.blocks_done else ""

    def agree(self, answers: Mapping[str, Mapping[str, str]]) -> None:
        """Record the study's solver; this must precede the first `call`.

        Raises
        ------
        WrongCode
            The workers differ from each other, or from the solver of the existing blocks.
        """
        now = one_identity(answers)
        self._record = self._store.begin(self._lease.study_id, dict(now), self._lease.owner)
        require_begun_alike(self._lease.study_id, self._record.provenance, now)

    @cached_property
    def _overlaps(self) -> Overlaps:
        return Overlaps(self._store, self._record)

    def call(self, index: int, key: str) -> tuple[Any, ...]:
        """Give the function for a block, and its arguments, under the key of its task."""
        block = self._plan.block(index)
        # a key is used only once, so the files of two attempts never have the same name
        generation = key.removeprefix("block-")
        solver, known = self._record.provenance["identity"], self._overlaps.of(block)
        return run_block, self._cube_path, self._record.digest, block, code_hash(), generation, known, solver

    def canary(self, pending: NDArray[np.int64]) -> tuple[Block, str]:
        """Choose the points that every worker computes first, and give their bits if they are stored."""
        study = self._plan.study
        done = np.setdiff1d(np.arange(self._plan.count), pending, assume_unique=True)
        if done.size:
            canary = canary_of(self._plan, int(done[0]))
            names = [variable.name for variable in stored_variables(study)]
            with suppress(StoreFault, OSError):
                # if the stored results cannot be read, the answer of a majority of the workers decides
                if truth := stored_bits(self._store.cube(self._lease.study_id), study, canary, names):
                    return canary, truth
        return canary_of(self._plan, int(pending[0])), ""
