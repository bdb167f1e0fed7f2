"""Expected cost of a design point, so that blocks take about equal time and the longest start first.

A rough model is sufficient: it affects the sizes and order of blocks, never a result, and a factor from earlier studies
of the family corrects it. The cost is the number of cycles until the response is known to be steady, times the seconds
per cycle of the scene's kernel. Its constants were fitted to measured run times over eight grids of particle and hybrid
scenes (ζ 0.001 … 0.1, β 0.02 … 0.3, d/Z 0.2 … 40, γ 0 … 1.2, r 0.5 … 3). Sums over other grids mostly agree within a
factor of four; single points scatter by a factor of ten, especially between periodic and modulated neighbours.
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
"""Time of a point in closed form, including storing [s]."""
FRICTION_CYCLE_SECONDS, PARTICLE_CYCLE_SECONDS, HYBRID_CYCLE_SECONDS = 0.8e-6, 1.4e-6, 2.0e-6
"""Time of one excitation cycle with its events, for a wide clearance [s]."""
COMPLIANT_TIMES = 4.5
"""Factor of the time of a cycle if the walls are compliant."""
RUN_SECONDS, RECORD_WINDOW_SECONDS = 5e-5, 0.15e-6
"""Time of one run under a record: a fixed part, and a part for each panel [s]. Measured on built-in records, at natural
frequencies from 1 to 50 Hz.
"""
STEP_SECONDS = 0.04e-6
"""Time of one step of the fixed-step method, for any scene [s]."""
MOST_RIDING, RIDING_CLEARANCE = 9.1, 1.8
"""In a short cavity the particle chatters and stays on a wall, and a cycle takes up to 1 + `MOST_RIDING` times as long.
The excess falls as exp(−clearance_ratio/`RIDING_CLEARANCE`).
"""
FEWEST_CYCLES = 40.0
"""Average number of cycles until a response counts as steady, far from resonance."""
TRANSIENT = 0.073
"""Cycles of a transient, in units of r/ζ: it decays as exp(−ζτ), and a cycle lasts 2π/r."""
RESTLESS_CYCLES, RESTLESS_TOLERANCE, FEWEST_RESTLESS = 1050.0, 0.02, 768.0
"""Mean number of cycles near resonance, where impacts never cease and only statistics converge; the tolerance for which
it applies; and the least number. The relative error of a mean falls as the inverse root of its cycles
(`steady/response/standard_errors.py`).
"""
RESTLESS_WIDTH, RESTLESS_POWER = 0.0104, 0.55
"""Distance from resonance, in ln r, up to which only statistics converge: the width at β = ζ, and the power of β/ζ with
which it scales.
"""
NARROWEST = 0.004
"""Smallest width of the range around resonance in which only statistics converge."""
BREAKAWAY = 0.785
"""Friction ratio at which friction suppresses a resonance: from π/4 on it dissipates more energy than the base
supplies.
"""


def seconds_per_point(study: AnyStudy, coordinates: dict[str, NDArray[Any]]) -> NDArray[np.float64]:
    """Kernel seconds that design points are expected to take.

    Parameters
    ----------
    study : Study
        Only the scene, the starts, the records, `steady.max_cycles` and `steady.tolerance` matter.
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


def family_factor(earlier: Iterable[Record]) -> float | None:
    """Give the ratio of measured to expected time of studies of a family; None if no point has been computed.

    Parameters
    ----------
    earlier : iterable of Record
        From `damperlab.studies.store.reuse.family.done_of_family`.
    """
    taken = expected = 0.0
    for record in earlier:
        try:
            study = parse_stored(record.definition, record.digest)
        except (DefinitionDamaged, ValueError):
            # errors of other studies are reported by their own queries
            continue
        # reused points took no time
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
    # Without damping, a transient lasts until the limit.
    damping = np.maximum(coordinates["damping_ratio"], 1e-4)
    moving = np.clip(1.0 - (coordinates["friction_ratio"] / BREAKAWAY) ** 2, 0.0, 1.0)
    width = RESTLESS_WIDTH * moving * (coordinates["mass_ratio"] / damping) ** RESTLESS_POWER
    restless = np.exp(-((np.log(ratio) / np.maximum(width, NARROWEST)) ** 2)) * rattles * (moving > 0.0)
    settling = max(FEWEST_RESTLESS, RESTLESS_CYCLES * (RESTLESS_TOLERANCE / study.steady.tolerance) ** 2)
    # an average over points that settle and points that continue; the limit applies to either kind
    cycles = np.minimum(most, FEWEST_CYCLES + TRANSIENT * ratio / damping + min(most, settling) * restless)
    per_cycle = np.where(rubs, HYBRID_CYCLE_SECONDS, PARTICLE_CYCLE_SECONDS)
    riding = 1.0 + MOST_RIDING * np.exp(-coordinates["clearance_ratio"] / RIDING_CLEARANCE)
    contact = COMPLIANT_TIMES if isinstance(study.contact, CompliantContact) else 1.0
    stepped = cycles * np.where(rattles, contact * per_cycle * riding, FRICTION_CYCLE_SECONDS)
    if isinstance(study.solver, Rk4Solver):
        return cycles * study.solver.steps_per_cycle * STEP_SECONDS
    starts = study.start.n if isinstance(study.start, Ensemble) else 1
    return np.where(rubs | rattles, starts * stepped, LINEAR_SECONDS)
