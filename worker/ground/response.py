"""Computes the response of a design to a record, exactly for a base acceleration that is linear between samples."""

from dataclasses import dataclass
from math import nan, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.variables import Status
from damperlab.worker.ground.design import Damper, Scale, Structure, friction_of, particle_of, scale_of
from damperlab.worker.ground.measures import GroundResponse
from damperlab.worker.solver.dwell import approach_speed
from damperlab.worker.solver.events import ARRIVED, BUDGET, COUNTS, IMPACTS
from damperlab.worker.solver.excitation.record_base import RecordBase, make_record_base, start_on_record
from damperlab.worker.solver.integrate import half_cycle
from damperlab.worker.solver.linear_motion import make_linear_motion
from damperlab.worker.solver.motion.taylor import TERMS
from damperlab.worker.solver.observe.meter import (
    ACCELERATION_PEAK,
    ACCELERATION_SQUARE,
    FRICTION_LOSS,
    IMPACT_LOSS,
    METERS,
    PARTICLE_LOSS,
    PEAK,
    RELATIVE_PEAK,
    RELATIVE_SQUARE,
    SPEED,
    SQUARE,
    STUCK,
    VISCOUS_LOSS,
    WORK_IN,
    Meter,
)
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.scene import Scene, make_loaded
from damperlab.worker.solver.segment_log import Log, Logged, empty_log, stored_rows
from damperlab.worker.solver.sliding import direction_of, rubs
from damperlab.worker.solver.state import State
from damperlab.worker.steady.response.energy import energy_residual, stored_energy

_SEGMENTS_PER_PERIOD = 2000  # largest number of events per period of the structure
_LOGGED_PER_WINDOW = 20  # initial number of rows of a time history

HISTORY_COLUMNS = (
    "time_s",
    "base_acceleration_m_s2",
    "relative_displacement_m",
    "absolute_displacement_m",
    "relative_velocity_m_s",
    "absolute_acceleration_m_s2",
    "particle_displacement_m",
)


@dataclass(frozen=True)
class Perturbation:
    """A start near rest: displacement over L, velocity over L ω_n, and position in the cavity from −1 to 1."""

    v: float = 0.0
    w: float = 0.0
    place: float = 0.0


class Ready(NamedTuple):
    """Data for all runs of one structure under one record: panels of the record, and linear motion of the structure."""

    base: RecordBase
    free: Any


def made_ready(structure: Structure, motion: GroundMotion, factor: float, tail_s: float) -> Ready:
    """Prepare the data that depend only on the structure, the record, the tail and the sign of `factor`."""
    base = make_record_base(
        (1.0 if factor > 0 else -1.0) * motion.acceleration_m_s2 / motion.peak_m_s2,
        structure.omega * motion.step_s,
        structure.damping_ratio,
        structure.omega * tail_s,
    )
    return Ready(base, make_linear_motion(base, 1.0, None))


def ground_response(
    structure: Structure,
    damper: Damper,
    motion: GroundMotion,
    factor: float = 1.0,
    tail_s: float = 0.0,
    start: Perturbation | None = None,
    ready: Ready | None = None,
) -> GroundResponse:
    """Compute the response of a design to a record.

    Parameters
    ----------
    structure, damper : Structure, Damper
        The design.
    motion : GroundMotion
        The record.
    factor : float
        Factor on the record, not equal to 0.
    tail_s : float
        Duration of the free vibration after the record [s], in which the base keeps its final velocity.
    start : Perturbation, optional
        Initial state, by default at rest.
    ready : Ready, optional
        Result of `made_ready` for the same structure, record and tail, and for a factor of the same sign. Many runs
        can share one result.

    Returns
    -------
    GroundResponse
        Measures of the response. After a numerical failure, the status states the failure and the values are NaN.
    """
    return _integrated(structure, damper, motion, factor, tail_s, start, ready, False)[0]


def ground_history(
    structure: Structure, damper: Damper, motion: GroundMotion, factor: float = 1.0, tail_s: float = 0.0
) -> tuple[GroundResponse, dict[str, NDArray[np.float64]]]:
    """Compute the response as `ground_response` does, and also return the time history.

    The history has `HISTORY_COLUMNS` at the start of every panel, at every event and at the end. Without a particle,
    the displacement of the particle is NaN.
    """
    response, history = _integrated(structure, damper, motion, factor, tail_s, None, None, True)
    assert history is not None
    return response, history


def _integrated(
    structure: Structure,
    damper: Damper,
    motion: GroundMotion,
    factor: float,
    tail_s: float,
    start: Perturbation | None,
    ready: Ready | None,
    logged: bool,
) -> tuple[GroundResponse, dict[str, NDArray[np.float64]] | None]:
    scale = scale_of(structure, motion, factor)
    friction = friction_of(damper, scale)
    particle = particle_of(damper, scale)
    ready = ready or made_ready(structure, motion, factor, tail_s)
    base = ready.base
    budget = int(_SEGMENTS_PER_PERIOD * (base.windows * base.window / (2.0 * np.pi) + 50))
    log = empty_log(_LOGGED_PER_WINDOW * base.windows) if logged else None
    while True:
        run = run_on_record(ready, friction, particle, start or Perturbation(), budget, log)
        if log is None or log.cursor[0] <= log.capacity:
            break
        log = empty_log(int(log.cursor[0]))  # the run is repeated with enough rows
    response = _measures(base, scale, particle, run)
    if log is None:
        return response, None
    return response, _history(log, base, scale, friction, particle, run.end, structure.damping_ratio)


class Run(NamedTuple):
    """A run over a record: first and last state, the outcome, the accumulated sums, and the counts of events."""

    begun: State
    end: State
    outcome: int
    sums: NDArray[np.float64]
    counts: NDArray[np.int64]


def run_on_record(
    ready: Ready,
    friction: float | None,
    particle: Particle | None,
    start: Perturbation,
    budget: int,
    log: Log | None,
) -> Run:
    """Integrate from the start of a record to its end, with at most `budget` events.

    The time history is written to `log`, unless `log` is None.
    """
    base = ready.base
    loaded = None if particle is None else make_loaded(base, particle, None)
    sums, counts = np.zeros(METERS), np.zeros(COUNTS, np.int64)
    counts[BUDGET] = budget
    scene = Scene(base, ready.free, loaded, friction, particle, np.empty((4, TERMS)), counts)
    begun = start_on_record(base, friction, particle, start.v, start.w, start.place)
    end, outcome = half_cycle(begun, scene, Meter(sums, True, True), log)
    return Run(begun, end, outcome, sums, counts)


def _measures(base: RecordBase, scale: Scale, particle: Particle | None, run: Run) -> GroundResponse:
    begun, end, outcome, sums, counts = run
    time = base.windows * base.window
    if outcome != ARRIVED:
        sums = np.full(METERS, nan)
        end = end._replace(v=nan, w=nan)
    stored = stored_energy(begun, 0.0, particle)
    residual = energy_residual(sums, stored, stored_energy(end, base.rate[-1], particle))
    read: list[float] = sums.tolist()
    length, speed, energy = scale.length_m, scale.speed_m_s, scale.energy_j
    return GroundResponse(
        peak_relative_displacement_m=read[RELATIVE_PEAK] * length,
        rms_relative_displacement_m=sqrt(read[RELATIVE_SQUARE] / time) * length,
        peak_absolute_displacement_m=read[PEAK] * length,
        rms_absolute_displacement_m=sqrt(read[SQUARE] / time) * length,
        peak_absolute_acceleration_m_s2=read[ACCELERATION_PEAK] * scale.acceleration_m_s2,
        rms_absolute_acceleration_m_s2=sqrt(read[ACCELERATION_SQUARE] / time) * scale.acceleration_m_s2,
        impacts=int(counts[IMPACTS]),
        impact_speed_max_m_s=read[SPEED] * speed,
        stick_fraction=read[STUCK] / time,
        work_in_j=read[WORK_IN] * energy,
        loss_viscous_j=read[VISCOUS_LOSS] * energy,
        loss_friction_j=read[FRICTION_LOSS] * energy,
        loss_impact_j=read[IMPACT_LOSS] * energy,
        energy_residual=float(residual),
        duration_s=time / scale.omega,
        end_relative_displacement_m=end.v * length,
        end_relative_velocity_m_s=end.w * speed,
        status=int(Status.CONVERGED) if outcome == ARRIVED else int(outcome),
        loss_particle_j=read[PARTICLE_LOSS] * energy if rubs(particle) else None,
    )


def _history(
    log: Log,
    base: RecordBase,
    scale: Scale,
    friction: float | None,
    particle: Particle | None,
    end: State,
    damping_ratio: float,
) -> dict[str, NDArray[np.float64]]:
    """Return the history columns at the start of every segment and at the end."""
    time = base.windows * base.window
    last = Logged(time, 0.0, 0.0, *end[:7], approach_speed(end.dwell), direction_of(end.slide))
    start, _, _, v, w, slip, wall, gap, _, riding, approach, slide = np.vstack((stored_rows(log), last)).T
    window = np.minimum((start / base.window + 1e-9).astype(int), base.windows - 1)
    since = start - window * base.window
    a = base.acceleration[window] + base.jerk[window] * since
    s = base.position[window] + since * (
        base.rate[window] + since * (base.acceleration[window] / 2 + base.jerk[window] * since / 6)
    )
    offset = 0.0 if friction is None else slip * friction
    inertia, push = 1.0, np.zeros(start.size)
    if particle is not None and particle.wall is None:
        inertia = 1.0 + particle.mass_ratio * (riding > 0.0)
        if particle.friction is not None:
            pull = particle.friction * slide - (particle.gravity or 0.0)
            push = np.where(riding > 0.0, 0.0, particle.mass_ratio * pull)
    elif particle is not None and particle.wall is not None:
        pressing = particle.wall.damping * approach - particle.wall.stiffness * gap
        push = np.where(riding > 0.0, wall * pressing, 0.0)
    acceleration = -(2.0 * damping_ratio * w + v + offset + push) / inertia
    if friction is not None:
        acceleration = np.where(slip == 0.0, a, acceleration)
    p = np.full(start.size, nan)
    if particle is not None:
        p = v + s - wall * (particle.clearance_ratio - gap)
    columns = (
        start / scale.omega,
        a * scale.acceleration_m_s2,
        v * scale.length_m,
        (v + s) * scale.length_m,
        w * scale.speed_m_s,
        acceleration * scale.acceleration_m_s2,
        p * scale.length_m,
    )
    return dict(zip(HISTORY_COLUMNS, columns, strict=True))
