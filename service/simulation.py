"""Computes simulations of single design points, and writes the results as documents."""

import math
from collections.abc import Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, NotRequired

import numpy as np
from numpy.typing import NDArray
from typing_extensions import TypedDict

from damperlab.service.motions import FORCES
from damperlab.service.simulation_request import Asked
from damperlab.studies.faults import counted
from damperlab.studies.shapes import Count, Like, Number, Numbers, Says, Table
from damperlab.studies.variables import VARIABLES, ResponseClass, Status, Variable
from damperlab.worker.scenes import Scene

if TYPE_CHECKING:
    # at run time, these modules are imported only inside functions, because they import the compiler
    from damperlab.worker.attractors import Attractors
    from damperlab.worker.point import Simulation
    from damperlab.worker.steady.settle import Settings as Steadiness

Columns = Annotated[dict[str, NDArray[np.float64]], Like(dict[str, Numbers])]
"""Type of a time history: its columns by name."""
STEADY_CYCLES = 4000
"""Largest number of excitation cycles in the search for a steady response."""
SETTLED = 0.01
"""Fraction to which a disturbance must decay before a response counts as settled."""


def _measured(variable: Variable) -> dict[str, Any]:
    return {
        "type": ["number", "null"] if variable.flags is None else "integer",
        "description": f"{variable.long_name} [{variable.units}]",
    }


class Met(TypedDict):
    """Responses reached from several initial states."""

    starts: Count
    failed: Count
    decided_by_a_rounding: bool
    met: list[Table]
    note: str


class SimulatedDocument(TypedDict):
    """Result of a simulation of one design point."""

    metrics: Annotated[
        dict[str, float | int],
        Like(dict[str, Any]),
        Says(properties={name: _measured(variable) for name, variable in VARIABLES.items()}),
    ]
    status: str
    response_class: str
    state: dict[str, Number]
    events: dict[str, Count]
    cycles: Count
    history: Columns
    forces: NotRequired[
        Annotated[
            Columns,
            Says(
                propertyNames={"enum": list(FORCES)},
                description="Forces on the structure, divided by k·Z, at the samples of the history. Forces of "
                "instantaneous impacts are not included.",
            ),
        ]
    ]
    spectrum: NotRequired[
        Annotated[
            Columns,
            Says(
                propertyNames={"enum": ["multiple", "amplitude"]},
                description="Amplitudes of u, divided by Z, at multiples of the excitation frequency, computed "
                "from all complete cycles.",
            ),
        ]
    ]
    settles_after_cycles: NotRequired[Number]
    attractors: NotRequired[Met]
    wall: NotRequired[dict[str, Number]]


def compute(asked: Asked, cycles_limit: int) -> SimulatedDocument:
    """Compute a requested simulation.

    Parameters
    ----------
    asked : Asked
        The request.
    cycles_limit : int
        Largest number of excitation cycles, also in the search for a steady response, see `read_simulation`.

    Returns
    -------
    dict
        ``metrics`` has the same variables as a cube. ``status`` and ``response_class`` are sentences. ``history``
        contains the columns of the time history by name. The other keys are ``state``, ``events`` and ``cycles``.
        ``settles_after_cycles`` is present if the response repeats, and ``attractors`` if `starts` is above 0.
        ``wall`` is present for compliant walls: ``stiffness`` is divided by k, and ``damping`` by k/ω_n.
    """
    from damperlab.worker.attractors import find_attractors
    from damperlab.worker.simulate import simulate
    from damperlab.worker.solver.sliding import rubs

    settings = _settings(asked, cycles_limit)
    answer = simulate(
        asked.design, asked.cycles, asked.history, asked.method, settings=settings, followed=asked.followed
    )
    found = simulation_document(answer, asked.samples)
    if asked.cycles is not None and answer.metrics["status"] == Status.MAX_CYCLES:
        found["status"] = (
            f"The values are over the {counted(answer.cycles, 'cycle')} from rest that were requested, not "
            "over a steady response."
        )
    if asked.starts:
        found["attractors"] = attractors_document(
            find_attractors(asked.design, asked.starts, asked.seed, settings), rubs(asked.design.particle)
        )
    if asked.design.particle is not None and asked.design.particle.wall is not None:
        found["wall"] = asked.design.particle.wall._asdict()
    return found


def scenes_asked(asked: Asked, cycles_limit: int) -> list[Scene]:
    """Return the scenes whose kernels `compute` needs."""
    from damperlab.worker.simulate import scenes_of

    followed = asked.followed or asked.history > 0
    return scenes_of(asked.design, asked.cycles, asked.method, _settings(asked, cycles_limit), followed)


def _settings(asked: Asked, cycles_limit: int) -> "Steadiness":
    from damperlab.worker.steady.settle import Settings as Steadiness

    slowness = max(1.0, 1.0 / asked.design.frequency_ratio)
    return Steadiness(max(1, min(STEADY_CYCLES, int(cycles_limit / slowness))), 0.02, 1e-9)


def simulation_document(answer: "Simulation", samples: int) -> SimulatedDocument:
    """Return the document of a simulation, with at most `samples` samples of the time history."""
    metrics = answer.metrics
    after = settles_after(metrics)
    found: SimulatedDocument = {
        "metrics": metrics,
        "status": Status(int(metrics["status"])).sentence,
        "response_class": ResponseClass(int(metrics.get("response_class", ResponseClass.UNKNOWN))).sentence,
        "state": answer.state,
        "events": answer.events,
        "cycles": answer.cycles,
        "history": decimated(answer.history, samples),
    }
    if after is not None:
        found["settles_after_cycles"] = after
    return found


def settles_after(metrics: Mapping[str, float]) -> float | None:
    """Compute the number of cycles in which a small disturbance decays to the fraction `SETTLED`.

    Parameters
    ----------
    metrics : mapping
        Results, including the period and the Floquet multiplier.

    Returns
    -------
    float or None
        Number of cycles; None if the multiplier is missing, 0, or at least 1.
    """
    multiplier = metrics.get("floquet_multiplier", math.nan)
    if not 0.0 < multiplier < 1.0:
        return None
    return float(metrics["period"] * math.log(SETTLED) / math.log(multiplier))


def attractors_document(found: "Attractors", rubbing: bool) -> Met:
    """Return the document of a search for attractors.

    Parameters
    ----------
    found : Attractors
        Result of the search.
    rubbing : bool
        Whether the particle slides with friction. If it does not, the particle's friction variables are
        left out.
    """
    from damperlab.worker.steady.response.measures import Response

    return {
        "starts": found.starts,
        "failed": found.failed,
        "decided_by_a_rounding": found.by_a_rounding,
        "met": [
            {
                "share": one.starts / found.starts,
                "starts": one.starts,
                "from_rest": one.from_rest,
                "metrics": {
                    name: number
                    for name, number in zip(Response._fields, one.response, strict=True)
                    if not VARIABLES[name].asked and (rubbing or not VARIABLES[name].rubbing)
                },
            }
            for one in found.met
        ],
        "note": found.sentence,
    }


def decimated(history: Mapping[str, NDArray[np.float64]], samples: int) -> dict[str, NDArray[np.float64]]:
    """Reduce the number of samples of a time history, but keep the peaks of u.

    Parameters
    ----------
    history : mapping of ndarray
        Columns of equal length, including ``u``.
    samples : int
        Largest number of samples to keep, 2 or more.

    Returns
    -------
    dict of ndarray
        The columns at selected samples, in the order of time. The history is divided into samples/2 equal parts, and
        the samples with the smallest and the largest u of each part are selected.
    """
    if not history:
        return {}
    u = history["u"]
    if u.size <= samples:
        return dict(history)
    edges = np.linspace(0, u.size, samples // 2 + 1).astype(int)
    kept = set()
    for first, end in pairwise(edges):
        stretch = u[first:end]
        kept |= {first + int(stretch.argmin()), first + int(stretch.argmax())}
    index = np.array(sorted(kept))
    return {name: column[index] for name, column in history.items()}
