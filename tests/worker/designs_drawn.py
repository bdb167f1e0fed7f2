"""Design points drawn once and for all, for questions that need many."""

from collections.abc import Iterator

import numpy as np

from damperlab.worker.accuracy.steady_answers import SETTINGS, Point
from damperlab.worker.physics.compliant_wall import wall_constants
from damperlab.worker.solver.particle import Particle, Wall
from damperlab.worker.solver.state import State
from damperlab.worker.steady.response.measures import Response
from damperlab.worker.steady.settle import Settings, settle


def solved(point: Point, settings: Settings = SETTINGS, start: State | None = None) -> tuple[Response, State]:
    """Steady response from rest, or from a given start, and the state at its end."""
    found: tuple[Response, State] = settle(*point, settings, point.rest() if start is None else start)
    return found


def with_contact(particle: Particle, model: str, contact_time: float) -> Particle:
    """The same particle with a contact that takes time, where the model says so."""
    if model == "dwell":
        return particle._replace(contact_time=contact_time)
    if model == "compliant":
        wall = wall_constants(particle.restitution, contact_time, particle.mass_ratio)
        return particle._replace(wall=Wall(*wall))
    return particle


def drawn_points(seed: int, damping: tuple[float, ...] = (0.0038, 0.01, 0.05)) -> Iterator[Point]:
    """Points with a particle, every third without friction, without end; the same for the same seed."""
    random = np.random.default_rng(seed)
    while True:
        place = random.random(6)
        clearance, friction = 0.5 * 50.0 ** place[0], 0.02 + 0.9 * place[1]
        frequency = 0.5 * 4.0 ** place[2] if random.random() < 0.5 else 0.9 + 0.2 * place[2]
        particle = Particle(float(clearance), float(0.95 * place[3]), float(0.01 * 50.0 ** place[4]))
        rubs = random.random() < 2.0 / 3.0
        zeta = damping[int(random.integers(len(damping)))]
        yield Point(zeta, float(frequency), float(friction) if rubs else None, particle)
