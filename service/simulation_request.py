"""Reads requests for simulations of single design points."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar

from damperlab.studies.choices import CompliantContact, Contact, DwellContact
from damperlab.studies.consistency import compliant_fault, rubbing_faults
from damperlab.studies.contact import parse_contact
from damperlab.studies.faults import (
    NOTHING,
    Fault,
    StudyFaults,
    describe,
    unknown_key,
    write_nearest,
)
from damperlab.studies.field import fields_of
from damperlab.studies.guard import guard
from damperlab.studies.quantity import QUANTITY_OF, RATIOS, read_count
from damperlab.studies.questions import Simulated
from damperlab.studies.variables import BEFORE, DIMENSIONS
from damperlab.studies.vocabulary import DEFAULTS, EXCITATIONS, OF_PARTICLE, Method
from damperlab.worker.solver.particle import Particle

if TYPE_CHECKING:
    # at run time, this module is imported only inside a function, because it imports the compiler
    from damperlab.worker.point import Design

Value = TypeVar("Value")
FIELDS = {each.name: each for each in fields_of(Simulated)}
KEYS = (*DIMENSIONS, *BEFORE, "particle", "contact", *FIELDS)

HISTORY_PERIODS = 1000
"""Largest length of a time history in natural periods.

The samples of a time history are computed in Python, which is slow.
"""
HISTORY_CYCLES = 10
SAMPLES = 1000


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
    request = _Request(document)
    has_particle = request.has_particle()
    ratios = request.ratios(has_particle)
    slowness = max(1.0, 1.0 / ratios.get("frequency_ratio", 1.0))
    method = request.method()
    excitation = request.excitation(method)
    contact = request.contact(method)
    before = request.before(has_particle, contact, method)
    if isinstance(contact, CompliantContact) and has_particle:
        fault = compliant_fault(ratios["restitution"], "restitution")
        request.faults.extend([fault] if fault else [])
    cycles = request.cycles(method, max(1, int(cycles_limit / slowness)))
    starts = request.starts(cycles, method)
    seed = request.number("seed", Simulated.seed)
    longest = max(1, int(HISTORY_PERIODS / slowness))
    history = request.count("history", min(HISTORY_CYCLES, longest), 0, longest)
    samples = request.count("samples", min(SAMPLES, samples_limit), 2, samples_limit)
    if request.faults:
        raise StudyFaults(request.faults)
    particle = _particle(ratios, contact, before) if has_particle else None
    from damperlab.worker.point import Design

    design = Design(
        ratios["damping_ratio"],
        ratios["frequency_ratio"],
        ratios["friction_ratio"],
        particle,
        forced=excitation == "force",
    )
    return Asked(design, cycles, history, samples, method, starts, seed)


def _particle(ratios: Mapping[str, float], contact: Contact | None, before: Mapping[str, float]) -> Particle:
    from damperlab.worker.kernel_arguments import acting, contact_time_of, wall_of

    return Particle(
        ratios["clearance_ratio"],
        ratios["restitution"],
        ratios["mass_ratio"],
        contact_time_of(contact),
        wall_of(contact, ratios["restitution"], ratios["mass_ratio"]),
        *acting(before),
    )


class _Request:
    """A request that is read part by part.

    Parameters
    ----------
    document : dict
        The request.

    Attributes
    ----------
    faults : list of Fault
        The faults of the parts that were read. A refused value is replaced by a valid one, so that reading continues.
    """

    def __init__(self, document: dict[Any, Any]) -> None:
        self._document = document
        _, self.faults = guard(document)
        self.faults += [unknown_key(str(key), key, KEYS, document) for key in document if key not in KEYS]

    def has_particle(self) -> bool:
        found = self._document.get("particle", True)
        if isinstance(found, bool):
            return found
        self._refuse("particle", found, "true or false", "write false for no particle")
        return True

    def ratios(self, has_particle: bool) -> dict[str, float]:
        """Return the ratios of the scene. A missing ratio is left out."""
        given = {**DEFAULTS, **self._document}
        found: dict[str, float] = {}
        for name in DIMENSIONS:
            if has_particle or name not in OF_PARTICLE:
                if name not in given:
                    advice = "add it" if name not in OF_PARTICLE else "add it, or write `particle: false`"
                    self.faults.append(Fault(name, "nothing", RATIOS[name].allowed, advice))
                else:
                    found[name] = self._caught(RATIOS[name].read, given[name], name, 1.0)
            elif name in self._document:
                told = "{field} does not apply to a scene without a particle."
                allowed = "nothing in a scene without a particle"
                self._refuse(name, self._document[name], allowed, "leave it out", told)
        return found

    def method(self) -> Method:
        found: Method = self._document.get("method", Simulated.method)
        if found not in ("event", "rk4"):
            self._refuse("method", found, "event or rk4", "choose one of the two")
        return found

    def excitation(self, method: Method) -> str:
        found: str = self._document.get("excitation", Simulated.excitation)
        if found not in EXCITATIONS:
            self._refuse("excitation", found, " or ".join(EXCITATIONS), write_nearest(found, EXCITATIONS))
        elif found == "force" and method == "rk4":
            self.faults.append(Fault("excitation", "force", "base with method rk4", "write `method: event`"))
        return found

    def contact(self, method: Method) -> Contact | None:
        contact: Contact | None = None
        if "contact" in self._document:
            try:
                contact = parse_contact(self._document["contact"])
            except StudyFaults as caught:
                self.faults.extend(caught.faults)
            if method == "rk4" and isinstance(contact, DwellContact | CompliantContact):
                allowed = "instant with method rk4"
                self.faults.append(Fault("contact", contact.model, allowed, "write `method: event`"))
        return contact

    def before(self, has_particle: bool, contact: Contact | None, method: Method) -> dict[str, float]:
        """Return friction and gravity of the particle, which need a particle, short contacts and the event solver."""
        found = {
            name: self._caught(QUANTITY_OF[name].read, self._document.get(name, 0.0), name, 0.0)
            for name in BEFORE
        }
        takes_time = isinstance(contact, DwellContact | CompliantContact)
        beside = {"no_particle": not has_particle, "contact": takes_time, "rk4": method == "rk4"}
        for name, value in found.items():
            if value > 0.0:
                self.faults += rubbing_faults(name, describe(value), beside)
        return found

    def cycles(self, method: Method, most: int) -> int | None:
        if self._document.get("cycles") is not None:
            return self.count("cycles", None, 1, most)
        if method == "rk4":
            told = "{field} is missing: method rk4 runs for a given number of cycles."
            allowed = "a number of cycles with method rk4"
            self.faults.append(Fault("cycles", NOTHING, allowed, "add it", told))
        return None

    def starts(self, cycles: int | None, method: Method) -> int:
        found = self.number("starts", Simulated.starts)
        if found and (cycles is not None or method == "rk4"):
            allowed = "`starts` only for steady responses of the event solver"
            advice = "leave out `starts`, or `cycles` and `method`"
            told = "`starts` applies to steady responses of the event solver alone, not with `cycles` or method rk4."
            self._refuse("starts", found, allowed, advice, told)
        return found

    def number(self, name: str, default: int) -> int:
        """Read an integer within the limits of the field `name` of `Simulated`."""
        least, most = int(FIELDS[name].least or 0), int(FIELDS[name].most or 0)
        return self.count(name, default, least, most)

    def count(self, name: str, default: int | None, least: int, most: int) -> int:
        """Read an integer from `least` to `most`."""
        return self._caught(
            lambda raw, field: read_count(raw, least, most, field),
            self._document.get(name, default),
            name,
            least,
        )

    def _refuse(self, field: str, found: object, allowed: str, advice: str, told: str = "") -> None:
        self.faults.append(Fault(field, describe(found), allowed, advice, told))

    def _caught(self, read: Callable[[object, str], Value], raw: object, field: str, instead: Value) -> Value:
        """Return the result of `read`, or `instead` if it refuses the value."""
        try:
            return read(raw, field)
        except StudyFaults as error:
            self.faults.extend(error.faults)
            return instead
