"""Kernels compiled once per machine, by one process at a time.

numba's disk cache lets every process that misses compile for itself; with several workers starting together each would
spend the same half minute. A file lock in the cache folder lets the first compile and the others load.
"""

from collections.abc import Iterator
from contextlib import contextmanager

from studies.definition import Study
from worker.jit import CACHE_FOLDER
from worker.solver.scene import Particle, Wall
from worker.steady.settle import Settings, settle
from worker.steady.start import at_rest

try:
    import fcntl
except ImportError:  # not a POSIX system: every process compiles for itself
    fcntl = None  # type: ignore[assignment]

_SHORT = Settings(1, 0.5, 1e-2)
_PARTICLE = Particle(1.0, 0.5, 0.1)
_CONTACT_TIME = 0.1


Scene = tuple[bool, bool, str]
"""Whether there is friction, whether there is a particle, and the model of its contact ("" without one)."""


def scenes(study: Study) -> list[Scene]:
    """Kernels that a study needs; none for its linear points."""
    rubs = {bool(value > 0.0) for value in study.coordinates["friction_ratio"][[0, -1]]}
    rattles = {bool(value > 0.0) and study.particle for value in study.coordinates["mass_ratio"][[0, -1]]}
    return sorted((f, p, study.contact.model if p else "") for f in rubs for p in rattles if f or p)


def warm(scene: Scene) -> None:
    """Compile (or load) the kernel of a scene while no other process does the same."""
    rubs, rattles, model = scene
    particle = _PARTICLE._replace(
        contact_time=_CONTACT_TIME if model == "dwell" else None,
        wall=Wall(1.0, 0.1) if model == "compliant" else None,
    )
    with _alone(
        f"{'friction' if rubs else 'free'}-{'particle' if rattles else 'alone'}{model and '-' + model}"
    ):
        friction = 0.5 if rubs else None
        start = at_rest(1.0, friction, particle if rattles else None)
        settle(0.1, 1.0, friction, particle if rattles else None, _SHORT, start)


@contextmanager
def _alone(name: str) -> Iterator[None]:
    if fcntl is None:
        yield
        return
    with (CACHE_FOLDER / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield
