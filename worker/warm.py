"""Compilation of kernels, once per machine and in one process at a time.

A scene is a combination of forces and a requested result. The kernels of a scene are compiled by computing
the smallest task of the scene once, so no list of kernels is needed. A file lock in the cache folder lets one
process compile the kernels of a scene, while other processes wait and then load the kernels. A marker file
shows that all kernels of a scene exist.
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
except ImportError:  # outside POSIX systems there are no file locks and no memory figures
    fcntl = resource = None  # type: ignore[assignment]

SHARE = 1 / 3
"""Memory limit for compiling further scenes with other forces, as a fraction of the memory per core."""
LOOK_SECONDS = 1.0
"""Interval between checks whether the parent of a compiling process still exists [s]."""
_LOADING = threading.RLock()
_PARTICLE = Particle(1.0, 0.5, 0.1)
_CONTACT_TIME = 0.1
_PARTICLE_FRICTION = 0.3
_GRAVITY = 1.0


def is_ready(scene: Scene) -> bool:
    """Return whether all kernels of a scene exist in the package or in the cache folder."""
    return any((folder / marker(scene)).exists() for folder in (shipped_folder(), CACHE_FOLDER))


def missing(wanted: Iterable[Scene]) -> list[Scene]:
    """Return the scenes whose kernels must be compiled, in descending order of compile time."""
    return sorted((scene for scene in set(wanted) if not is_ready(scene)), key=lambda scene: -scene.seconds)


def warm(scene: Scene) -> None:
    """Load the kernels of a scene, and compile missing kernels under a lock for all threads and processes."""
    with _LOADING:
        _loaded(scene)


@cache
def _loaded(scene: Scene) -> None:
    if not is_ready(scene):
        _made(scene, wait=True)
    _compute_once(scene)


def warm_alike(wanted: Sequence[Scene]) -> None:
    """Compile the first scene that no other process is compiling, and then further scenes with the same forces.

    The forces determine most of the code of a scene, so scenes with the same forces are compiled in one process. For
    example, compiling six scenes of a hybrid damper takes 44 s of CPU time in one process, and 69 s in separate
    processes. Other scenes follow as long as the process uses little memory, because compiled parts remain in memory,
    0.2 GB for a large scene.

    Parameters
    ----------
    wanted : sequence of Scene
        Scenes in the preferred order of compilation.

    Raises
    ------
    RuntimeError
        If a scene cannot be compiled. The message names the scene.
    """
    left = list(wanted)
    next_ones: Iterable[Scene] = wanted
    while made := next((scene for scene in next_ones if _made_by_name(scene, wait=False)), None):
        left.remove(made)
        alike = [scene for scene in left if scene[1:] == made[1:]]
        others = [scene for scene in left if scene not in alike]
        next_ones = chain(alike, (scene for scene in others if _has_held() < _much()))
    if len(left) == len(wanted):  # other processes are compiling these scenes; wait for the first scene
        _made_by_name(left[0], wait=True)


def _much() -> float:
    """Return the peak memory [bytes] below which a process also compiles scenes with other forces."""
    from dask.system import CPU_COUNT
    from distributed.system import MEMORY_LIMIT

    much: float = SHARE * MEMORY_LIMIT / CPU_COUNT
    return much


def _has_held() -> float:
    """Return the peak memory of this process [bytes], or infinity if the system does not report it."""
    if resource is None:
        return float("inf")
    return float(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss) * (
        1 if sys.platform == "darwin" else 1024
    )


def _made_by_name(scene: Scene, wait: bool) -> bool:
    """Compile a scene as `_made` does, and name the scene in the message of an error."""
    try:
        return _made(scene, wait)
    except Exception as error:
        raise RuntimeError(f"{scene.name}: {error}") from error


def _made(scene: Scene, wait: bool) -> bool:
    """Compile a scene. If another process is compiling the scene and `wait` is False, return False immediately."""
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
        Scenes with missing kernels, in the preferred order.
    at_once : int
        Largest number of processes.
    cache : Path
        Cache folder, as set by DAMPERLAB_CACHE_DIR.

    Yields
    ------
    scene : Scene
        Compiled scene, as soon as its kernels exist.
    seconds : float
        Compile time of the scene [s].

    Raises
    ------
    RuntimeError
        If a process fails; all other processes are then ended. The message contains the last line of output
        of the failed process.
    """
    left = list(wanted)
    folder = cache / CACHE_FOLDER.name
    began = time.monotonic()
    # without file locks, each process would compile all scenes
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
            if not running:  # the folder is not writable, so the kernels are in another folder
                yield from ((scene, time.monotonic() - began) for scene in left)
                return
            time.sleep(0.02)
    finally:
        for process, _ in running:
            process.kill()
            process.communicate()


def _seconds(file: Path) -> float | None:
    """Return the compile time in a marker file, or None if the file is missing or incomplete."""
    try:
        return float(file.read_text())
    except (OSError, ValueError):
        return None


def start_apart(wanted: Iterable[Scene], cache: Path = CACHE_FOLDER.parent) -> "subprocess.Popen[str]":
    """Start a process that compiles some of the given scenes (`warm_alike`). The new process ends when this process
    ends.
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
    """Wait for a process of `start_apart`; if it fails, raise RuntimeError with its last line of output."""
    written = process.communicate()[1].strip()
    if process.returncode:
        last = written.splitlines()[-1] if written else f"it ended with status {process.returncode}"
        raise RuntimeError(f"kernels could not be compiled: {last}")


def marker(scene: Scene) -> str:
    """Return the name of the marker file for the kernels of a scene."""
    return f"{scene.name}.ready"


@contextmanager
def _alone(name: str, wait: bool) -> Iterator[bool]:
    """Acquire the machine-wide lock for compiling a scene, and yield whether it was acquired."""
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
    """Execute a minimal task that calls every kernel of a scene with the usual argument types."""
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
    settle(0.1, 1.0, friction, particle, settings, at_rest(1.0, friction, particle))
    # `moving` computes the initial states of an ensemble
    moving(0.0, 0.0, 0.0, 0.0, 1.0, friction, particle)


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

    design = Design(0.1, 1.0, 0.5 if scene.friction else 0.0, _particle(scene))
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
    """End this process after its parent has ended, because the result is no longer needed."""
    while os.getppid() == parent:
        time.sleep(LOOK_SECONDS)
    os._exit(1)


if __name__ == "__main__":
    stand_back()
    threading.Thread(target=_end_with, args=(int(sys.argv[1]),), daemon=True).start()
    warm_alike([scene_named(name) for name in sys.argv[2:]])
