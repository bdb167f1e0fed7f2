"""Rules between the fields of a study, checked on the raw document, so that all faults are reported together."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

from damperlab.studies.amplitudes import RATIOS_OF, is_axis, over_amplitudes
from damperlab.studies.axes import MAX_AXIS_VALUES
from damperlab.studies.cavity import cavity_of
from damperlab.studies.choices import Contact
from damperlab.studies.faults import Fault, counted, describe
from damperlab.studies.kinds import before_of
from damperlab.studies.physical import DERIVATIONS, Derivation, derivations, physical_faults
from damperlab.studies.quantity import RATIOS
from damperlab.studies.variables import (
    BEFORE,
    GRAVITY,
    MADE_BY,
    PARTICLE_FRICTION,
    STANDARD,
    STEPPED,
    VARIABLES,
    available_variables,
)
from damperlab.studies.vocabulary import DEFAULTS, OF_PARTICLE

BESIDE_AXES = ("damping_ratio", *BEFORE)
"""Dimensions at the top level of a study instead of under `axes`."""

MAX_POINTS = 1_000_000_000
"""Largest number of design points of one study."""

LEAST_COMPLIANT = 1e-6
"""Smallest e of a compliant wall. For a smaller e, double precision does not resolve both decay rates of a contact."""


def compliant_fault(restitution: float, field: str) -> Fault | None:
    """Return a fault if e is too small for compliant walls, else None."""
    if restitution >= LEAST_COMPLIANT:
        return None
    allowed = f"a number from {LEAST_COMPLIANT:g} to 1 with compliant contact"
    return Fault(
        field,
        f"{restitution:g}",
        allowed,
        "write a larger e, or contact dwell or instant, which support e = 0",
    )


NOT_WITH_RUBBING = {
    "no_particle": ("a scene without a particle", "leave it out"),
    "contact": ("a contact that takes time", "leave out one of the two"),
    "rk4": ("method rk4", "use method event"),
    "amplitudes": ("several base amplitudes", "give each quantity of the cavity as one number in `physical`"),
    "ratios": ("a specification in ratios", "give the structure and its excitation in units"),
}
"""Features that exclude friction of the particle and gravity along the cavity, and advice for each feature."""


def rubbing_faults(field: str, found: str, beside: Mapping[str, bool]) -> Iterator[Fault]:
    """Yield a fault for each feature that excludes friction of the particle or gravity.

    Parameters
    ----------
    field, found : str
        The field with the friction or the tilt, and the value found in this field.
    beside : mapping of bool
        For each name in `NOT_WITH_RUBBING`, whether the document has this feature.
    """
    for name in (name for name, stands in beside.items() if stands):
        words, advice = NOT_WITH_RUBBING[name]
        told = f"{{field}} cannot be combined with {words}."
        yield Fault(field, found, f"nothing beside {words}", advice, told)


def cavity_faults(
    document: Mapping[str, Any], numbers: Mapping[str, float], contact: Contact
) -> Iterator[Fault]:
    """Yield a fault if contacts of finite duration are combined with particle friction or a tilted cavity.

    Parameters
    ----------
    document : mapping
        The raw document.
    numbers : mapping of float
        The parsed numbers, by name.
    contact : Contact
        The model of an impact.
    """
    if not cavity_of(numbers).acts:
        return
    field = next(name for name, value in cavity_of(numbers).numbers.items() if value)
    yield from rubbing_faults(field, describe(document[field]), {"contact": contact.model != "instant"})


def assumed(document: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the names of the dimensions that have default values because the document omits them."""
    axes, physical = document.get("axes") or {}, document.get("physical") or {}
    particle = document.get("particle", True) is not False
    made = {each.ratio for each in derivations(physical, particle=True)}
    given = {*axes, *made, *({"damping_ratio"} & set(document))}
    return tuple(name for name in DEFAULTS if name not in given and (particle or name not in OF_PARTICLE))


def with_defaults(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return the document with defaults for missing metrics and for undetermined ratios."""
    physical = document.get("physical")
    made = {d.ratio for d in derivations(physical, particle=True)} if isinstance(physical, dict) else set()
    filled = dict(document)
    axes = document.get("axes", {})
    for name, value in DEFAULTS.items():
        if name in made:
            continue
        if name == "damping_ratio":
            filled.setdefault(name, value)
        elif isinstance(axes, dict):
            axes = {name: value} | axes
    filled["axes"] = axes
    if "metrics" not in filled and _start_of(document) == "ensemble":
        filled["metrics"] = list(available_variables("ensemble"))
    if "metrics" not in filled and _is_stepped(document):
        filled["metrics"] = list(STEPPED)
    if PARTICLE_FRICTION in before_of(document):
        kept = filled.get("metrics", STANDARD)
        if "metrics" not in document and not _is_stepped(document):
            filled["metrics"] = [name for name in VARIABLES if name in kept or VARIABLES[name].rubbing]
    return filled


def faults_between(document: Mapping[str, Any]) -> list[Fault]:
    """Return a fault for each violated rule between fields. The fields themselves may be invalid."""
    axes, physical = document.get("axes", {}), document.get("physical")
    physical = {} if physical is None else physical
    particle = document.get("particle", True) is not False
    faults = [*_not_given_by_start(document), *_not_stepped(document), *_not_rubbing(document)]
    if not isinstance(axes, dict) or not isinstance(physical, dict):
        return faults
    given = dict(axes)
    for name in BESIDE_AXES:
        if name in document:
            given[name] = document[name]
    faults.extend(physical_faults(physical, particle))
    made = derivations(physical, particle=True)
    faults.extend(_given_twice(given, made))
    sources = {d.ratio: d.source for d in made}
    crossed = over_amplitudes(physical, particle)
    required = ("clearance_ratio", "frequency_ratio") if particle else ("frequency_ratio",)
    if crossed:
        required = ("frequency_ratio",)
        faults.extend(_kept_as_ratio(given, physical, particle))
    faults.extend(_required(name) for name in required if name not in given and name not in sources)
    sizes = [_size(value) for name, value in given.items() if particle or name not in OF_PARTICLE]
    ignored = {d.source for d in made if d.of_particle and not particle}
    sizes += [_size(value) for name, value in physical.items() if name not in ignored]
    points = math.prod(sizes)
    if points > MAX_POINTS:
        found, allowed = counted(points, "design point"), f"at most {MAX_POINTS:,} design points"
        told = f"The study has {found}; at most {MAX_POINTS:,} are allowed."
        faults.append(Fault("axes", found, allowed, "use fewer values, or split the study", told))
    return faults


def _start_of(document: Mapping[str, Any]) -> object:
    start = document.get("start", "rest")
    return start.get("kind") if isinstance(start, dict) else start


def _not_given_by_start(document: Mapping[str, Any]) -> Iterator[Fault]:
    metrics, start = document.get("metrics"), _start_of(document)
    for index, name in enumerate(metrics if isinstance(metrics, list | tuple) else ()):
        needed = VARIABLES[name].start if isinstance(name, str) and name in VARIABLES else ""
        if needed and start != needed:
            allowed = f"{name} only with `start: {{kind: {needed}}}`"
            told = f"{{field}} is {name}, which needs `start: {{kind: {needed}}}`."
            yield Fault(f"metrics[{index}]", name, allowed, f"remove it, or begin with an {needed}", told)


def _is_stepped(document: Mapping[str, Any]) -> bool:
    solver = document.get("solver")
    return isinstance(solver, dict) and solver.get("method") == "rk4"


def _not_stepped(document: Mapping[str, Any]) -> Iterator[Fault]:
    """Find features that the paper's fixed-step method does not support."""
    if not _is_stepped(document):
        return
    contact = document.get("contact")
    if isinstance(contact, dict) and contact.get("model", "instant") != "instant":
        found = f"{contact.get('model')}"
        yield Fault("contact.model", found, "instant with solver rk4", "write instant, or use solver event")
    if document.get("excitation") == "force":
        yield Fault("excitation", "force", "base with solver rk4", "leave it out, or use solver event")
    start = _start_of(document)
    if start != "rest":
        yield Fault("start", f"{start}", "rest with solver rk4", "leave `start` out")
    metrics = document.get("metrics")
    for index, name in enumerate(metrics if isinstance(metrics, list | tuple) else ()):
        if isinstance(name, str) and name in VARIABLES and name not in STEPPED:
            allowed = f"with solver rk4 one of {', '.join(STEPPED)}"
            told = (
                f"{{field}} is {name}, which solver rk4 does not compute; it computes {', '.join(STEPPED)}."
            )
            yield Fault(f"metrics[{index}]", name, allowed, "remove it, or use solver event", told)


def _not_rubbing(document: Mapping[str, Any]) -> Iterator[Fault]:
    """Find features that exclude particle friction or gravity, and metrics that require particle friction."""
    before, metrics = before_of({**document, "particle": True}), document.get("metrics")
    for index, name in enumerate(metrics if isinstance(metrics, list | tuple) else ()):
        needs = isinstance(name, str) and name in VARIABLES and VARIABLES[name].rubbing
        if needs and PARTICLE_FRICTION not in before:
            allowed = f"{name} only with `{PARTICLE_FRICTION}`"
            told = f"{{field}} is {name}, which needs `{PARTICLE_FRICTION}`."
            yield Fault(
                f"metrics[{index}]", f"{name}", allowed, "remove it, or give the particle friction", told
            )
    if not before:
        return
    physical = document.get("physical")
    physical = physical if isinstance(physical, dict) else {}
    contact = document.get("contact")
    beside = {
        "no_particle": document.get("particle", True) is False,
        "contact": isinstance(contact, dict) and contact.get("model", "instant") != "instant",
        "rk4": _is_stepped(document),
    }
    crossed = over_amplitudes(physical, particle=True)
    for name in before:
        source = MADE_BY[name]
        as_ratio = document.get(name) is not None
        beside["amplitudes"] = crossed and (as_ratio or is_axis(physical.get(source)))
        field = name if as_ratio else f"physical.{source}"
        yield from rubbing_faults(field, describe(document.get(name, physical.get(source))), beside)
    friction, tilt = (MADE_BY[name] for name in (PARTICLE_FRICTION, GRAVITY))
    if is_axis(physical.get(tilt)) and physical.get(friction) is not None:
        both = f"{PARTICLE_FRICTION} and {GRAVITY}"
        told = f"{{field}} is an axis that changes {both} together, but an axis may change one ratio only."
        advice = "submit one study for each tilt"
        yield Fault(f"physical.{tilt}", "an axis", f"a single number with {friction}", advice, told)


def _given_twice(given: Mapping[str, Any], made: list[Derivation]) -> Iterator[Fault]:
    for derivation in made:
        if derivation.ratio in given:
            ratio = derivation.ratio if derivation.ratio in BESIDE_AXES else f"axes.{derivation.ratio}"
            found = f"{derivation.ratio} given a second time, beside {ratio}"
            allowed = "each ratio once, as a ratio or by physical quantities"
            advice = f"remove `{derivation.source}` or `{ratio}`"
            told = f"{derivation.ratio} is given twice, by {{field}} and by `{ratio}`; one of them determines it."
            yield Fault(f"physical.{derivation.source}", found, allowed, advice, told)


def _kept_as_ratio(given: Mapping[str, Any], physical: Mapping[str, Any], particle: bool) -> Iterator[Fault]:
    """If the base amplitude is an axis, refuse a ratio that is given in place of a friction force or a clearance."""
    for source, ratio in RATIOS_OF.items():
        if source in physical or (ratio in OF_PARTICLE and not particle):
            continue
        found = given.get(ratio, 0.0 if ratio == "friction_ratio" else None)
        if ratio == "friction_ratio" and isinstance(found, int | float) and found == 0:
            continue
        field = f"physical.{source}" if found is None else f"axes.{ratio}"
        allowed = f"`physical.{source}` if the base amplitude is an axis"
        told = (
            f"The base amplitude is an axis, so the damper needs `physical.{source}`, which is the same at every "
            f"amplitude, instead of {ratio}."
        )
        advice = f"give `physical.{source}`" + ("" if found is None else f" and remove `axes.{ratio}`")
        yield Fault(field, "nothing" if found is None else describe(found), allowed, advice, told)


def _required(name: str) -> Fault:
    source = DERIVATIONS[name].source
    advice = f"add it, or give `physical.{source}`"
    if name == "clearance_ratio":
        advice += ", or write `particle: false`"
    return Fault(f"axes.{name}", "nothing", RATIOS[name].allowed, advice, meant=source)


def _size(raw: object) -> int:
    """Return the number of values of an axis as written, or 1 if a fault makes the number unknown."""
    if isinstance(raw, list | tuple):
        return max(len(raw), 1)
    num = raw.get("num") if isinstance(raw, dict) else None
    if isinstance(num, bool) or not isinstance(num, int | float) or not 1 <= num <= MAX_AXIS_VALUES:
        return 1
    return int(num)
