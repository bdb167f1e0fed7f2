"""Blocks of which parts have come: stored once all of their points are there, as if one worker had computed them."""

import uuid

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.plan import Block, Plan
from damperlab.studies.store.cube.cube import stored_variables, write_region
from damperlab.studies.store.record import BlockOutcome
from damperlab.worker.worker_process.part import PartOutcome


class _Half:
    """A block that is not whole yet."""

    def __init__(self, plan: Plan, block: Block) -> None:
        self.block = block
        self.values = {
            variable.name: np.full(block.shape, variable.fill, dtype=variable.dtype)
            for variable in stored_variables(plan.study)
        }
        self.there: NDArray[np.bool_] = np.zeros(block.shape, bool)
        self.seconds = self.kernel_seconds = 0.0

    def take(self, came: PartOutcome) -> None:
        place = tuple(
            slice(start - first, start - first + length)
            for start, first, length in zip(came.part.start, self.block.start, came.part.shape, strict=True)
        )
        for name, column in self.values.items():
            column[place] = came.values[name]
        self.there[place] = True
        self.seconds += came.seconds
        self.kernel_seconds += came.kernel_seconds


class Gathering:
    """Puts parts together.

    Parameters
    ----------
    plan : Plan
        The blocks.
    cube_path : str
        Where they are stored.
    """

    def __init__(self, plan: Plan, cube_path: str) -> None:
        self._plan = plan
        self._cube_path = cube_path
        self._halves: dict[int, _Half] = {}
        self._given_up: set[int] = set()

    def take(self, came: PartOutcome) -> BlockOutcome | None:
        """Take a part; give the block that it makes whole, stored; None before that, and for a block that was given up.

        Raises
        ------
        OSError
            If it cannot be written.
        """
        if came.index in self._given_up:
            return None
        half = self._halves.get(came.index)
        if half is None:
            half = self._halves[came.index] = _Half(self._plan, self._plan.block(came.index))
        half.take(came)
        if not half.there.all():
            return None
        del self._halves[came.index]
        return self._store(half, came.identity)

    def give_up(self, index: int) -> None:
        """Forget what there is of a block, and what still comes."""
        self._given_up.add(index)
        self._halves.pop(index, None)

    def _store(self, half: _Half, identity: str) -> BlockOutcome:
        told = {
            "reused": 0,
            "seconds": half.seconds,
            "kernel_seconds": half.kernel_seconds,
            "identity": identity,
        }
        return write_region(self._cube_path, half.block, half.values, uuid.uuid4().hex[:12], told)
