"""Methods that integrate a scene: the event-driven solver and the paper's Runge–Kutta method."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from damperlab.worker.accuracy.cases import State
from damperlab.worker.accuracy.march import march_from_rest
from damperlab.worker.point import Design
from damperlab.worker.rk4 import march_rk4, march_rk4_wall
from damperlab.worker.solver.events import ARRIVED, COUNTS
from damperlab.worker.solver.observe.meter import METERS, Meter

March = Callable[[Design, int, float], State | None]
"""Function that integrates a design from rest over a number of cycles with one value of the method's setting.

The function returns the final state, or None if the method fails.
"""


@dataclass(frozen=True)
class Method:
    """A method that integrates a scene from rest.

    Parameters
    ----------
    name : str
        Name of the method in a legend.
    setting : str
        Name of the setting that is varied, for example steps per cycle; empty if the method has no setting.
    values : sequence of float
        Values of the setting, from coarse to fine.
    march : callable
        Function that integrates a scene; see `March`.
    """

    name: str
    setting: str
    values: Sequence[float]
    march: March


def _friction(design: Design) -> float | None:
    return design.friction_ratio if design.friction_ratio > 0.0 else None


def _event_state(design: Design, cycles: int, _: float) -> State | None:
    end, outcome, _counts, _measures = march_from_rest(
        design.damping_ratio, design.frequency_ratio, _friction(design), design.particle, cycles, None
    )
    return end if outcome == ARRIVED else None


def _event_all(design: Design, cycles: int, _: float) -> State | None:
    end, outcome, _counts, _measures = march_from_rest(
        design.damping_ratio,
        design.frequency_ratio,
        _friction(design),
        design.particle,
        cycles,
        Meter(np.zeros(METERS)),
    )
    return end if outcome == ARRIVED else None


def paper_march(design: Design, cycles: int, steps: float) -> State | None:
    """Integrate by the paper's fixed-step method (`damperlab.worker.rk4`). Return None if the state is not finite."""
    start = (
        design.damping_ratio,
        design.frequency_ratio,
        _friction(design),
        design.particle,
        int(steps),
        cycles,
    )
    if design.particle is not None and design.particle.wall is not None:
        end = march_rk4_wall(*start)
    else:
        end = march_rk4(*start, np.zeros(COUNTS, np.int64), np.zeros((2 * cycles + 1, 2)))
    state = tuple(float(value) for value in end)
    if not np.isfinite(state).all():
        return None
    return (state[0], state[1], state[2], state[3])


METHODS: tuple[Method, ...] = (
    Method("event, state alone", "", (0.0,), _event_state),
    Method("event, with energies and true peaks", "", (0.0,), _event_all),
    Method(
        "paper: RK4, impacts at step ends",
        "steps per cycle",
        (100, 200, 400, 800, 1600, 3200, 6400, 12_800, 25_600, 51_200),
        paper_march,
    ),
)
"""Methods in the accuracy report. The event-driven solver has no step size, so its curve is a single point."""
