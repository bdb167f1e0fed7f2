"""Results, final state and time history of one design point, computed with kernels that exist already."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import nan, pi, sqrt
from time import thread_time
from typing import Any, Literal

import numpy as np

from damperlab.studies.variables import VARIABLES, ResponseClass, Status
from damperlab.worker.kernel_arguments import rebound_of
from damperlab.worker.rk4 import march_rk4
from damperlab.worker.solver.events import ARRIVED, ATTACHMENTS, BUDGET, COUNTS, IMPACTS, TURNS
from damperlab.worker.solver.excitation.sine import base_rate_at_phase_zero
from damperlab.worker.solver.integrate import half_cycle
from damperlab.worker.solver.observe.meter import (
    FRICTION_LOSS,
    IMPACT_LOSS,
    METERS,
    PARTICLE_LOSS,
    PEAK,
    RELATIVE_PEAK,
    SPEED,
    SQUARE,
    STUCK,
    VISCOUS_LOSS,
    Meter,
)
from damperlab.worker.solver.particle import Particle, with_floats
from damperlab.worker.solver.scene import make_scene
from damperlab.worker.solver.segment_log import empty_log
from damperlab.worker.solver.sliding import rubs
from damperlab.worker.solver.time_history import HISTORY_COLUMNS, sample_half
from damperlab.worker.steady.response.closed_form import linear_response
from damperlab.worker.steady.response.energy import energy_residual, stored_energy
from damperlab.worker.steady.response.measures import Response
from damperlab.worker.steady.response.trace import cycle_peaks
from damperlab.worker.steady.settle import Settings, at_rest, settle

_SEGMENTS_PER_CYCLE = 20_000
_LOG_SEGMENTS = 100_000
_LONGEST_HISTORY = 1000


@dataclass(frozen=True)
class Design:
    """One design point.

    Parameters
    ----------
    damping_ratio, frequency_ratio : float
        Damping ratio ζ in [0, 1), and frequency ratio r > 0.
    friction_ratio : float
        Friction ratio γ_F ≥ 0.
    particle : Particle, optional
        Particle with d/Z > 0, e in [0, 1], β ≥ 0 and a contact model; None without a particle.
    forced : bool
        Whether the excitation is a force on the structure instead of a moving base. Lengths are then relative to F₀/k.
    """

    damping_ratio: float
    frequency_ratio: float
    friction_ratio: float = 0.0
    particle: Particle | None = None
    forced: bool = False

    def __post_init__(self) -> None:
        """Convert integers to floats, so that a kernel is compiled for only one type."""
        for name in ("damping_ratio", "frequency_ratio", "friction_ratio"):
            object.__setattr__(self, name, float(getattr(self, name)))
        if self.particle is not None:
            particle = with_floats(self.particle)
            particle = particle._replace(restitution=rebound_of(particle.restitution))
            object.__setattr__(self, "particle", particle)

    @property
    def base_rate(self) -> float:
        """Velocity of the base at phase 0."""
        return base_rate_at_phase_zero(self.frequency_ratio, self.forced)


@dataclass(frozen=True)
class Simulation:
    """Results for one design point.

    Attributes
    ----------
    metrics : dict
        Variables of the cube, for the steady response or for the first `cycles` cycles.
    state : dict
        Final u, u_rate, p and p_rate, absolute and relative to Z and Z ω_n; p and p_rate are None without a particle.
    events : dict
        Numbers of impacts, velocity reversals (v' = 0, including stops) and attachments; empty if no cycle of the
        steady response was integrated.
    cycles : int
        Number of cycles until the final state, from rest or along the steady response.
    history : dict of ndarray
        Time history of the last cycles (`HISTORY_COLUMNS`), empty if not requested.
    """

    metrics: dict[str, float | int]
    state: dict[str, float | None]
    events: dict[str, int]
    cycles: int
    history: dict[str, np.ndarray]


def simulate_ready(
    design: Design,
    cycles: int | None = None,
    history: int = 0,
    method: Literal["event", "rk4"] = "event",
    steps_per_cycle: int = 400,
    settings: Settings | None = None,
    followed: bool = True,
) -> Simulation:
    """Compute a design point as `simulate` does. The run time in the result includes the compilation of missing
    kernels.
    """
    began = thread_time()
    friction = design.friction_ratio if design.friction_ratio > 0.0 else None
    if method == "rk4":
        if design.forced:
            raise ValueError(
                "rk4 supports a shaken base only: leave `excitation` out, or use the event solver"
            )
        if cycles is None:
            raise ValueError("rk4 stops after a number of cycles: give `cycles`")
        one = design.particle
        if one is not None and (one.contact_time is not None or one.wall is not None or rubs(one)):
            raise ValueError(
                "rk4 supports instantaneous impacts of a particle without friction only: leave `contact_time`, `wall` and "
                "`friction` out, or use the event solver"
            )
        return _simulate_rk4(design, friction, cycles, steps_per_cycle, began)
    if cycles is not None:
        return _march(design, friction, cycles, history, None, began)
    settings = settings or Settings(4000, 0.02, 1e-9)
    acting = design.particle if design.particle is not None and design.particle.mass_ratio > 0.0 else None
    response, steady = _steady(design, friction, acting, settings)
    known = asked_of(response, settings, _has_friction(acting))
    measured = {name: _plain(number) for name, number in known.items()}
    found = measured["status"] <= Status.MAX_CYCLES
    if not is_followed(design, history, followed):
        measured["run_time"] = thread_time() - began
        return Simulation(measured, _absolute(steady, design, found), {}, 0, {})
    return _march(design, friction, max(history, 1) if found else 0, history, measured, began, steady)


def asked_of(response: Mapping[str, Any], settings: Settings, rubbing: bool) -> dict[str, Any]:
    """Return the reported measures of a response.

    Measures of the acceleration are reported only on request. Measures of the particle's friction are reported only if
    the particle has friction.
    """
    return {
        name: number
        for name, number in response.items()
        if (settings.acceleration or not VARIABLES[name].asked) and (rubbing or not VARIABLES[name].rubbing)
    }


def _has_friction(particle: Particle | None) -> bool:
    return particle is not None and particle.friction is not None and particle.friction > 0.0


def is_followed(design: Design, history: int, followed: bool) -> bool:
    """Whether to integrate the steady response for display.

    This is done on request, for a time history, and for a particle without mass.
    """
    massless = design.particle is not None and not design.particle.mass_ratio > 0.0
    return followed or history > 0 or massless


def show_orbit(design: Design) -> Simulation:
    """Integrate one cycle from rest for display. The motion is sampled but not measured."""
    friction = design.friction_ratio if design.friction_ratio > 0.0 else None
    return _march(design, friction, 1, 1, {"status": int(Status.NOT_COMPUTED)}, thread_time())


def _steady(
    design: Design, friction: float | None, acting: Particle | None, settings: Settings
) -> tuple[dict[str, Any], Any]:
    """Return the steady response and its state at phase 0. A particle without mass does not act on the structure."""
    z, r, particle = design.damping_ratio, design.frequency_ratio, design.particle
    rest = at_rest(r, friction, particle, design.forced)
    if friction is None and acting is None:
        closed = linear_response(np.array([z]), np.array([r]), design.forced)
        detuning, loss = (1.0 - r) * (1.0 + r), 2.0 * z * r
        push = 1.0 if design.forced else r * r
        scale = push / (detuning**2 + loss**2) if detuning or loss else 0.0
        v = -loss * scale
        state = rest._replace(v=v, w=r * detuning * scale, gap=_gap_of_one_at_rest(v, particle))
        return {name: column[0] for name, column in closed.items()}, state
    start = at_rest(r, friction, acting, design.forced)
    response, end = settle(z, r, friction, acting, settings, start, design.forced)
    if acting is None:
        end = rest._replace(v=end.v, w=end.w, slip=end.slip, gap=_gap_of_one_at_rest(end.v, particle))
    return dict(zip(Response._fields, response, strict=True)), end


def _gap_of_one_at_rest(v: float, particle: Particle | None) -> float:
    """Return the gap of a particle at rest, measured from the wall at u − p = +d/Z.

    The particle is in its initial position or, if the cavity no longer contains this position, in the middle of the
    cavity.
    """
    if particle is None:
        return 0.0
    return particle.clearance_ratio - (v if abs(v) < particle.clearance_ratio else 0.0)


def _plain(number: Any) -> float | int:
    return int(number) if isinstance(number, int | np.integer) else float(number)


def _march(
    design: Design,
    friction: float | None,
    cycles: int,
    history: int,
    measured: dict[str, float | int] | None,
    began: float,
    start: Any = None,
) -> Simulation:
    """Integrate a number of cycles from rest or from a given state; measure the motion, and sample the last cycles."""
    particle, r, forced = design.particle, design.frequency_ratio, design.forced
    scene = make_scene(design.damping_ratio, r, friction, particle, True, forced)
    counts = scene.counts
    counts[BUDGET] = _SEGMENTS_PER_CYCLE * (cycles + 50)
    sums = np.zeros(METERS)
    meter = None if measured else Meter(sums)  # a steady response has already been measured
    peaks = np.zeros((2 * cycles + 1, 2))
    state = at_rest(r, friction, particle, forced) if start is None else start
    stored = stored_energy(state, design.base_rate, particle)
    log = empty_log(_LOG_SEGMENTS)
    history = min(history, cycles, _LONGEST_HISTORY)
    samples: list[np.ndarray] = []
    done = 0
    outcome = ARRIVED
    for half in range(2 * cycles):
        sampled = half >= 2 * (cycles - history)
        log.cursor[0] = 0
        before = (state, counts.copy(), sums.copy()) if sampled else None
        state, outcome = half_cycle(state, scene, meter, log)
        if before is not None and log.cursor[0] > log.capacity:  # repeat the half cycle with enough rows
            log = empty_log(int(log.cursor[0]))
            state, counts[:], sums[:] = before
            state, outcome = half_cycle(state, scene, meter, log)
        if outcome != ARRIVED:
            break
        if sampled:
            samples.append(sample_half(log, scene, half))
        peaks[half + 1] = sums[PEAK], sums[RELATIVE_PEAK]
        sums[PEAK] = sums[RELATIVE_PEAK] = 0.0
        done = (half + 1) // 2
    if measured is None:
        measured = _measures(design, sums, peaks[: 2 * done + 1], counts, stored, state, done, outcome)
        measured["run_time"] = thread_time() - began
    else:
        measured["run_time"] = thread_time() - began
    columns = np.concatenate(samples, axis=1) if samples else np.empty((len(HISTORY_COLUMNS), 0))
    return Simulation(
        metrics=measured,
        state=_absolute(state, design, outcome == ARRIVED and cycles > 0),
        events={
            "impacts": int(counts[IMPACTS]),
            "turns": int(counts[TURNS]),
            "attachments": int(counts[ATTACHMENTS]),
        },
        cycles=done,
        history=dict(zip(HISTORY_COLUMNS, columns, strict=True)) if samples else {},
    )


def _absolute(state: Any, design: Design, known: bool) -> dict[str, float | None]:
    """Return a state at phase 0 in absolute coordinates; NaN if the state is unknown."""
    end: dict[str, float | None] = {
        "u": state.v if known else nan,
        "u_rate": state.w + design.base_rate if known else nan,
        "p": None,
        "p_rate": None,
    }
    if (particle := design.particle) is not None:
        behind = state.wall * (particle.clearance_ratio - state.gap)
        end["p"] = state.v - behind if known else nan
        end["p_rate"] = state.p_rate if known else nan
    return end


def _measures(
    design: Design,
    sums: np.ndarray,
    peaks: np.ndarray,
    counts: np.ndarray,
    stored: float,
    state: Any,
    cycles: int,
    outcome: int,
) -> dict[str, float | int]:
    """Return the variables of the cube for complete cycles of a transient."""
    if outcome != ARRIVED or cycles == 0:
        status = outcome if outcome != ARRIVED else int(Status.NOT_COMPUTED)
        return {"cycles": cycles, "status": status}
    time = 2.0 * pi * cycles / design.frequency_ratio
    losses = sums[VISCOUS_LOSS] + sums[FRICTION_LOSS] + sums[IMPACT_LOSS] + sums[PARTICLE_LOSS]
    share = 1.0 / losses if losses > 0.0 else 0.0
    sums[PEAK], sums[RELATIVE_PEAK] = peaks.max(axis=0)  # over all cycles, not only the last half cycle
    end = stored_energy(state, design.base_rate, design.particle)
    residual = energy_residual(sums, stored, end)
    return {
        **_mean_peaks(peaks),
        "amplitude_ratio_max": float(peaks[:, 0].max()),
        "amplitude_ratio_rms": sqrt(2.0 * sums[SQUARE] / time),
        "amplitude_error": nan,  # no steady amplitude is estimated
        "energy_residual": float(residual),
        "response_class": int(ResponseClass.UNKNOWN),
        "period": 0,
        "floquet_multiplier": nan,
        "impacts_per_cycle": float(counts[IMPACTS] / cycles),
        "impact_speed_max": float(sums[SPEED]),
        "stick_fraction": float(sums[STUCK] / time),
        "dissipation_per_cycle": float(losses / cycles),
        "dissipation_viscous": float(sums[VISCOUS_LOSS] * share),
        "dissipation_friction": float(sums[FRICTION_LOSS] * share),
        "dissipation_impact": float(sums[IMPACT_LOSS] * share),
        **(
            {"dissipation_particle": float(sums[PARTICLE_LOSS] * share)}
            if _has_friction(design.particle)
            else {}
        ),
        "cycles": cycles,
        "status": int(Status.MAX_CYCLES),
    }


def _mean_peaks(peaks: np.ndarray) -> dict[str, float | int]:
    """Return mean peaks over intervals of one cycle that begin at every half cycle. Row 0 of `peaks` is ignored."""
    of_cycles = np.empty((2, len(peaks) // 2))
    cycle_peaks(peaks, len(peaks) - 1, of_cycles)
    displacement, relative = of_cycles.mean(axis=1)
    return {"amplitude_ratio": float(displacement), "relative_amplitude_ratio": float(relative)}


def _simulate_rk4(
    design: Design, friction: float | None, cycles: int, steps_per_cycle: int, began: float
) -> Simulation:
    counts = np.zeros(COUNTS, np.int64)
    peaks = np.zeros((2 * cycles + 1, 2))
    u, u_rate, p, p_rate = march_rk4(
        design.damping_ratio,
        design.frequency_ratio,
        friction,
        design.particle,
        steps_per_cycle,
        cycles,
        counts,
        peaks,
    )
    bounded = bool(np.isfinite(peaks).all())
    metrics: dict[str, float | int] = {
        **_mean_peaks(peaks),
        "amplitude_ratio_max": float(peaks[:, 0].max()),
        "impacts_per_cycle": float(counts[IMPACTS] / cycles),
        "cycles": cycles,
        "status": int(Status.MAX_CYCLES if bounded else Status.UNBOUNDED),
        "run_time": thread_time() - began,
    }
    without = design.particle is None
    return Simulation(
        metrics=metrics,
        state={"u": u, "u_rate": u_rate, "p": None if without else p, "p_rate": None if without else p_rate},
        events={"impacts": int(counts[IMPACTS]), "turns": int(counts[TURNS]), "attachments": 0},
        cycles=cycles,
        history={},
    )
