"""Computation of one design point, with compilation of missing kernels."""

from typing import Literal

from damperlab.worker.point import Design, Simulation, is_followed, simulate_ready
from damperlab.worker.scenes import Purpose, Scene, contact_name
from damperlab.worker.steady.settle import Settings
from damperlab.worker.warm import warm


def simulate(
    design: Design,
    cycles: int | None = None,
    history: int = 0,
    method: Literal["event", "rk4"] = "event",
    steps_per_cycle: int = 400,
    settings: Settings | None = None,
    followed: bool = True,
) -> Simulation:
    """Compute a design point from rest.

    Parameters
    ----------
    design : Design
        The design point.
    cycles : int, optional
        Number of cycles to integrate and measure. By default, the steady response is computed and measured.
    history : int
        Number of last cycles in the time history.
    method : {"event", "rk4"}
        Event-driven solver, or the paper's fixed-step Runge–Kutta, which requires `cycles` and returns no time history.
    steps_per_cycle : int
        Number of steps per cycle for rk4.
    settings : Settings, optional
        Criteria for a steady response, by default the criteria of a study.
    followed : bool
        Whether to integrate one cycle of the steady response and count its events, even without a time history. If
        False, the final state is the state at phase 0, and the kernels for that cycle are not needed.

    Returns
    -------
    Simulation
        Result of the point. The status reports numerical failures, which raise no exception.

    Raises
    ------
    ValueError
        If `method` is rk4 without `cycles`, under a force, or for a particle with contact time, compliant walls or
        friction.
    """
    for scene in scenes_of(design, cycles, method, settings, followed or history > 0):
        warm(scene)
    return simulate_ready(design, cycles, history, method, steps_per_cycle, settings, followed)


def scenes_of(
    design: Design,
    cycles: int | None = None,
    method: Literal["event", "rk4"] = "event",
    settings: Settings | None = None,
    followed: bool = True,
) -> list[Scene]:
    """Return the scenes that `simulate` needs for the given arguments.

    If a time history of the steady response is requested, `followed` must be True.
    """
    friction, contact = design.friction_ratio > 0.0, contact_name(design.particle)
    if method == "rk4":
        return [Scene("rk4", friction, contact)]
    found = []
    if cycles is None:
        acting = contact if design.particle is not None and design.particle.mass_ratio > 0.0 else ""
        if friction or acting:
            purpose: Purpose = "steady" if settings is None or settings.energies else "peaks"
            if settings is not None and settings.acceleration:
                purpose = "acceleration"
            found.append(Scene(purpose, friction, acting))
        if is_followed(design, 0, followed):
            found.append(Scene("orbit", friction, contact))
    else:
        found.append(Scene("transient", friction, contact))
    return found
