"""One design point, after its kernels are compiled."""

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
    """Compute one design point from rest.

    Parameters
    ----------
    design : Design
        The point.
    cycles : int, optional
        Stop after exactly this many excitation cycles and measure over all of them. None: continue to the steady
        response and measure that.
    history : int
        Number of last cycles in the time history.
    method : {"event", "rk4"}
        The event-driven solver, or the paper's fixed-step Runge–Kutta (needs `cycles`; gives no history).
    steps_per_cycle : int
        Steps per excitation cycle of rk4.
    settings : Settings, optional
        Criteria for the steady response; by default those of a study.
    followed : bool
        Whether to follow a steady response without a time history for a cycle, and count its events. If not, the state
        is that at phase 0, and no kernel for following is needed.

    Returns
    -------
    Simulation
        A numerical failure is reported in its status, not raised.

    Raises
    ------
    ValueError
        For rk4 without `cycles`, under a force, or for a particle with a contact time, compliant walls or friction.
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
    """Scenes that `simulate` needs for the same arguments; `followed` must be True for a steady response with a time
    history.
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
            found.append(Scene(purpose, friction, acting, design.forced))
        if is_followed(design, 0, followed):
            found.append(Scene("orbit", friction, contact, design.forced))
    else:
        found.append(Scene("transient", friction, contact, design.forced))
    return found
