"""What each class of response looks like: its motion in time, and the orbit that it draws in the phase plane."""

from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from damperlab.service.figures.style import BLUE, GREY, VERMILION
from damperlab.studies.variables import ResponseClass
from damperlab.worker.point import Design, Particle
from damperlab.worker.simulate import simulate

TIMED, SECTION = 6, 400
"""Cycles drawn over time; cycles whose state at the beginning is a dot in the phase plane."""


@dataclass(frozen=True)
class Example:
    """A design whose response is of one class.

    Parameters
    ----------
    design : Design
        What is simulated from rest to its steady response.
    response_class : ResponseClass
        What the solver calls it; drawing anything else is refused.
    timed : int
        Excitation cycles drawn over time.
    """

    design: Design
    response_class: ResponseClass
    timed: int = TIMED


def _hybrid(clearance: float, friction: float, frequency: float) -> Design:
    return Design(0.0038, frequency, friction, Particle(clearance, 0.47, 0.1))


EXAMPLES = {
    "linear": Example(Design(0.0038, 0.9), ResponseClass.LINEAR),
    "locked": Example(_hybrid(5.0, 1.2, 1.0), ResponseClass.LOCKED),
    "no-impact": Example(_hybrid(5.0, 0.4, 1.16), ResponseClass.NO_IMPACT),
    "symmetric": Example(_hybrid(10.0, 0.0, 1.0), ResponseClass.SYMMETRIC),
    "asymmetric": Example(_hybrid(2.0, 0.6, 1.1), ResponseClass.ASYMMETRIC),
    "subharmonic": Example(_hybrid(5.0, 0.43, 0.98), ResponseClass.SUBHARMONIC),
    "modulated": Example(_hybrid(10.0, 0.2, 0.95), ResponseClass.MODULATED, 30),
    "chaotic": Example(_hybrid(5.0, 0.4, 1.0), ResponseClass.CHAOTIC, 20),
}
"""One design of each class, by the name of its figure."""


def draw_class(name: str) -> Figure:
    """Draw the motion of a class beside its orbit.

    Parameters
    ----------
    name : str
        One of `EXAMPLES`.

    Raises
    ------
    ValueError
        Where the response is of another class.
    """
    example = EXAMPLES[name]
    answer = simulate(example.design, history=SECTION)
    if (found := ResponseClass(answer.metrics["response_class"])) is not example.response_class:
        raise ValueError(f"{name}: the solver says {found.name}; choose another design")
    figure = Figure(figsize=(8.0, 2.7), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(2.2, 1.0))
    _draw_time(left, example, answer.history)
    _draw_orbit(right, example, answer.history)
    return figure


def _draw_time(axes: Any, example: Example, history: dict[str, Any]) -> None:
    period = 2.0 * pi / example.design.frequency_ratio
    shown = history["time"] >= history["time"][-1] - example.timed * period
    cycles = (history["time"][shown] - history["time"][shown][0]) / period
    mass = history["u"][shown]
    particle = example.design.particle
    if particle is not None:
        low, high = mass - particle.clearance_ratio, mass + particle.clearance_ratio
        axes.fill_between(cycles, low, high, color=GREY, alpha=0.18, lw=0, label="cavity")
        axes.plot(cycles, history["p"][shown], color=VERMILION, lw=0.8, label="particle $y/Z$")
    axes.plot(cycles, mass - history["v"][shown], color=GREY, lw=0.8, label="base $z/Z$")
    axes.plot(cycles, mass, color=BLUE, label="mass $x/Z$")
    axes.set(xlabel="Time in excitation cycles", ylabel="Displacement over $Z$")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.margins(x=0.0)
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4, borderaxespad=0.0, columnspacing=1.2)


def _draw_orbit(axes: Any, example: Example, history: dict[str, Any]) -> None:
    """Draw two cycles of the orbit, or of one that never closes the dots alone: they show what it comes back to."""
    period = 2.0 * pi / example.design.frequency_ratio
    time, v, rate = history["time"], history["v"], history["v_rate"]
    turns = (time - time[0]) / period
    if example.timed == TIMED:
        drawn = turns >= turns[-1] - 2.0
        axes.plot(v[drawn], rate[drawn], color=BLUE, lw=1.0)
    begins = np.abs(turns - np.round(turns)) < 1e-9
    _, first = np.unique(np.round(turns[begins]), return_index=True)
    once = np.column_stack([v[begins][first], rate[begins][first]])
    if example.timed == TIMED:
        once = np.unique(once.round(3), axis=0)
    size = 3.5 if example.timed == TIMED else 1.6
    axes.plot(*once.T, "o", color=VERMILION, ms=size, mew=0, label="once a cycle")
    axes.set(xlabel="$(x - z)/Z$", ylabel="velocity over $Zω_n$")
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.0, handletextpad=0.1)
