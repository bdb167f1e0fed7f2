"""Reads a document that asks to compare dampers under one record."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from math import isnan
from typing import Any

from damperlab.studies.choices import Contact, InstantContact
from damperlab.studies.consistency import cavity_faults, compliant_fault
from damperlab.studies.contact import parse_contact
from damperlab.studies.faults import (
    Fault,
    StudyFaults,
    attempt,
    describe,
    listing,
    unknown_key,
    write_nearest,
)
from damperlab.studies.field import fields_of
from damperlab.studies.ground.generated import GENERATED, WRITTEN, recipe_in
from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.ground.quantities import QUANTITIES
from damperlab.studies.ground.shelf import RecordNotFound, Shelf
from damperlab.studies.guard import guard
from damperlab.studies.quantity import read_count
from damperlab.studies.questions import MOST_SEED, MOST_STARTS, Compared
from damperlab.studies.tmd.tunings import MOST_UNDER_BASE
from damperlab.studies.vocabulary import CASES, CRITERIA, Criterion


@dataclass(frozen=True)
class Earthquake:
    """A comparison of dampers under one record.

    Parameters
    ----------
    record_id : str
        Id of the record. A generated record has an id that contains the digest of its samples.
    motion : GroundMotion
        Samples of the record.
    values : dict of float
        Value of each of `QUANTITIES`.
    criterion : str
        Criterion by which the mass damper is tuned.
    cases : tuple of str
        Names of the cases to compare, from `CASES`.
    starts : int
        Number of perturbed starts in addition to the start at rest.
    seed : int
        Seed for drawing the perturbed starts.
    contact : Contact
        Contact model for impacts.
    """

    record_id: str
    motion: GroundMotion
    values: dict[str, float]
    criterion: Criterion
    cases: tuple[str, ...]
    starts: int
    seed: int
    contact: Contact


MOST_NAMED = 20
"""Largest number of listed cases that are checked. The number is limited because the search for a known name
that resembles an unknown name takes time.
"""
KEYS = (*QUANTITIES, *(each.name for each in fields_of(Compared)), "contact")


def read_earthquake(document: object, shelf: Shelf) -> Earthquake:
    """Read a comparison of dampers under one record.

    Parameters
    ----------
    document : object
        Mapping from JSON or YAML with any of `KEYS`. ``record`` is the id of a record, the name of an earthquake, or a
        mapping with one of `GENERATED`, for example ``{"sweep": {…}}``.
    shelf : Shelf
        The store of records.

    Raises
    ------
    StudyFaults
        If the document is invalid; the exception lists every fault.
    """
    if not isinstance(document, dict):
        advice = 'write keys and values, at least {"record": "loma-prieta"}'
        raise StudyFaults([Fault("body", describe(document), "a mapping", advice)])
    held, faults = guard(document)
    faults += [unknown_key(str(key), key, KEYS, held) for key in held if key not in KEYS]
    values: dict[str, float] = {}
    for name, (quantity, default) in QUANTITIES.items():
        raw = held.get(name)
        value = default if raw is None else attempt(partial(quantity.read, raw, name), None, faults)
        values |= {} if value is None else {name: value}
    criterion = held.get("tmd_criterion", Compared.tmd_criterion)
    if criterion not in tuple(CRITERIA):
        faults.append(
            Fault("tmd_criterion", describe(criterion), f"one of {listing(CRITERIA)}", "choose one of these")
        )
    cases = _cases(held.get("cases", list(CASES)), faults)
    if not faults and criterion == "h2" and "tmd" in cases:
        mass = values["particle_mass_kg"] if isnan(values["tmd_mass_kg"]) else values["tmd_mass_kg"]
        most = MOST_UNDER_BASE * values["mass_kg"]
        if mass >= most:
            allowed = f"a mass below {most:g} kg for h2"
            faults.append(Fault("tmd_mass_kg", f"{mass:g} kg", allowed, "choose another `tmd_criterion`"))
    starts, seed = (
        attempt(partial(read_count, held.get(name, usual), 0, most, name), usual, faults)
        for name, usual, most in (
            ("starts", Compared.starts, MOST_STARTS),
            ("seed", Compared.seed, MOST_SEED),
        )
    )
    contact = read_contact(held, values, "restitution", values.get("restitution"), faults)
    named = held.get("record", Compared.record)
    record = attempt(lambda: read_record_reference(named, shelf), None, faults)
    if faults or record is None:
        raise StudyFaults(faults)
    tuning: Any = criterion
    return Earthquake(*record, values, tuning, cases, starts, seed, contact)


def read_contact(
    held: Mapping[str, Any], values: Mapping[str, float], field: str, least: float | None, faults: list[Fault]
) -> Contact:
    """Read the contact model in a document, and append the faults of features that cannot be combined with it.

    Parameters
    ----------
    held : mapping
        The document.
    values : mapping of float
        Numbers of the document, with friction and tilt of the cavity.
    field, least : str, float or None
        Field with the coefficient of restitution, and its smallest value; None if the value is faulty.
    faults : list of Fault
        Faults found so far.
    """
    instant: Contact = InstantContact()
    contact = attempt(lambda: parse_contact(held.get("contact", {"model": "instant"})), instant, faults)
    if contact.model == "compliant" and least is not None and (fault := compliant_fault(least, field)):
        faults.append(fault)
    faults += cavity_faults(held, values, contact)
    return contact


def read_record_reference(raw: object, shelf: Shelf) -> tuple[str, GroundMotion]:
    """Return the id and the samples of the record to which a document refers.

    Raises
    ------
    StudyFaults
        If the reference is invalid, or the record does not exist.
    """
    if isinstance(raw, dict):
        way = recipe_in(raw)
        if not way or len(raw) > 1:
            allowed = f"the id of a record, {WRITTEN}"
            raise StudyFaults([Fault("record", describe(raw), allowed, "name a record")])
        motion = GENERATED[way](raw[way])
        return f"u-{motion.digest}", motion
    if not isinstance(raw, str):
        raise StudyFaults([Fault("record", describe(raw), "the id of a record", "name a record")])
    try:
        return shelf.get(raw)
    except RecordNotFound as missing:
        raise StudyFaults([missing.fault]) from None


def _cases(raw: object, faults: list[Fault]) -> tuple[str, ...]:
    if isinstance(raw, list | tuple) and raw and all(isinstance(case, str) and case in CASES for case in raw):
        return tuple(case for case in CASES if case in raw)
    advice = "leave it out for all of them"
    if isinstance(raw, list | tuple) and raw:
        for index, case in enumerate(raw[:MOST_NAMED]):
            if not isinstance(case, str) or case not in CASES:
                near = write_nearest(case, CASES, advice)
                faults.append(Fault(f"cases[{index}]", describe(case), f"one of {listing(CASES)}", near))
    else:
        faults.append(Fault("cases", describe(raw), f"a list of any of {listing(CASES)}", advice))
    return ()
