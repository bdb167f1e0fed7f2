"""What a design point is expected to cost, so that blocks take about equal time and the longest start first.

A rough model is enough: it decides sizes and order, never a result. Its form is cycles until the response is known
to be steady, times seconds per cycle of the scene's kernel; its constants were fitted to the solver's own cycles and
run times on random points of every scene (r 0.05 … 20, ζ 0.0038 … 0.5, d/Z 0.05 … 25). Means over a scene mostly
agree within a factor of three; single points scatter more, above all between periodic and modulated neighbours.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.choices import Ensemble, Rk4Solver
from damperlab.studies.definition import Study
from damperlab.studies.ground.suite import Suite, windows_of
from damperlab.studies.kind import AnyStudy

LINEAR_SECONDS = 2e-6
"""A point in closed form, storing included: nothing else costs anything there."""
FRICTION_CYCLE_SECONDS, PARTICLE_CYCLE_SECONDS, HYBRID_CYCLE_SECONDS = 0.75e-6, 1.7e-6, 2.5e-6
"""One excitation cycle."""
RUN_SECONDS, RECORD_WINDOW_SECONDS = 5e-5, 0.15e-6
"""One run under a record: what it takes in any case, and each of its windows, measured on built-in records from 1 to 50 Hz."""
STEP_SECONDS = 0.04e-6
"""One step of the fixed-step method, whatever the scene."""
MOST_RIDING = 20.0
"""How much more a cycle costs at most where the clearance is below the amplitude: the particle chatters and rides."""
FEWEST_CYCLES = 65.0
"""Taken before a response is believed to be steady."""
TRANSIENT = 0.7
"""Cycles that a transient takes, in units of r/ζ: it dies as exp(−ζτ), and a cycle lasts 2π/r."""
MODULATED_SHARE = 0.33
"""Share of the points with a particle, near resonance, that run to max_cycles because nothing settles."""
RESONANCE_WIDTH = 0.1
"""How far from resonance, in ln r, friction lets the particle of a hybrid rattle without end."""


def seconds_per_point(study: AnyStudy, coordinates: dict[str, NDArray[Any]]) -> NDArray[np.float64]:
    """Kernel seconds that design points are expected to take.

    Parameters
    ----------
    study : Study
        Of which only the scene, the starts, the records and `steady.max_cycles` matter.
    coordinates : dict of ndarray
        The dimensions by name, N values each.

    Returns
    -------
    ndarray
        N values [s], all above 0.
    """
    if isinstance(study, Suite):
        return _suite(study, coordinates)
    if isinstance(study, Study):
        return _harmonic(study, coordinates)
    raise TypeError(f"no cost is known of a {type(study).__name__}")


def _suite(study: Suite, coordinates: dict[str, NDArray[Any]]) -> NDArray[np.float64]:
    tail = study.numbers["tail_s"]
    frequency = coordinates["natural_frequency_hz"]
    windows = np.empty(frequency.size)
    for source in study.records:
        under = coordinates["record"] == source.id
        windows[under] = windows_of(source, frequency[under], tail)
    return (1 + study.starts) * (RUN_SECONDS + RECORD_WINDOW_SECONDS * windows)


def _harmonic(study: Study, coordinates: dict[str, NDArray[np.float64]]) -> NDArray[np.float64]:
    most = float(study.steady.max_cycles)
    ratio = coordinates["frequency_ratio"]
    rubs = coordinates["friction_ratio"] > 0.0
    rattles = (coordinates["mass_ratio"] > 0.0) & study.particle
    # Undamped, a transient takes as long as it is given.
    transient = TRANSIENT * ratio / np.maximum(coordinates["damping_ratio"], 1e-4)
    near_resonance = np.exp(-((np.log(ratio) / RESONANCE_WIDTH) ** 2))
    restless = np.where(rubs, near_resonance, np.minimum(1.0, ratio)) * rattles
    cycles = np.minimum(most, FEWEST_CYCLES + transient + MODULATED_SHARE * most * restless)
    per_cycle = np.where(rubs, HYBRID_CYCLE_SECONDS, PARTICLE_CYCLE_SECONDS)
    riding = np.clip(1.0 / np.maximum(coordinates["clearance_ratio"], 1e-9), 1.0, MOST_RIDING)
    stepped = cycles * np.where(rattles, per_cycle * riding, FRICTION_CYCLE_SECONDS)
    if isinstance(study.solver, Rk4Solver):
        return cycles * study.solver.steps_per_cycle * STEP_SECONDS
    starts = study.start.n if isinstance(study.start, Ensemble) else 1
    return np.where(rubs | rattles, starts * stepped, LINEAR_SECONDS)
