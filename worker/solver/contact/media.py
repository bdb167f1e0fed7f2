"""What mass and particle move in while they touch: one body on a rigid wall, two pressed together on a compliant one."""

from typing import Any

from numba import types

from damperlab.worker.jit import by_type, inlined
from damperlab.worker.solver.state import Wall


@inlined
def _choose(free, loaded, riding):
    return loaded if riding > 0.0 else free


def medium_of(free: Any, loaded: Any, riding: float, wall: Wall | None) -> Any:
    """The medium of a window; in a compliant wall `compliant.phase.through_wall` goes on instead."""
    return _choose(free, loaded, riding) if wall is None else free


@by_type(medium_of)
def _medium_of(free, loaded, riding, wall):
    if isinstance(wall, types.NoneType):
        return lambda free, loaded, riding, wall: _choose(free, loaded, riding)
    return lambda free, loaded, riding, wall: free
