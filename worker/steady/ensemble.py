"""Random start states at one design point, and groups of their responses."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import cos, exp, hypot, log, pi, sin

import numpy as np

from damperlab.studies.variables import ResponseClass, Status
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.state import State
from damperlab.worker.steady.response.measures import Response
from damperlab.worker.steady.start import at_rest, moving

HIGHEST = 1000.0
"""Largest amplitude of an initial state, relative to Z. At resonance, the amplitude of an undamped structure
has no bound.
"""

_SAME_AMPLITUDE = 1e-6
_SAME_ERRORS = 4.0
_UNSTEADY = (ResponseClass.MODULATED, ResponseClass.CHAOTIC)


def drawn_starts(
    n: int,
    seed: int,
    coordinates: Sequence[float],
    damping_ratio: float,
    frequency_ratio: float,
    friction: float | None,
    particle: Particle | None,
    forced: bool = False,
) -> Iterator[State]:
    """Draw the start states of one design point; the first start is at rest.

    Parameters
    ----------
    n, seed : int
        Number of starts, and the study's seed.
    coordinates : sequence of float
        The six coordinates of the point. The draw depends only on the coordinates and the seed, not on the
        division of a study into blocks. A longer ensemble begins with the starts of a shorter ensemble.
    damping_ratio, frequency_ratio, friction, particle, forced
        Parameters of `settle`.

    Yields
    ------
    State
        The mass has the displacement and velocity of u = a sin(rτ + ψ) at τ = 0, with uniformly distributed ψ
        and ln a. The lower limit of a is the amplitude of the base, or the static displacement under a force.
        The upper limit is the amplitude of the structure alone (at least 2 Z, at most `HIGHEST`). The
        position of the particle in its cavity is uniformly distributed. The velocity of the particle relative
        to the mass is uniformly distributed between −a r and a r.
    """
    yield at_rest(frequency_ratio, friction, particle, forced)
    bits = np.asarray(coordinates, dtype="<f8").view("<u8")
    random = np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, *map(int, bits)])))
    loss = 2.0 * damping_ratio * frequency_ratio
    below = hypot((1.0 - frequency_ratio) * (1.0 + frequency_ratio), loss)
    pushed = 1.0 if forced else hypot(1.0, loss)
    alone = pushed / below if below > 0.0 else HIGHEST
    most = log(min(max(alone, 2.0), HIGHEST))
    for _ in range(n - 1):
        size, turn, place, speed = random.random(4).tolist()
        a = exp(size * most)
        phase = 2.0 * pi * turn
        u_rate = a * frequency_ratio * cos(phase)
        p_rate = u_rate + (2.0 * speed - 1.0) * a * frequency_ratio if particle is not None else 0.0
        position = 2.0 * place - 1.0
        yield moving(a * sin(phase), u_rate, position, p_rate, frequency_ratio, friction, particle, forced)


def attractors(responses: Sequence[Response]) -> list[list[int]]:
    """Group the starts by their responses; the group of the most frequent response comes first.

    Each group lists indices into `responses` in increasing order. Equally frequent responses are in the order of their
    first starts. Failed responses belong to no group.

    Notes
    -----
    Periodic responses are equal if class, period and impacts per period agree, and if the amplitudes agree
    within 10⁻⁶ plus four times the error. Modulated and chaotic responses are treated as one kind, since no
    finite run distinguishes the two with certainty. Two modulated or chaotic responses are equal if the mean
    amplitudes agree within four standard errors. Responses are sorted by amplitude, and successive equal
    responses form one group. The rest positions of a locked mass form an interval and are treated as one
    response, but different motions of the particle are different responses. Mirror images agree in every
    measure and are treated as one response.
    """
    kinds: dict[tuple[int, ...], list[int]] = {}
    for index, response in enumerate(responses):
        if response.status <= Status.MAX_CYCLES:
            kinds.setdefault(_kind(response), []).append(index)
    groups: list[list[int]] = []
    for kind, members in kinds.items():
        members.sort(key=lambda index: (responses[index].amplitude_ratio, index))
        group = [members[0]]
        for before, index in pairwise(members):
            if kind[0] == ResponseClass.LOCKED or _agree(responses[before], responses[index]):
                group.append(index)
            else:
                groups.append(sorted(group))
                group = [index]
        groups.append(sorted(group))
    return sorted(groups, key=lambda group: (-len(group), group[0]))


def ensemble_values(responses: Sequence[Response]) -> dict[str, float | int]:
    """Return all variables of a design point from the responses of its starts.

    The result contains the variables of the ensemble, and the variables of the most frequent response,
    measured from the first start that leads to this response. `cycles` is the total over all starts. If every
    start failed, the response is the failed response of the first start.
    """
    found = attractors(responses)
    stored = responses[found[0][0]] if found else responses[0]
    values: dict[str, float | int] = dict(zip(Response._fields, stored, strict=True))
    values["cycles"] = sum(int(response.cycles) for response in responses)
    amplitudes = np.array([responses[index].amplitude_ratio for group in found for index in sorted(group)])
    values["attractors"] = len(found)
    for rank, name in enumerate(("attractor_share", "attractor_share_second", "attractor_share_third")):
        values[name] = len(found[rank]) / len(responses) if rank < len(found) else 0.0
    for rank, name in enumerate(("amplitude_ratio_second", "amplitude_ratio_third"), start=1):
        if rank < len(found):
            values[name] = responses[found[rank][0]].amplitude_ratio
    if found:
        values["amplitude_ratio_mean"] = float(amplitudes.mean())
        values["amplitude_ratio_spread"] = float(amplitudes.std())
        values["amplitude_ratio_worst"] = float(amplitudes.max())
    return values


def _kind(response: Response) -> tuple[int, ...]:
    if response.response_class in _UNSTEADY:
        return (int(ResponseClass.MODULATED),)
    impacts = round(response.impacts_per_cycle * response.period)
    return (int(response.response_class), int(response.period), impacts)


def _agree(one: Response, other: Response) -> bool:
    errors = _SAME_ERRORS * hypot(one.amplitude_error, other.amplitude_error)
    apart = abs(one.amplitude_ratio - other.amplitude_ratio)
    return apart <= errors + _SAME_AMPLITUDE * max(1.0, abs(one.amplitude_ratio))
