"""Design points drawn once and for all, for questions that need many."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from damperlab.worker.physics.compliant_wall import wall_constants
from damperlab.worker.solver.particle import Particle, Wall
from damperlab.worker.solver.state import State
from damperlab.worker.steady.response.measures import Response
from damperlab.worker.steady.settle import Settings, settle
from damperlab.worker.steady.start import at_rest

SETTINGS = Settings(4000, 0.02, 1e-9)
"""The defaults of a study."""


class Point(NamedTuple):
    """One design point, as `settle` takes it."""

    damping_ratio: float
    frequency_ratio: float
    friction: float | None
    particle: Particle

    def rest(self, forced: bool = False) -> State:
        """Everything at rest."""
        return at_rest(self.frequency_ratio, self.friction, self.particle, forced)

    def solve(self) -> tuple[Response, State]:
        """Steady response from rest with a study's default settings, and the state at its end."""
        return settle(*self, SETTINGS, self.rest())


def with_contact(point: Point, model: str, contact_time: float) -> Point:
    """The same point with a contact that takes time, where the model says so."""
    one = point.particle
    if model == "dwell":
        return point._replace(particle=one._replace(contact_time=contact_time))
    if model == "compliant":
        wall = Wall(*wall_constants(one.restitution, contact_time, one.mass_ratio))
        return point._replace(particle=one._replace(wall=wall))
    return point


def drawn_points(
    seed: int, near_resonance: bool = False, damping: tuple[float, ...] = (0.0038, 0.01, 0.05)
) -> Iterator[Point]:
    """Points with a particle, every third without friction, without end; the same for the same seed.

    Near resonance (r 0.9 to 1.1, d/Z 2 to 20, γ_F up to 0.7) few responses repeat.
    """
    random = np.random.default_rng(seed)
    while True:
        place = random.random(6)
        if near_resonance:
            clearance, friction, frequency = 2.0 + 18.0 * place[0], 0.7 * place[1], 0.9 + 0.2 * place[2]
        else:
            clearance, friction = 0.5 * 50.0 ** place[0], 0.02 + 0.9 * place[1]
            frequency = 0.5 * 4.0 ** place[2] if random.random() < 0.5 else 0.9 + 0.2 * place[2]
        particle = Particle(float(clearance), float(0.95 * place[3]), float(0.01 * 50.0 ** place[4]))
        rubs = random.random() < 2.0 / 3.0
        zeta = damping[int(random.integers(len(damping)))]
        yield Point(zeta, float(frequency), float(friction) if rubs else None, particle)
