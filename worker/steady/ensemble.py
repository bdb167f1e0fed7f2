"""An ensemble of starts at one design point: how they are drawn, and the responses that they lead to."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import cos, exp, hypot, log, pi, sin

import numpy as np

from damperlab.studies.variables import ResponseClass, Status
from damperlab.worker.solver.excitation.sine_base import Forced
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.state import State
from damperlab.worker.steady.response.measures import Response
from damperlab.worker.steady.start import at_rest, moving

HIGHEST = 1000.0
"""Largest amplitude drawn, over Z, because the response of the structure alone is unbounded without damping at
resonance.
"""

_SAME_AMPLITUDE = 1e-6
_SAME_ERRORS = 4.0
_UNSTEADY = (ResponseClass.MODULATED, ResponseClass.CHAOTIC)


def drawn_starts(
    n: int,
    seed: int,
    coordinates: Sequence[float],
    damping_ratio: float,
    excitation: float | Forced,
    friction: float | None,
    particle: Particle | None,
) -> Iterator[State]:
    """Start states of one design point, the first at rest.

    Parameters
    ----------
    n, seed : int
        Number of starts, and the study's seed.
    coordinates : sequence of float
        The six coordinates of the point. The draw depends only on them and the seed, so it is the same in every block,
        order and study. A longer ensemble begins with the starts of a shorter one.
    damping_ratio, excitation, friction, particle
        As for `settle`, whose `frequency_ratio` is the `excitation`.

    Yields
    ------
    State
        The mass moves as in a harmonic motion u = a sin(rτ + ψ) at τ = 0, with ψ uniform. ln a is uniform. The lower
        limit of a is the amplitude of the base, or the static displacement under a force. The upper limit is the
        amplitude of the structure alone (at least 2 Z, at most `HIGHEST`). The particle is anywhere in its cavity,
        uniformly, with a velocity relative to the mass that is uniform within ± a r.
    """
    yield at_rest(excitation, friction, particle)
    forced = isinstance(excitation, Forced)
    frequency_ratio = excitation.frequency_ratio if isinstance(excitation, Forced) else excitation
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
        yield moving(a * sin(phase), u_rate, 2.0 * place - 1.0, p_rate, excitation, friction, particle)


def attractors(responses: Sequence[Response]) -> list[list[int]]:
    """Group starts by their responses, the most frequent response first; equally frequent ones are in the order of
    their first start.

    Parameters
    ----------
    responses : sequence of Response
        One per start; failed ones belong to no group.

    Returns
    -------
    list of list of int
        Indices into `responses`, each group in increasing order.

    Notes
    -----
    Periodic responses are equal if class, period and impacts per period agree, and the amplitudes within 10⁻⁶ and four
    of their errors. Modulated and chaotic responses count as one kind, since no finite run distinguishes the two for
    certain. They are equal if their means agree within four standard errors, also through a chain of neighbours. Locked
    rest positions form an interval and are one response, unless a particle keeps moving between the walls in a
    different way. Mirror images agree in every measure, so they count as one response.
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
    """Every variable of a design point from the responses of its starts.

    Parameters
    ----------
    responses : sequence of Response
        One per start.

    Returns
    -------
    dict
        The response that most starts lead to, as measured from the first of these starts, and the variables of the
        ensemble. `cycles` is the total over all starts. If every start failed, the response is the failed one of the
        first start.
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
