"""Marches every scene a few cycles and prints the bits; run by `test_jit` in processes of their own.

As a motion from rest is marched and shown, events logged, so `damperlab warm` has compiled the kernels.
"""

import sys

import numpy as np

from damperlab.worker.solver.events import BUDGET
from damperlab.worker.solver.integrate import half_cycle
from damperlab.worker.solver.observe.meter import METERS, Meter
from damperlab.worker.solver.particle import Particle, Wall
from damperlab.worker.solver.scene import make_scene
from damperlab.worker.solver.segment_log import empty_log
from damperlab.worker.steady.start import at_rest

PARTICLE = Particle(2.0, 0.6, 0.2)
CONTACTS = (
    PARTICLE,
    PARTICLE._replace(contact_time=0.05),
    PARTICLE._replace(wall=Wall(400.0, 4.0)),
)
SCENES = [(0.3, None), *((friction, particle) for particle in CONTACTS for friction in (None, 0.3))]


def bits(friction: float | None, particle: Particle | None) -> str:
    scene = make_scene(0.02, 0.97, friction, particle, True)
    scene.counts[BUDGET] = 10**6
    state = at_rest(0.97, friction, particle)
    sums = np.zeros(METERS)
    log = empty_log(1000)
    for _ in range(60):
        log.cursor[0] = 0
        state, _ = half_cycle(state, scene, Meter(sums), log)
    numbers = [state.v, state.w, state.gap, state.p_rate, *sums]
    return " ".join(float(number).hex() for number in numbers)


if __name__ == "__main__":
    chosen = [int(index) for index in sys.argv[1:]]
    lines = {index: bits(*SCENES[index]) for index in chosen}
    for index in sorted(lines):
        print(index, lines[index])
