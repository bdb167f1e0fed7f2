"""A force on the structure in newtons, and its static displacement F₀/k, which replaces the base amplitude."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any, TypeGuard

from damperlab.studies.faults import NOTHING, Fault, describe

FORCE = "force_n"
AMPLITUDE = "base_amplitude_m"
_OF_STIFFNESS = ("mass_kg", "natural_frequency_hz")
_SAME = 1e-9


def with_static_displacement(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return the document of a study with the base amplitude that corresponds to the force.

    The document is unchanged if the force is missing or faulty, or if the document has a base amplitude.
    """
    made = _made(document)
    if made is None or AMPLITUDE in document["physical"]:
        return dict(document)
    return {**document, "physical": {**document["physical"], AMPLITUDE: made}}


def without_force(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return a document without the force in its physical block."""
    physical = document.get("physical")
    if not isinstance(physical, dict) or FORCE not in physical:
        return dict(document)
    return {**document, "physical": {name: value for name, value in physical.items() if name != FORCE}}


def named_after_force(faults: Iterable[Fault], raw: Mapping[str, Any]) -> Iterator[Fault]:
    """In error messages, replace the derived base amplitude by the force. Omit errors that only follow from other
    errors.
    """
    physical = raw.get("physical")
    force = None
    if isinstance(physical, dict) and AMPLITUDE not in physical:
        force = physical.get(FORCE)
    for fault in faults:
        if force is None or fault.field != f"physical.{AMPLITUDE}":
            yield fault
        elif _made(raw) is not None and fault.found != NOTHING and _is_axis(force):
            yield replace(fault, field=f"physical.{FORCE}", found=describe(force))


def force_faults(document: Mapping[str, Any]) -> Iterator[Fault]:
    """Find conflicts between a force and other fields in a document from `with_static_displacement`."""
    physical = document.get("physical")
    if not isinstance(physical, dict):
        return
    if document.get("excitation") == "force" and physical.get("constant") is not None:
        allowed = "left out under a force, whose amplitude is the same at every frequency"
        yield Fault("physical.constant", describe(physical["constant"]), allowed, "leave it out")
    if physical.get(FORCE) is None:
        return
    field = f"physical.{FORCE}"
    found = describe(physical[FORCE])
    if document.get("excitation") != "force":
        told = "{field} is the amplitude of a force on the structure, but this study shakes the base."
        yield Fault(field, found, "nothing without `excitation: force`", "add `excitation: force`", told)
        return
    for name in _OF_STIFFNESS:
        if not _is_number(physical.get(name)):
            given = describe(physical[name]) if name in physical else NOTHING
            told = f"{{field}} must be one number, not {given}: the stiffness converts `{field}` to a displacement."
            yield Fault(f"physical.{name}", given, "one number", "give one", told)
    made, written = _made(document), physical.get(AMPLITUDE)
    if made is not None and not _same(made, written):
        told = f"{{field}} differs from the static displacement, which `{field}` and the stiffness determine."
        advice = "leave it out"
        yield Fault(f"physical.{AMPLITUDE}", describe(written), "nothing beside a force", advice, told)


def _made(document: Mapping[str, Any]) -> Any:
    """Return the base amplitude in the form of the force (number, list or range); None if force or stiffness is
    unknown.
    """
    physical = document.get("physical")
    if not isinstance(physical, dict):
        return None
    mass, frequency = (physical.get(name) for name in _OF_STIFFNESS)
    if not _is_number(mass) or not _is_number(frequency):
        return None
    stiffness = mass * (2.0 * math.pi * frequency) ** 2
    force = physical.get(FORCE)
    if not stiffness > 0.0 or not math.isfinite(stiffness):
        return None
    if _is_number(force):
        return float(force) / stiffness
    if isinstance(force, list | tuple) and force and all(map(_is_number, force)):
        return [float(each) / stiffness for each in force]
    if isinstance(force, dict) and all(_is_number(force.get(end)) for end in ("start", "stop")):
        return force | {end: float(force[end]) / stiffness for end in ("start", "stop")}
    return None


def _is_axis(raw: object) -> bool:
    return isinstance(raw, list | tuple | dict)


def _is_number(raw: object) -> TypeGuard[int | float]:
    return isinstance(raw, int | float) and not isinstance(raw, bool)


def _same(one: Any, other: Any) -> bool:
    """Return whether two axes are equal up to rounding."""
    if _is_number(one) and _is_number(other):
        return math.isclose(one, other, rel_tol=_SAME)
    if isinstance(one, list) and isinstance(other, list | tuple) and len(one) == len(other):
        return all(map(_same, one, other))
    if isinstance(one, dict) and isinstance(other, dict):
        return all(_same(one[end], other.get(end)) for end in ("start", "stop"))
    return False
