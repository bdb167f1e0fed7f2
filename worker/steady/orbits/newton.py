"""The exact Jacobian of the event-driven map, and the step of Newton's method towards a periodic orbit."""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import kernel
from damperlab.worker.solver.array_loops import zero_counts
from damperlab.worker.solver.events import ARRIVED
from damperlab.worker.solver.integrate import half_cycle_on_addresses
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.state import State
from damperlab.worker.solver.transition_log import Transitions
from damperlab.worker.steady.section.coordinates import SECTION_SIZE, has_contact
from damperlab.worker.steady.stability.variational import propagate

Array = NDArray[np.float64]

_SINGULAR = 1e-11  # Pivot of 1 − M below which the orbit is not isolated.


@kernel
def march_with_jacobian(
    state: State,
    period_halves: int,
    scene: Scene,
    log: Transitions,
    monodromy: Array,
) -> tuple[State, bool]:
    """Integrate a state through `period_halves` half cycles, and write the Jacobian of the map into `monodromy`.

    The second result is False if the integration ended early or the log was full; the Jacobian is then invalid.
    """
    for i in range(SECTION_SIZE):
        for j in range(SECTION_SIZE):
            monodromy[i, j] = 1.0 if i == j else 0.0
    for _ in range(period_halves):
        log.cursor[0] = 0
        state, outcome = half_cycle_on_addresses(state, scene, None, log)
        if outcome != ARRIVED or log.cursor[0] > log.capacity:
            return state, False
        propagate(log, scene, monodromy)
    return state, True


@kernel
def newton_step(
    monodromy: Array,
    residual: Array,
    state: State,
    size: int,
    friction: float | None,
    particle: Particle | None,
    step: Array,
) -> bool:
    """Solve (1 − M) step = residual in the free coordinates; False if 1 − M is singular.

    A mass held by friction has w = 0, and a particle in sustained contact follows the wall, so these coordinates are
    not free.
    """
    held = zero_counts(SECTION_SIZE)
    if friction is not None:
        if state.slip == 0.0:
            held[1] = 1
    if particle is not None:
        if state.riding > 0.0 and not has_contact(state, particle):
            held[2] = 1
            # friction may hold the particle anywhere in the cavity
            held[3] = 0 if particle.friction is not None and state.gap > 0.0 else 1
    index = np.empty(SECTION_SIZE, np.int64)
    n = 0
    for i in range(size):
        step[i] = 0.0
        if held[i] == 0:
            index[n] = i
            n += 1
    a = np.empty((n, n + 1))
    for i in range(n):
        for j in range(n):
            a[i, j] = (1.0 if i == j else 0.0) - monodromy[index[i], index[j]]
        a[i, n] = residual[index[i]]
    for column in range(n):
        pivot = column
        for i in range(column + 1, n):
            if abs(a[i, column]) > abs(a[pivot, column]):
                pivot = i
        if abs(a[pivot, column]) < _SINGULAR:
            return False
        for j in range(n + 1):
            a[column, j], a[pivot, j] = a[pivot, j], a[column, j]
        for i in range(n):
            if i != column:
                factor = a[i, column] / a[column, column]
                for j in range(column, n + 1):
                    a[i, j] -= factor * a[column, j]
    for i in range(n):
        step[index[i]] = a[i, n] / a[i, i]
    return True


@kernel
def norm(vector: Array, size: int) -> float:
    """Euclidean norm of the first `size` elements of a vector."""
    total = 0.0
    for i in range(size):
        total += vector[i] * vector[i]
    return sqrt(total)
