"""Run time of each scene's kernel per excitation cycle, beside the paper's Runge–Kutta with 400 steps, in one run.

A march through the steady response (a march goes on where the last one ended): bare; with true peaks, impact speed and time
stuck; with energies and the mean square besides. Repeats of the two methods alternate, so that a noisy neighbour meets both.
"""

from time import perf_counter
from typing import Any

import numpy as np

from damperlab.worker.accuracy.steady_answers import Point
from damperlab.worker.jit import kernel
from damperlab.worker.rk4 import march_rk4
from damperlab.worker.solver.addresses import on_addresses
from damperlab.worker.solver.events import ARRIVED, ATTACHMENTS, BUDGET, COUNTS, IMPACTS, TURNS
from damperlab.worker.solver.integrate import half_cycle_on_addresses
from damperlab.worker.solver.observe.meter import METERS, PEAK, RELATIVE_PEAK, Meter
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.scene import make_scene

TRANSIENT = 300
"""Cycles from rest before a time is taken."""
CYCLES = 2000
"""Of our march in one repeat."""
STEPS = 400
"""Of the paper's method per cycle: 0.001 s at 2.5 Hz."""
STEPPED_CYCLES = 200
REPEATS = 15


SCENES = {
    "linear": Point(0.0038, 1.0, None, None),
    "friction": Point(0.0038, 1.0, 0.6, None),
    "friction with stick": Point(0.0038, 1.0, 0.8, None),
    "particle": Point(0.0038, 1.0, None, Particle(10.0, 0.47, 0.1)),
    "particle with chatter": Point(0.0038, 1.0, None, Particle(1.0, 0.47, 0.1)),
    "hybrid 5/0.4": Point(0.0038, 1.0, 0.4, Particle(5.0, 0.47, 0.1)),
    "hybrid 2/0.6": Point(0.0038, 1.0, 0.6, Particle(2.0, 0.47, 0.1)),
    "hybrid with stick": Point(0.0038, 0.9, 0.6, Particle(2.0, 0.47, 0.1)),
    "hybrid with chatter and stick": Point(0.0038, 0.9, 0.8, Particle(0.3, 0.47, 0.1)),
}


@kernel
def _march(state, scene, meter, cycles):  # type: ignore[no-untyped-def]
    """Whole cycles; the peaks of each are set back, as the search for the steady response does."""
    total = 0.0
    at, sums = on_addresses(scene), on_addresses(meter)
    for _ in range(cycles):
        if meter is not None:
            sums.sums[PEAK] = 0.0
            sums.sums[RELATIVE_PEAK] = 0.0
        for _ in range(2):
            state, outcome = half_cycle_on_addresses(state, at, sums, None)
            if outcome != ARRIVED:
                return state, outcome, total
        if meter is not None:
            total += sums.sums[PEAK]
    return state, ARRIVED, total


def measure(point: Point, repeats: int = REPEATS) -> dict[str, Any]:
    """Time one scene.

    Raises
    ------
    RuntimeError
        Where the march does not arrive: a time would mean nothing.
    """
    scene = make_scene(*point, True)
    counts = scene.counts
    counts[BUDGET] = 10**12
    state = point.rest()
    meters = {
        "march": None,
        "peaks": Meter(np.zeros(METERS), None),
        "metered": Meter(np.zeros(METERS)),
    }
    seconds: dict[str, list[float]] = {name: [] for name in (*meters, "rk4")}
    peaks = np.empty((2 * STEPPED_CYCLES + 1, 2))
    stepped = np.zeros(COUNTS, np.int64)
    for meter in meters.values():
        state, _outcome, _ = _march(state, scene, meter, TRANSIENT)
    march_rk4(*point, STEPS, STEPPED_CYCLES, stepped, peaks)
    counts[:BUDGET] = 0
    for _ in range(repeats):
        for name, meter in meters.items():
            began = perf_counter()
            state, outcome, _ = _march(state, scene, meter, CYCLES)
            seconds[name].append(perf_counter() - began)
            if outcome != ARRIVED:
                raise RuntimeError(f"the march of {point} ended with {outcome}")
        began = perf_counter()
        march_rk4(*point, STEPS, STEPPED_CYCLES, stepped, peaks)
        seconds["rk4"].append(perf_counter() - began)
    figures: dict[str, Any] = {}
    for name, taken in seconds.items():
        per_cycle = 1e6 * np.array(taken) / (STEPPED_CYCLES if name == "rk4" else CYCLES)
        figures |= {f"{name}_us": float(per_cycle.min()), f"{name}_us_median": float(np.median(per_cycle))}
    cycles = len(meters) * repeats * CYCLES
    return figures | {
        "rk4_over_march": figures["rk4_us"] / figures["march_us"],
        "rk4_over_peaks": figures["rk4_us"] / figures["peaks_us"],
        "rk4_over_metered": figures["rk4_us"] / figures["metered_us"],
        "windows_per_cycle": 2 * scene.base.windows,
        "impacts_per_cycle": counts[IMPACTS] / cycles,
        "turns_per_cycle": counts[TURNS] / cycles,
        "attachments_per_cycle": counts[ATTACHMENTS] / cycles,
    }


def run() -> dict[str, Any]:
    """Time every scene."""
    return {name: measure(scene) for name, scene in SCENES.items()}
