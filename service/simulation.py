"""Reads requests for simulations of single design points, limits the cost, and returns the results."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, NotRequired

import numpy as np
from numpy.typing import NDArray
from typing_extensions import TypedDict

from damperlab.service.motions import FORCES
from damperlab.studies.choices import CompliantContact, Contact, DwellContact
from damperlab.studies.consistency import compliant_fault, rubbing_faults
from damperlab.studies.contact import parse_contact
from damperlab.studies.faults import (
    NOTHING,
    Fault,
    StudyFaults,
    counted,
    describe,
    unknown_key,
    write_nearest,
)
from damperlab.studies.field import fields_of
from damperlab.studies.guard import guard
from damperlab.studies.quantity import QUANTITY_OF, RATIOS, read_count
from damperlab.studies.questions import Simulated
from damperlab.studies.shapes import Count, Like, Number, Numbers, Says, Table
from damperlab.studies.variables import BEFORE, DIMENSIONS, VARIABLES, ResponseClass, Status, Variable
from damperlab.studies.vocabulary import DEFAULTS, EXCITATIONS, OF_PARTICLE, Method
from damperlab.worker.scenes import Scene
from damperlab.worker.solver.particle import Particle

if TYPE_CHECKING:
    # at run time, these modules are imported only inside functions, because they import the compiler
    from damperlab.worker.attractors import Attractors
    from damperlab.worker.point import Design, Simulation
    from damperlab.worker.steady.settle import Settings as Steadiness

Columns = Annotated[dict[str, NDArray[np.float64]], Like(dict[str, Numbers])]
"""Type of a time history: its columns by name."""
FIELDS = {each.name: each for each in fields_of(Simulated)}
KEYS = (*DIMENSIONS, *BEFORE, "particle", "contact", *FIELDS)

STEADY_CYCLES = 4000
"""Largest number of excitation cycles in the search for a steady response."""
HISTORY_PERIODS = 1000
"""Largest length of a time history in natural periods.

The samples of a time history are computed in Python, which is slow.
"""
HISTORY_CYCLES = 10
SAMPLES = 1000
SETTLED = 0.01
"""Fraction to which a disturbance must decay before a response counts as settled."""


@dataclass(frozen=True)
class Asked:
    """A requested simulation.

    Parameters
    ----------
    design : Design
        The design point.
    cycles : int, optional
        Number of excitation cycles from rest. None to continue until the response is steady.
    history : int
        Number of excitation cycles in the time history, at the end of the simulation.
    samples : int
        Largest number of samples of the time history.
    method : {"event", "rk4"}
        Solver.
    starts : int
        Number of initial states from which the response is computed in a search for attractors; 0 for no search. The
        first initial state is rest.
    seed : int
        Seed of the random initial states.
    followed : bool
        Whether to count the events in a cycle of the steady response, see `damperlab.worker.simulate.simulate`.
    """

    design: "Design"
    cycles: int | None
    history: int
    samples: int
    method: Method
    starts: int = 0
    seed: int = 0
    followed: bool = True


def read_simulation(document: object, cycles_limit: int, samples_limit: int) -> Asked:
    """Read a request for a simulation.

    Parameters
    ----------
    document : object
        Request as read from JSON. The keys of the request are the names of the ratios, and also ``particle``,
        ``contact``, ``excitation``, ``cycles``, ``history``, ``samples``, ``method``, ``starts`` and
        ``seed``.
    cycles_limit : int
        Largest number of excitation cycles or, if r < 1, of natural periods.
    samples_limit : int
        Largest number of samples of the time history.

    Raises
    ------
    StudyFaults
        If the request is invalid. The exception contains all faults.
    """
    if not isinstance(document, dict):
        advice = 'write keys and values, at least {"frequency_ratio": 1, "clearance_ratio": 10}'
        raise StudyFaults((Fault("body", describe(document), "a mapping", advice),))
    _, faults = guard(document)
    faults += [unknown_key(str(key), key, KEYS, document) for key in document if key not in KEYS]
    has_particle = document.get("particle", True)
    if not isinstance(has_particle, bool):
        faults.append(
            Fault("particle", describe(has_particle), "true or false", "write false for no particle")
        )
        has_particle = True
    given = {**DEFAULTS, **document}
    ratios: dict[str, float] = {}
    for name in DIMENSIONS:
        if has_particle or name not in OF_PARTICLE:
            if name not in given:
                allowed = RATIOS[name].allowed
                advice = "add it" if name not in OF_PARTICLE else "add it, or write `particle: false`"
                faults.append(Fault(name, "nothing", allowed, advice))
            else:
                ratios[name] = _caught(faults, RATIOS[name].read, given[name], name, 1.0)
        elif name in document:
            told = "{field} does not apply to a scene without a particle."
            allowed = "nothing in a scene without a particle"
            faults.append(Fault(name, describe(document[name]), allowed, "leave it out", told))
    slowness = max(1.0, 1.0 / ratios.get("frequency_ratio", 1.0))
    most = max(1, int(cycles_limit / slowness))
    longest = max(1, int(HISTORY_PERIODS / slowness))
    method = document.get("method", Simulated.method)
    if method not in ("event", "rk4"):
        faults.append(Fault("method", describe(method), "event or rk4", "choose one of the two"))
    excitation = document.get("excitation", Simulated.excitation)
    if excitation not in EXCITATIONS:
        advice = write_nearest(excitation, EXCITATIONS)
        faults.append(Fault("excitation", describe(excitation), " or ".join(EXCITATIONS), advice))
    elif excitation == "force" and method == "rk4":
        faults.append(Fault("excitation", "force", "base with method rk4", "write `method: event`"))
    contact: Contact | None = None
    if "contact" in document:
        try:
            contact = parse_contact(document["contact"])
        except StudyFaults as caught:
            faults.extend(caught.faults)
        if method == "rk4" and isinstance(contact, DwellContact | CompliantContact):
            allowed = "instant with method rk4"
            faults.append(Fault("contact", contact.model, allowed, "write `method: event`"))
    before = {
        name: _caught(faults, QUANTITY_OF[name].read, document.get(name, 0.0), name, 0.0) for name in BEFORE
    }
    takes_time = isinstance(contact, DwellContact | CompliantContact)
    beside = {"no_particle": not has_particle, "contact": takes_time, "rk4": method == "rk4"}
    for name, value in before.items():
        if value > 0.0:
            faults += rubbing_faults(name, describe(value), beside)
    if isinstance(contact, CompliantContact) and has_particle:
        fault = compliant_fault(ratios["restitution"], "restitution")
        faults.extend([fault] if fault else [])
    cycles = document.get("cycles")
    if cycles is not None:
        cycles = _caught(faults, lambda raw, field: read_count(raw, 1, most, field), cycles, "cycles", 1)
    elif method == "rk4":
        faults.append(
            Fault(
                "cycles",
                NOTHING,
                "a number of cycles with method rk4",
                "add it",
                "{field} is missing: method rk4 runs for a given number of cycles.",
            )
        )
    starts = _caught(faults, _read_count, document.get("starts", Simulated.starts), "starts", 0)
    if starts and (cycles is not None or method == "rk4"):
        advice = "leave out `starts`, or `cycles` and `method`"
        faults.append(
            Fault(
                "starts",
                describe(starts),
                "`starts` only for steady responses of the event solver",
                advice,
                "`starts` applies to steady responses of the event solver alone, not with `cycles` or method rk4.",
            )
        )
    seed = _caught(faults, _read_count, document.get("seed", Simulated.seed), "seed", 0)
    history = document.get("history", min(HISTORY_CYCLES, longest))
    history = _caught(faults, lambda raw, field: read_count(raw, 0, longest, field), history, "history", 0)
    samples = document.get("samples", min(SAMPLES, samples_limit))
    samples = _caught(
        faults, lambda raw, field: read_count(raw, 2, samples_limit, field), samples, "samples", 2
    )
    if faults:
        raise StudyFaults(faults)
    from damperlab.worker.kernel_arguments import acting, contact_time_of, wall_of
    from damperlab.worker.point import Design

    particle = None
    if has_particle:
        particle = Particle(
            ratios["clearance_ratio"],
            ratios["restitution"],
            ratios["mass_ratio"],
            contact_time_of(contact),
            wall_of(contact, ratios["restitution"], ratios["mass_ratio"]),
            *acting(before),
        )
    design = Design(
        ratios["damping_ratio"],
        ratios["frequency_ratio"],
        ratios["friction_ratio"],
        particle,
        forced=excitation == "force",
    )
    return Asked(design, cycles, history, samples, method, starts, seed)


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


def _read_count(raw: object, name: str) -> int:
    """Read an integer within the limits of the field `name` of `Simulated`."""
    limits = FIELDS[name]
    return read_count(raw, int(limits.least or 0), int(limits.most or 0), name)


def _caught(faults: list[Fault], read: Any, raw: object, field: str, instead: Any) -> Any:
    """Return the result of `read`. If `read` refuses the value, add the faults to `faults` and return `instead`."""
    try:
        return read(raw, field)
    except StudyFaults as error:
        faults.extend(error.faults)
        return instead
