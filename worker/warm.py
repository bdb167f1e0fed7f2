"""Kernels compiled once per machine, by one process at a time.

numba's disk cache lets every process that misses compile for itself; with several workers starting together each would
spend the same half minute. A file lock in the cache folder lets the first compile and the others load.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

from damperlab.studies.definition import Study
from damperlab.worker.jit import CACHE_FOLDER
from damperlab.worker.lower import wants_energies
from damperlab.worker.solver.scene import Particle, Wall
from damperlab.worker.steady.settle import Settings, settle
from damperlab.worker.steady.start import at_rest

try:
    import fcntl
except ImportError:  # not a POSIX system: every process compiles for itself
    fcntl = None  # type: ignore[assignment]

_PARTICLE = Particle(1.0, 0.5, 0.1)
_CONTACT_TIME = 0.1


Scene = tuple[bool, bool, str, bool]
"""Whether there is friction, a particle, the model of its contact ("" without one), and whether energies are measured."""


def scenes(study: Study) -> list[Scene]:
    """Kernels that a study needs; none for its linear points."""
    rubs = {bool(value > 0.0) for value in study.coordinates["friction_ratio"][[0, -1]]}
    rattles = {bool(value > 0.0) and study.particle for value in study.coordinates["mass_ratio"][[0, -1]]}
    energies = bool(wants_energies(study))
    return sorted((f, p, study.contact.model if p else "", energies) for f in rubs for p in rattles if f or p)


def scene_of(friction: float | None, particle: Particle | None, energies: bool | None) -> Scene:
    """Kernel that a point needs."""
    model = ""
    if particle is not None:
        model = "compliant" if particle.wall else "dwell" if particle.contact_time is not None else "instant"
    return friction is not None, particle is not None, model, bool(energies)


@cache
def warm(scene: Scene) -> None:
    """Compile (or load) the kernel of a scene while no other process does the same."""
    rubs, rattles, model, energies = scene
    particle = _PARTICLE._replace(
        contact_time=_CONTACT_TIME if model == "dwell" else None,
        wall=Wall(1.0, 0.1) if model == "compliant" else None,
    )
    name = f"{'friction' if rubs else 'free'}-{'particle' if rattles else 'alone'}{model and '-' + model}"
    with alone(name if energies else f"{name}-peaks"):
        friction = 0.5 if rubs else None
        start = at_rest(1.0, friction, particle if rattles else None)
        settle(
            0.1, 1.0, friction, particle if rattles else None, Settings(1, 0.5, 1e-2, energies or None), start
        )


@contextmanager
def alone(name: str) -> Iterator[None]:
    """Hold what one process of this machine holds at a time: the making of the kernels of this name."""
    if fcntl is None:
        yield
        return
    with (CACHE_FOLDER / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield
