"""Marches every scene a few cycles and prints the bits; run by `test_jit` in processes of their own."""

import sys

import numpy as np

from damperlab.worker.solver.contact.media import make_loaded
from damperlab.worker.solver.integrate import half_cycle
from damperlab.worker.solver.motion.propagator import make_base, make_medium
from damperlab.worker.solver.motion.taylor import TERMS
from damperlab.worker.solver.state import BUDGET, COUNTS, METERS, Meter, Particle, Wall
from damperlab.worker.steady.start import at_rest

PARTICLE = Particle(2.0, 0.6, 0.2)
CONTACTS = (
    PARTICLE,
    PARTICLE._replace(contact_time=0.05),
    PARTICLE._replace(wall=Wall(400.0, 4.0)),
)
SCENES = [(0.3, None), *((friction, particle) for particle in CONTACTS for friction in (None, 0.3))]


def bits(friction: float | None, particle: Particle | None) -> str:
    base = make_base(0.02, 0.97, True)
    free = make_medium(base, 1.0, True)
    loaded = None if particle is None else make_loaded(base, particle, particle.wall, True)
    state = at_rest(0.97, friction, particle)
    counts = np.zeros(COUNTS, np.int64)
    counts[BUDGET] = 10**6
    sums = np.zeros(METERS)
    work = np.empty((4, TERMS))
    for _ in range(60):
        state, _ = half_cycle(state, base, free, loaded, friction, particle, work, counts, Meter(sums), None)
    numbers = [state.v, state.w, state.gap, state.p_rate, *sums]
    return " ".join(float(number).hex() for number in numbers)


if __name__ == "__main__":
    chosen = [int(index) for index in sys.argv[1:]]
    lines = {index: bits(*SCENES[index]) for index in chosen}
    for index in sorted(lines):
        print(index, lines[index])
