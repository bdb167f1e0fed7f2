"""Compiles kernels once per machine, by one process at a time.

A kernel is compiled for a scene: the forces that act, and the requested results. Without this, each process that lacks
a kernel would compile it for itself. A file lock in the cache folder lets the first process compile, and the others
load. The kernels of a scene are found by computing its smallest task once, so that the code needs no separate list of
kernels. A marker file means that all kernels of a scene are present.
"""

import os
import subprocess
import sys
import threading
import time
from collections.abc import Generator, Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from itertools import chain
from pathlib import Path
from typing import Literal

import numpy as np

from damperlab.worker.jit import CACHE_FOLDER, shipped_folder
from damperlab.worker.niceness import stand_back
from damperlab.worker.scenes import Scene, scene_named
from damperlab.worker.solver.particle import FALLING, RUBBING, Particle, Wall

try:
    import fcntl
    import resource
except (
    ImportError
):  # outside POSIX systems every process compiles for itself, and ends before scenes with other elements
    fcntl = resource = None  # type: ignore[assignment]

SHARE = 1 / 3
"""A compiling process continues with other parts only if it holds less than this share of the machine's memory per
core.
"""
LOOK_SECONDS = 1.0
"""Interval between checks that the parent of a compiling process still exists."""
_LOADING = threading.RLock()
_PARTICLE = Particle(1.0, 0.5, 0.1)
_CONTACT_TIME = 0.1
_PARTICLE_FRICTION = 0.3
_GRAVITY = 1.0


def is_ready(scene: Scene) -> bool:
    """Whether all kernels of a scene are compiled, here or in the package: loading them takes less than a second."""
    return any((folder / marker(scene)).exists() for folder in (shipped_folder(), CACHE_FOLDER))


def missing(wanted: Iterable[Scene]) -> list[Scene]:
    """The scenes whose kernels must be compiled, the most expensive first."""
    return sorted((scene for scene in set(wanted) if not is_ready(scene)), key=lambda scene: -scene.seconds)


def warm(scene: Scene) -> None:
    """Load the kernels of a scene. Missing ones are compiled, while no other thread or process does the same."""
    with _LOADING:
        _loaded(scene)


@cache
def _loaded(scene: Scene) -> None:
    if not is_ready(scene):
        _made(scene, wait=True)
    _compute_once(scene)


def warm_alike(wanted: Sequence[Scene]) -> None:
    """Compile the first scene that no other process is compiling, then those with the same elements, then others
    while memory is left.

    The elements of a scene determine most of its code. Six scenes of a hybrid damper take 44 s of CPU time in one
    process, and 69 s in separate ones. A process that continues with the scenes of another damper still saves a third
    of the time for the first of them: numba compiles its own code only once, and the scenes share some parts. Compiled
    parts stay in memory, 0.2 GB for a large scene, so a process whose parts fill much memory ends instead of compiling
    scenes with other parts.

    Parameters
    ----------
    wanted : sequence of Scene
        Scenes in the order in which they are compiled.

    Raises
    ------
    RuntimeError
        With the scene's name, if one cannot be compiled.
    """
    left = list(wanted)
    next_ones: Iterable[Scene] = wanted
    while made := next((scene for scene in next_ones if _made_by_name(scene, wait=False)), None):
        left.remove(made)
        alike = [scene for scene in left if scene[1:] == made[1:]]
        others = [scene for scene in left if scene not in alike]
        next_ones = chain(alike, (scene for scene in others if _has_held() < _much()))
    if len(left) == len(wanted):  # other processes compile all of these; wait until the first is done
        _made_by_name(left[0], wait=True)


def _much() -> float:
    """Memory above which this process ends instead of compiling scenes with other parts [bytes], from its machine or
    container.
    """
    from dask.system import CPU_COUNT
    from distributed.system import MEMORY_LIMIT

    much: float = SHARE * MEMORY_LIMIT / CPU_COUNT
    return much


def _has_held() -> float:
    """The most memory that this process has held so far [bytes]; infinite if the system does not report it."""
    if resource is None:
        return float("inf")
    return float(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss) * (
        1 if sys.platform == "darwin" else 1024
    )


def _made_by_name(scene: Scene, wait: bool) -> bool:
    """Do the same as `_made`; an error names the scene."""
    try:
        return _made(scene, wait)
    except Exception as error:
        raise RuntimeError(f"{scene.name}: {error}") from error


def _made(scene: Scene, wait: bool) -> bool:
    """Compile a scene; return False immediately if another process is compiling it."""
    with _alone(scene.name, wait) as alone:
        if alone and not is_ready(scene):
            began = time.monotonic()
            _compute_once(scene)
            (CACHE_FOLDER / marker(scene)).write_text(f"{time.monotonic() - began:.3f}")
        return alone


def compile_apart(
    wanted: Sequence[Scene], at_once: int, cache: Path = CACHE_FOLDER.parent
) -> Generator[tuple[Scene, float], None, None]:
    """Compile scenes in several parallel processes.

    Parameters
    ----------
    wanted : sequence of Scene
        Scenes with missing kernels, in their order; see `warm_alike`.
    at_once : int
        Largest number of parallel processes.
    cache : Path
        Folder, as in DAMPERLAB_CACHE_DIR.

    Yields
    ------
    scene : Scene
        A completed scene, in the order in which they end.
    seconds : float
        Its time [s].

    Raises
    ------
    RuntimeError
        With the last line of a failed process; the others are ended.
    """
    left = list(wanted)
    folder = cache / CACHE_FOLDER.name
    began = time.monotonic()
    # without file locks each process would compile all of them
    running = [(start_apart(left, cache), len(left)) for _ in range(min(at_once if fcntl else 1, len(left)))]
    try:
        while left:
            ended = [one for one in running if one[0].poll() is not None]
            for scene in list(left):
                if (seconds := _seconds(folder / marker(scene))) is not None:
                    left.remove(scene)
                    yield scene, seconds
            for process, lacked in ended:
                running.remove((process, lacked))
                require_done(process)
                if 0 < len(left) < lacked:
                    running.append((start_apart(left, cache), len(left)))
            if not running:  # stored in another folder, because this one cannot be written
                yield from ((scene, time.monotonic() - began) for scene in left)
                return
            time.sleep(0.02)
    finally:
        for process, _ in running:
            process.kill()
            process.communicate()


def _seconds(file: Path) -> float | None:
    """Read the compile time in a marker; None while the marker is missing or being written."""
    try:
        return float(file.read_text())
    except (OSError, ValueError):
        return None


def start_apart(wanted: Iterable[Scene], cache: Path = CACHE_FOLDER.parent) -> "subprocess.Popen[str]":
    """Start a process that compiles some of these scenes (`warm_alike`), by default into this process's cache
    folder.

    It ends when this process ends.
    """
    command = [sys.executable, "-m", __name__, str(os.getpid()), *(scene.name for scene in wanted)]
    environment = os.environ | {"DAMPERLAB_CACHE_DIR": str(cache)}
    return subprocess.Popen(
        command,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )


def require_done(process: "subprocess.Popen[str]") -> None:
    """Wait for a process of `start_apart`; RuntimeError with its last line, if it failed."""
    written = process.communicate()[1].strip()
    if process.returncode:
        last = written.splitlines()[-1] if written else f"it ended with status {process.returncode}"
        raise RuntimeError(f"kernels could not be compiled: {last}")


def marker(scene: Scene) -> str:
    """Name of the marker file for a scene's kernels."""
    return f"{scene.name}.ready"


@contextmanager
def _alone(name: str, wait: bool) -> Iterator[bool]:
    """Hold the lock for compiling the kernels of this name, which all processes of this machine share. Gives whether it
    is held.
    """
    if fcntl is None:
        yield True
        return
    with (CACHE_FOLDER / f"{name}.lock").open("w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            yield False
        else:
            yield True


def _compute_once(scene: Scene) -> None:
    """Compute the smallest task that calls every kernel of a scene, as its users do."""
    if scene.purpose in ("record", "record-history"):
        _record(scene)
    elif scene.purpose in ("steady", "peaks", "acceleration"):
        _steady(scene)
    elif scene.purpose == "stepped":
        _stepped(scene)
    elif scene.purpose == "accuracy":
        _accuracy(scene)
    else:
        _point(scene)


def _particle(scene: Scene) -> Particle | None:
    if not scene.contact:
        return None
    return _PARTICLE._replace(
        contact_time=_CONTACT_TIME if scene.contact == "dwell" else None,
        wall=Wall(1.0, 0.1) if scene.contact == "compliant" else None,
        friction=_PARTICLE_FRICTION if scene.contact in (RUBBING, FALLING) else None,
        gravity=_GRAVITY if scene.contact == FALLING else None,
    )


def _steady(scene: Scene) -> None:
    from damperlab.worker.kernel_arguments import excitation_of
    from damperlab.worker.steady.settle import Settings, settle
    from damperlab.worker.steady.start import at_rest, moving

    friction, particle = 0.5 if scene.friction else None, _particle(scene)
    settings = Settings(
        1,
        0.5,
        1e-2,
        None if scene.purpose == "peaks" else True,
        True if scene.purpose == "acceleration" else None,
    )
    one = excitation_of(1.0, scene.forced)
    rest = at_rest(one, friction, particle)
    settle(0.1, one, friction, particle, settings, rest)
    # the initial states of ensembles
    moving(0.0, 0.0, 0.0, 0.0, one, friction, particle)


def _stepped(scene: Scene) -> None:
    from damperlab.worker.steady.fixed_steps import settle_stepped
    from damperlab.worker.steady.settle import Settings

    settings = Settings(1, 0.5, 1e-2, None)
    settle_stepped(0.1, 1.0, 0.5 if scene.friction else None, _particle(scene), 20, settings)


def _accuracy(scene: Scene) -> None:
    from damperlab.worker.accuracy.march import march_from_rest, march_halves
    from damperlab.worker.rk4 import march_rk4_wall
    from damperlab.worker.solver.observe.meter import METERS, Meter
    from damperlab.worker.steady.response.standard_errors import mean_and_error
    from damperlab.worker.steady.start import at_rest

    friction, particle = 0.5 if scene.friction else None, _particle(scene)
    for meter in (None, Meter(np.zeros(METERS))):
        march_from_rest(0.1, 1.0, friction, particle, 1, meter)
    if scene.friction or scene.contact:
        march_halves(0.1, 1.0, friction, particle, at_rest(1.0, friction, particle), 0, np.empty((1, 3)))
        mean_and_error(np.zeros(2), 0, 2)
    if scene.contact == "compliant":
        march_rk4_wall(0.1, 1.0, friction, particle, 20, 1)


def _point(scene: Scene) -> None:
    from damperlab.worker.point import Design, show_orbit, simulate_ready

    design = Design(0.1, 1.0, 0.5 if scene.friction else 0.0, _particle(scene), scene.forced)
    method: Literal["event", "rk4"] = "rk4" if scene.purpose == "rk4" else "event"
    show_orbit(design) if scene.purpose == "orbit" else simulate_ready(design, 1, 1, method)


def _record(scene: Scene) -> None:
    from damperlab.studies.cavity import Cavity
    from damperlab.studies.contact import parse_contact
    from damperlab.studies.ground.motion import GroundMotion
    from damperlab.worker.ground.design import INSTANT, Damper, Structure
    from damperlab.worker.ground.response import ground_history, ground_response

    still = GroundMotion("", 0.01, np.array([0.0, 1.0, 0.0]))
    timed = scene.contact in ("dwell", "compliant")
    contact = parse_contact({"model": scene.contact, "contact_time": _CONTACT_TIME}) if timed else INSTANT
    rubs = _PARTICLE_FRICTION if scene.contact in (RUBBING, FALLING) else 0.0
    cavity = Cavity(rubs, 30.0 if scene.contact == FALLING else 0.0)
    damper = Damper(float(scene.friction), float(bool(scene.contact)), contact=contact, cavity=cavity)
    if scene.purpose == "record-history":
        ground_history(Structure(), damper, still)
    else:
        ground_response(Structure(), damper, still)


def _end_with(parent: int) -> None:
    """End this process once its parent is gone, because nobody waits for the result and the cores are needed."""
    while os.getppid() == parent:
        time.sleep(LOOK_SECONDS)
    os._exit(1)


if __name__ == "__main__":
    stand_back()
    threading.Thread(target=_end_with, args=(int(sys.argv[1]),), daemon=True).start()
    warm_alike([scene_named(name) for name in sys.argv[2:]])
