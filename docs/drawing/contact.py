"""The three contact models: one impact in time, and what a contact time changes in the response."""

from math import pi
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from damperlab.service.figures.style import BLUE, GREY, VERMILION
from damperlab.studies.choices import CompliantContact
from damperlab.worker.kernel_arguments import wall_of
from damperlab.worker.point import Design, Particle
from damperlab.worker.simulate import simulate

CLEARANCE, RESTITUTION, MASS, SHOWN_TIME = 10.0, 0.47, 0.1, 0.3
COLOURS = {"instant": GREY, "dwell": BLUE, "compliant": VERMILION}


def particle_of(model: str, contact_time: float) -> Particle:
    """Give the particle of the paper's prototype with one of the contact models; the time in units of 1/ω_n."""
    one = Particle(CLEARANCE, RESTITUTION, MASS)
    if model == "dwell":
        return one._replace(contact_time=contact_time)
    if model == "compliant":
        contact = CompliantContact(model="compliant", contact_time=contact_time)
        return one._replace(wall=wall_of(contact, RESTITUTION, MASS))
    return one


def draw_contact() -> Figure:
    """Draw one impact with each model, gap over time, and the amplitude at resonance over the contact time."""
    figure = Figure(figsize=(8.0, 3.0), layout="constrained")
    left, right = figure.subplots(1, 2)
    for model in COLOURS:
        _draw_impact(left, model)
    left.axhline(0.0, color="black", lw=0.8, ls=(0, (4, 3)))
    left.set(xlabel="Time from the first touch [$1/ω_n$]", ylabel="Distance from the wall over $Z$")
    left.set(xlim=(-0.3, 0.7), ylim=(-2.2, 3.6))
    left.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, borderaxespad=0.0)
    times = np.geomspace(0.01, 0.6, 25)
    for model in ("dwell", "compliant"):
        found = [
            simulate(Design(0.0038, 1.0, 0.0, particle_of(model, float(t)))).metrics["amplitude_ratio"]
            for t in times
        ]
        right.plot(times, found, "o-", ms=3.0, color=COLOURS[model], label=model)
    instant = simulate(Design(0.0038, 1.0, 0.0, particle_of("instant", 0.0))).metrics["amplitude_ratio"]
    right.axhline(instant, color=GREY, lw=1.1, label="instant")
    right.set(xscale="log", xlabel="Contact time [$1/ω_n$]", ylabel="Amplitude ratio $X/Z$ at $r$ = 1")
    right.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, borderaxespad=0.0)
    return figure


def _draw_impact(axes: Any, model: str) -> None:
    """Draw the gap around the first impact on the upper wall in the last two cycles."""
    history = simulate(Design(0.0038, 1.0, 0.0, particle_of(model, SHOWN_TIME)), history=2).history
    gap = CLEARANCE - (history["u"] - history["p"])
    closed = np.flatnonzero((gap[1:] <= 1e-9) & (gap[:-1] > 1e-9)) + 1
    touch = next(time for time in history["time"][closed] if time > history["time"][0] + pi / 2.0)
    near = np.abs(history["time"] - touch) < 1.0
    axes.plot(history["time"][near] - touch, gap[near], color=COLOURS[model], label=model)
