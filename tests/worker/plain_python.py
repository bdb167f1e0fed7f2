"""Kernels as plain Python functions, in a process of their own: the same sources, and no compiler.

So contacts and measures are looked at whose kernels take long to compile, and which the night alone compiles.
"""

import os
import pickle
import sys
from collections.abc import Callable, Sequence
from types import FunctionType
from typing import Any

import numpy as np
from tests.ready import ready

from damperlab.worker.solver.events import BUDGET
from damperlab.worker.solver.integrate import half_cycle
from damperlab.worker.solver.observe.meter import ACCELERATION_PEAK, ACCELERATION_SQUARE, METERS, Meter
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.scene import make_scene
from damperlab.worker.solver.state import State

SECONDS = 600.0


def plainly(function: Callable[..., Any], asked: Sequence[tuple[Any, ...]]) -> list[Any]:
    """Call a function once for each tuple of arguments where kernels are plain functions."""
    pickled = pickle.dumps((function, list(asked))).hex()
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    done = ready().run("tests.worker.plain_python", [pickled], environment, SECONDS)
    assert done.returncode == 0, done.stderr
    found: list[Any] = pickle.loads(bytes.fromhex(done.stdout))
    return found


def accelerated(
    damping_ratio: float,
    frequency_ratio: float,
    friction: float | None,
    particle: Particle | None,
    state: State,
    forced: bool = False,
) -> tuple[float, float]:
    """Largest |u''| of the cycle that begins with a state, and the integral of its square."""
    scene = make_scene(damping_ratio, frequency_ratio, friction, particle, True, forced)
    scene.counts[BUDGET] = 100_000
    meter = Meter(np.zeros(METERS), True, True)
    for _ in range(2):
        state, _ = half_cycle(state, scene, meter, None)
    return float(meter.sums[ACCELERATION_PEAK]), float(meter.sums[ACCELERATION_SQUARE])


if __name__ == "__main__":
    assert isinstance(half_cycle, FunctionType)
    function, asked = pickle.loads(bytes.fromhex(sys.argv[1]))
    print(pickle.dumps([function(*each) for each in asked]).hex())
