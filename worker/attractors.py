"""The steady responses of a design point from many starts, and whether rounding of the start decides between them."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import copysign

import numpy as np

from damperlab.studies.variables import ResponseClass, Status
from damperlab.worker.point import Design
from damperlab.worker.simulate import scenes_of
from damperlab.worker.solver.state import State
from damperlab.worker.steady.ensemble import attractors, drawn_starts
from damperlab.worker.steady.response.closed_form import linear_response
from damperlab.worker.steady.response.measures import Response
from damperlab.worker.steady.settle import Settings, at_rest, settle
from damperlab.worker.warm import warm

NUDGES = (1, -1, 2, -2)
"""Relative changes of the rest state, in units of `NUDGE`.

The changed quantity is the velocity relative to the base or, under a force, the gap of the particle.
"""

NUDGE = 2.0**-46
"""Smallest relative change of a start: about 64 rounding errors, far below any measurable difference."""


@dataclass(frozen=True)
class Attractor:
    """A steady response, and the number of starts that lead to it.

    Attributes
    ----------
    starts : int
        Number of drawn starts that lead to the response, including rest.
    response : Response
        Response, measured from the first start that leads to it.
    from_rest, from_next_to_rest : bool
        Whether rest leads to the response, and whether a start near rest (`NUDGES`) leads to it.
    """

    starts: int
    response: Response
    from_rest: bool
    from_next_to_rest: bool


@dataclass(frozen=True)
class Attractors:
    """The different steady responses of one design point.

    Attributes
    ----------
    starts, failed : int
        Number of drawn starts, and number of starts whose run failed.
    met : list of Attractor
        Different responses, in descending order of `starts`.
    """

    starts: int
    failed: int
    met: list[Attractor]

    @property
    def by_a_rounding(self) -> bool:
        """Whether a start that differs from rest only by rounding leads to a different response."""
        return any(one.from_next_to_rest and not one.from_rest for one in self.met)

    @property
    def sentence(self) -> str:
        """Text that summarises the responses."""
        if not self.met:
            return f"All {self.starts} starts failed."
        drawn = self.starts - self.failed
        if len(self.met) == 1:
            return f"All {drawn} starts lead to one response."
        shares = ", ".join(
            f"{one.starts} to {ResponseClass(int(one.response.response_class)).name.lower()} "
            f"X/Z = {one.response.amplitude_ratio:.6g}"
            for one in self.met
        )
        last = (
            " A start that differs from rest only by rounding leads to another response than rest."
            if self.by_a_rounding
            else " The start decides between them."
        )
        if unsettled := sum(one.response.status == Status.MAX_CYCLES for one in self.met):
            last = (
                f" {unsettled} of these responses had not settled at the limit on cycles or events, and may still "
                "become another response."
            )
        return f"{drawn} starts lead to {len(self.met)} responses: {shares}.{last}"


def find_attractors(design: Design, starts: int, seed: int, settings: Settings) -> Attractors:
    """Find the steady responses of one design point from rest, from random states, and from states near rest.

    Parameters
    ----------
    design : Design
        The design point.
    starts, seed : int
        Number of starts, and seed for drawing them, as in an ensemble study. The first start is rest.
    settings : Settings
        Criteria for a steady response.
    """
    friction = design.friction_ratio if design.friction_ratio > 0.0 else None
    particle = design.particle if design.particle is not None and design.particle.mass_ratio > 0.0 else None
    z, r = design.damping_ratio, design.frequency_ratio
    of_particle = (0.0, 0.0, 0.0)
    if particle is not None:
        of_particle = (particle.restitution, particle.mass_ratio, particle.clearance_ratio)
    place = (z, *of_particle, design.friction_ratio, r)
    if friction is None and particle is None:
        closed = linear_response(np.array([z]), np.array([r]), design.forced)
        response = Response(**{name: column[0].item() for name, column in closed.items()})
        return Attractors(starts, 0, [Attractor(starts, response, from_rest=True, from_next_to_rest=True)])
    for scene in scenes_of(design, settings=settings):
        warm(scene)
    drawn = list(drawn_starts(starts, seed, place, z, r, friction, particle, design.forced))
    every = drawn + list(_next_to(at_rest(r, friction, particle, design.forced)))
    responses = [settle(z, r, friction, particle, settings, start, design.forced)[0] for start in every]
    met = []
    for group in attractors(responses):
        members = [index for index in group if index < starts]
        near = any(index >= starts for index in group)
        met.append(Attractor(len(members), responses[group[0]], 0 in group, near))
    failed = sum(response.status > Status.MAX_CYCLES for response in responses[:starts])
    return Attractors(starts, failed, sorted(met, key=lambda one: -one.starts))


def _next_to(rest: State) -> Iterator[State]:
    for times in NUDGES:
        # under a force the base does not move, so only the gap of a particle can change
        if rest.w == 0.0:
            if rest.gap > 0.0:
                yield rest._replace(gap=rest.gap * (1.0 + times * NUDGE))
            continue
        w = copysign(abs(rest.w) * (1.0 + times * NUDGE), rest.w)
        p_rate = (
            rest.p_rate if rest.slide is None else rest.p_rate + (w - rest.w)
        )  # the particle moves with the structure
        yield rest._replace(w=w, p_rate=p_rate)
