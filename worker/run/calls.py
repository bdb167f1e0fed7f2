"""Builds the function calls that workers execute, and ensures that one solver computes all blocks."""

from collections.abc import Mapping
from contextlib import suppress
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.plan import Block
from damperlab.studies.store.cube.description import stored_variables
from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.record import Record
from damperlab.studies.store.reuse import Overlaps
from damperlab.worker.provenance import code_hash, one_identity, require_begun_alike
from damperlab.worker.worker_process.examination import canary_of, examine, stored_bits
from damperlab.worker.worker_process.tasks import run_block

if TYPE_CHECKING:
    from damperlab.worker.run.runner import Run


class Calls:
    """Builds the function calls that compute the blocks of a study, and those that test its workers.

    Parameters
    ----------
    run : Run
        The run, whose plan must be set.
    record : Record
        The study in its present state.
    """

    def __init__(self, run: "Run", record: Record) -> None:
        self._lease = run.lease
        self._plan = run.plan
        self._cube_path = run.cube_path
        self._record = record

    @property
    def begun(self) -> str:
        """Identity of the solver that computed the existing blocks; empty if no block exists."""
        return self._record.provenance.get("identity", "") if self._record.blocks_done else ""

    def agree(self, answers: Mapping[str, Mapping[str, str]]) -> None:
        """Check that all workers have the same solver, and write the solver's identity to the study's record.

        This method must be called before `of_block`.

        Parameters
        ----------
        answers : mapping
            Result of `damperlab.worker.provenance.computing` at each worker, by address.

        Raises
        ------
        WrongCode
            If the workers' solvers differ from each other, or from the solver of the existing blocks.
        """
        now = one_identity(answers)
        self._record = self._lease.store.begin(self._lease.study_id, dict(now), self._lease.owner)
        require_begun_alike(self._lease.study_id, self._record.provenance, now)

    @cached_property
    def _overlaps(self) -> Overlaps:
        return Overlaps(self._lease.store, self._record)

    def of_block(self, index: int, key: str) -> tuple[Any, ...]:
        """Return a tuple of the function that computes a block, and the arguments of this function.

        The unique key of the task becomes part of the name of the block's file.
        """
        block = self._plan.block(index)
        generation = key.removeprefix("block-")
        solver, known = self._record.provenance["identity"], self._overlaps.of(block)
        return run_block, self._cube_path, self._record.digest, block, code_hash(), generation, known, solver

    def of_examination(self, canary: Block | None) -> tuple[Any, ...]:
        """Return a tuple of the function that tests a worker, and the arguments of this function.

        The worker computes the points `canary`. In the first test, before the kernels are compiled, `canary`
        is None, and no points are computed.
        """
        return examine, self._cube_path, self._record.digest, code_hash(), canary

    def canary(self, pending: NDArray[np.int64]) -> tuple[Block, str]:
        """Return the points that every worker computes as a test, and the hash of their stored results.

        The hash is empty if no block is done, or the results cannot be read. `pending` are the blocks that are not
        done.
        """
        study = self._plan.study
        done = np.setdiff1d(np.arange(self._plan.count), pending, assume_unique=True)
        if done.size:
            canary = canary_of(self._plan, int(done[0]))
            names = [variable.name for variable in stored_variables(study)]
            with suppress(StoreFault, OSError):
                # if the stored results cannot be read, the result of the majority of the workers counts as right
                if truth := stored_bits(self._lease.store.cube(self._lease.study_id), study, canary, names):
                    return canary, truth
        return canary_of(self._plan, int(pending[0])), ""
