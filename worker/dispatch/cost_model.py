"""Expected computing time of design points. Blocks are planned to take about equal times, and the longest start first.

A rough model is sufficient, because the expected times affect only the sizes and the order of blocks, not the results.
`family_factor` corrects an estimate by measured times of earlier studies. The time of a point is the number of cycles
until the response counts as steady, times the kernel's time per cycle.

The constants were fitted to measured run times on eight grids of particle and hybrid scenes (ζ 0.001 … 0.1, β 0.02 …
0.3, d/Z 0.2 … 40, γ 0 … 1.2, r 0.5 … 3). On other grids, expected and measured total times mostly agree within a factor
of four. The times of single points scatter by a factor of ten, especially where periodic and modulated responses are
neighbours.
"""

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.choices import CompliantContact, Ensemble, Rk4Solver
from damperlab.studies.definition import Study
from damperlab.studies.ground.suite import Suite, windows_of
from damperlab.studies.kind import AnyStudy
from damperlab.studies.plan import plan_with_chunk
from damperlab.studies.store.cube.definition import DefinitionDamaged, parse_stored
from damperlab.studies.store.record import Record

LINEAR_SECONDS = 2e-6
"""Time to compute a point from the closed-form solution and to store it [s]."""
FRICTION_CYCLE_SECONDS, PARTICLE_CYCLE_SECONDS, HYBRID_CYCLE_SECONDS = 0.8e-6, 1.4e-6, 2.0e-6
"""Time to compute an excitation cycle with friction, with a particle, and with both, if the clearance is wide [s]."""
COMPLIANT_TIMES = 4.5
"""Factor by which compliant walls increase the time per cycle."""
RUN_SECONDS, RECORD_WINDOW_SECONDS = 5e-5, 0.15e-6
"""Fixed part of the time of a run under a ground-motion record, and the additional time for each panel [s]. Both were
measured on built-in records, at natural frequencies from 1 to 50 Hz.
"""
STEP_SECONDS = 0.04e-6
"""Time of one step of the fixed-step method in every scene [s]."""
MOST_RIDING, RIDING_CLEARANCE = 9.1, 1.8
"""In a short cavity, a cycle takes longer to compute, because the particle chatters and rests on a wall. The factor is
1 + `MOST_RIDING` exp(−clearance_ratio/`RIDING_CLEARANCE`).
"""
FEWEST_CYCLES = 40.0
"""Average number of cycles until a response far from resonance counts as steady."""
TRANSIENT = 0.073
"""Number of cycles of a transient, divided by r/ζ. A transient decays as exp(−ζτ), and a cycle lasts 2π/r."""
RESTLESS_CYCLES, RESTLESS_TOLERANCE, FEWEST_RESTLESS = 1050.0, 0.02, 768.0
"""Cycles near resonance, where only statistics converge: the mean number at the tolerance
`RESTLESS_TOLERANCE`, this tolerance, and the smallest number at any tolerance. The relative error of a mean
is proportional to 1/√(cycles) (`steady/response/standard_errors.py`).
"""
RESTLESS_WIDTH, RESTLESS_POWER = 0.0104, 0.55
"""Two constants for the range around resonance in which only statistics converge: the half-width of the range in ln r
at β = ζ, and the exponent of β/ζ with which the half-width grows.
"""
NARROWEST = 0.004
"""Smallest half-width in ln r of the range around resonance in which only statistics converge."""
BREAKAWAY = 0.785
"""Friction ratio (π/4) above which friction dissipates more energy at resonance than the base supplies."""


def seconds_per_point(study: AnyStudy, coordinates: dict[str, NDArray[Any]]) -> NDArray[np.float64]:
    """Return the expected kernel time of each design point.

    Parameters
    ----------
    study : Study or Suite
        The study. Its scene, solver, starts, records, `steady.max_cycles` and `steady.tolerance` are used.
    coordinates : dict of ndarray
        Coordinates of the N points by dimension, N values each.

    Returns
    -------
    ndarray
        N expected times [s], all above 0.
    """
    if isinstance(study, Suite):
        return _suite(study, coordinates)
    if isinstance(study, Study):
        return _harmonic(study, coordinates)
    raise TypeError(f"there is no cost model for a {type(study).__name__}")


def family_factor(earlier: Iterable[Record]) -> float | None:
    """Return the ratio of measured to expected kernel time over earlier studies of one family (`family_digest`).

    Parameters
    ----------
    earlier : iterable of Record
        Records of the studies, see `damperlab.studies.store.reuse.done_of_family`.

    Returns
    -------
    float or None
        Sum of the measured times divided by the sum of the expected times. None if the studies have no computed point.
    """
    taken = expected = 0.0
    for record in earlier:
        try:
            study = parse_stored(record.definition, record.digest)
        except (DefinitionDamaged, ValueError):
            # a study with a damaged definition is skipped here; a query for the study reports the error
            continue
        # reused points took no kernel time
        share = (record.points_done - record.points_reused) / record.points_total
        taken += record.kernel_seconds
        expected += share * plan_with_chunk(study, record.chunk, seconds_per_point).seconds
    return taken / expected if expected > 0.0 and 0.0 < taken < math.inf else None


def _suite(study: Suite, coordinates: dict[str, NDArray[Any]]) -> NDArray[np.float64]:
    tail = study.numbers["tail_s"]
    frequency = coordinates["natural_frequency_hz"]
    windows = np.empty(frequency.size)
    for source in study.records:
        under = coordinates["record"] == source.id
        windows[under] = windows_of(source, frequency[under], tail)
    return (1 + study.starts) * (RUN_SECONDS + RECORD_WINDOW_SECONDS * windows)


def _harmonic(study: Study, coordinates: dict[str, NDArray[np.float64]]) -> NDArray[np.float64]:
    coordinates = dict(study.ratios(coordinates))
    most = float(study.steady.max_cycles)
    ratio = coordinates["frequency_ratio"]
    rubs = coordinates["friction_ratio"] > 0.0
    rattles = (coordinates["mass_ratio"] > 0.0) & study.particle
    # The bound prevents a division by zero. Without damping, a transient lasts until the limit of cycles.
    damping = np.maximum(coordinates["damping_ratio"], 1e-4)
    moving = np.clip(1.0 - (coordinates["friction_ratio"] / BREAKAWAY) ** 2, 0.0, 1.0)
    width = RESTLESS_WIDTH * moving * (coordinates["mass_ratio"] / damping) ** RESTLESS_POWER
    restless = np.exp(-((np.log(ratio) / np.maximum(width, NARROWEST)) ** 2)) * rattles * (moving > 0.0)
    settling = max(FEWEST_RESTLESS, RESTLESS_CYCLES * (RESTLESS_TOLERANCE / study.steady.tolerance) ** 2)
    # mean number for steady and unsteady points; `steady.max_cycles` limits both
    cycles = np.minimum(most, FEWEST_CYCLES + TRANSIENT * ratio / damping + min(most, settling) * restless)
    per_cycle = np.where(rubs, HYBRID_CYCLE_SECONDS, PARTICLE_CYCLE_SECONDS)
    riding = 1.0 + MOST_RIDING * np.exp(-coordinates["clearance_ratio"] / RIDING_CLEARANCE)
    contact = COMPLIANT_TIMES if isinstance(study.contact, CompliantContact) else 1.0
    stepped = cycles * np.where(rattles, contact * per_cycle * riding, FRICTION_CYCLE_SECONDS)
    if isinstance(study.solver, Rk4Solver):
        return cycles * study.solver.steps_per_cycle * STEP_SECONDS
    starts = study.start.n if isinstance(study.start, Ensemble) else 1
    return np.where(rubs | rattles, starts * stepped, LINEAR_SECONDS)
