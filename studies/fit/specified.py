"""A specification made of a prototype that a fit found, and its text: what was measured, and guesses in comments."""

import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import yaml

from damperlab.studies.choices import CompliantContact, InstantContact
from damperlab.studies.definition import MAX_NAME
from damperlab.studies.faults import NOTHING, Fault, StudyFaults, listing
from damperlab.studies.fit.prototype import OF_CAVITY, SCALES, Prototype, short, span
from damperlab.studies.fit.tolerance import say_tolerances, spoken, tolerances_of
from damperlab.studies.specification.reading import parse_specification
from damperlab.studies.specification.specification import CHOSEN, OF_STRUCTURE, RATIO_OF

CHANGED = "clearance_m", "friction_force_n"
"""What of a damper is changed at the bench."""
FACTOR = 4.0
"""How much less and more than what was built is looked at."""
LEAST_FRICTION = 1e-3
"""Friction force over kZ below which there is none to speak of."""
MOST_FRICTION = 0.78
"""Friction force over kZ up to which friction alone does not hold the structure at resonance: π/4."""
GUESSED_CLEARANCE = 1.0, 20.0
"""Clearance over the amplitude of the base, where no particle was there."""
GUESSED_MASS, GUESSED_RESTITUTION = 0.1, 0.5
"""Of a particle, where none was there: m/M and e."""


@dataclass(frozen=True)
class Specified:
    """A specification that a measurement made.

    Parameters
    ----------
    document : dict
        As `damperlab.studies.specification.reading.parse_specification` reads it.
    words : tuple of str
        What of it was measured, and what the specification cannot say.
    guesses : mapping of str
        Why, by the place in the document, what is a guess and wants to be edited.
    """

    document: dict[str, Any]
    words: tuple[str, ...]
    guesses: Mapping[str, str]


def specified(prototype: Prototype) -> Specified:
    """Make a specification of a prototype.

    Parameters
    ----------
    prototype : Prototype
        What was found.

    Returns
    -------
    Specified
        In units where mass, natural frequency and amplitude of the base are known; else in ratios.

    Raises
    ------
    StudyFaults
        Where lengths are known and the mass is not, or where no specification can be made of the numbers.
    """
    _check_scales(prototype)
    writer = _Writer(prototype)
    name = "".join(letter for letter in prototype.name if letter.isprintable())
    document: dict[str, Any] = {
        "name": f"{name[: MAX_NAME - 40]}, corrected",
        "structure": writer.structure(),
        "excitation": dict(prototype.excitation),
        "choose": writer.choose(),
        **writer.given(),
    }
    names = [name for name in (*OF_STRUCTURE, *CHOSEN) if name in prototype.values]
    if not writer.has_friction:
        names.remove("friction_force_n")
    if tolerances := tolerances_of(prototype, names):
        document["tolerances"] = {writer.spelled(name): each for name, each in tolerances.items()}
    document["measure"] = "worst_displacement"
    parse_specification(document)
    words = (*say_tolerances(prototype, names), *writer.words())
    return Specified(document, words, writer.guesses)


def _check_scales(prototype: Prototype) -> None:
    """Refuse metres beside a mass that nobody knows, where the base is guessed in metres too."""
    if prototype.guessed and "mass_kg" not in prototype.known:
        told = "{field} is missing: a time history is in metres, and a specification in units needs the mass of the structure."
        advice = "weigh it and give it; it changes nothing about the fit"
        raise StudyFaults([Fault("mass_kg", NOTHING, "the mass of the structure in kg", advice, told)])


class _Writer:
    """Writes the parts of a specification in units or in ratios, and keeps what it guessed."""

    def __init__(self, prototype: Prototype) -> None:
        self.prototype = prototype
        self.guesses: dict[str, str] = {}
        if prototype.guessed:
            self.guesses["excitation"] = f"{prototype.guessed}."

    @property
    def largest_m(self) -> float:
        """The largest amplitude of the base, which ratios are over."""
        return max(self.prototype.base_m)

    @property
    def locking_n(self) -> float:
        """The friction force up to which friction alone does not hold the structure at resonance."""
        return MOST_FRICTION * self.prototype.structure.stiffness_n_per_m * self.largest_m

    @property
    def has_friction(self) -> bool:
        """Whether there is friction to speak of."""
        return self.prototype.values["friction_force_n"][-1] > LEAST_FRICTION * self.locking_n

    def structure(self) -> dict[str, float]:
        """Write what is known of the structure; without a mass in ratios its frequency alone, for bands in Hz."""
        told = {
            name: short(self.prototype.values[name][0])
            for name in OF_STRUCTURE
            if name not in SCALES or name in self.prototype.known
        }
        if not self.prototype.in_units:
            told.pop("mass_kg", None)
        return told

    def choose(self) -> dict[str, Any]:
        """Write ranges around what was built."""
        found: dict[str, Any] = {}
        for name, ends in self._ranges().items():
            scale = self._scale(name)
            shown = [end / scale for end in ends]
            # a guess needs no digits; what was measured keeps them
            found[self.spelled(name)] = span(
                [float(f"{end:.3g}") for end in shown] if name in CHANGED else shown
            )
        return found

    def given(self) -> dict[str, Any]:
        """Write what is not chosen."""
        values = self.prototype.values
        particle = (GUESSED_MASS * values["mass_kg"][0],)
        found = {
            "particle_mass_kg": values.get("particle_mass_kg", particle),
            "restitution": values.get("restitution", (GUESSED_RESTITUTION,)),
        }
        if not self.prototype.particle:
            self.guesses[self.spelled("particle_mass_kg")] = "a tenth of the mass of the structure."
            self.guesses["restitution"] = "of hard rubber; steel has more."
        document: dict[str, Any] = {
            self.spelled(name): short(each[0] / self._scale(name))
            for name, each in found.items()
            if len(each) == 1
        }
        document |= {name: short(values[name][0]) for name in OF_CAVITY if name in values}
        if time_s := self._contact_time_s():
            document["contact_time_s"] = short(time_s)
        return document

    def _ranges(self) -> dict[str, tuple[float, ...]]:
        """Give what is chosen: the ends of each range in SI units."""
        values, largest = self.prototype.values, self.largest_m
        found: dict[str, tuple[float, ...]] = {}
        if self.prototype.particle:
            found["clearance_m"] = self._around("clearance_m")
        else:
            found["clearance_m"] = tuple(share * largest for share in GUESSED_CLEARANCE)
            self._guess("clearance_m", "1 to 20 times the amplitude of the base; no particle was measured.")
        if self.has_friction:
            found["friction_force_n"] = self._around("friction_force_n")
        else:
            found["friction_force_n"] = 0.0, self.locking_n
            self._guess(
                "friction_force_n", "from none, as built, to what friction alone holds the structure with."
            )
        for name in ("particle_mass_kg", "restitution"):
            if len(values.get(name, ())) > 1:
                found[name] = values[name]
                self._guess(name, "all that was measured.")
        return found

    def _around(self, name: str) -> tuple[float, float]:
        built = self.prototype.values[name]
        least = built[0] / FACTOR
        if name == "friction_force_n" and self.prototype.off.get(name, 0.0) >= 1.0 - 1.0 / FACTOR:
            least = 0.0  # there may be less than a quarter now
        scale = self._scale(name)
        said = " to ".join(f"{each / scale:.4g}" for each in dict.fromkeys((built[0], built[-1])))
        self._guess(name, f"{'none' if least == 0.0 else 'a quarter'} to four times what was built, {said}.")
        return least, built[-1] * FACTOR

    def _guess(self, name: str, why: str) -> None:
        self.guesses[f"choose.{self.spelled(name)}"] = why

    def spelled(self, name: str) -> str:
        """Name a quantity: in its unit, or as a ratio."""
        return name if self.prototype.in_units or name not in RATIO_OF else RATIO_OF[name]

    def _scale(self, name: str) -> float:
        """Give what a quantity is over where it is written as a ratio."""
        if self.prototype.in_units:
            return 1.0
        structure = self.prototype.structure
        return {
            "clearance_m": self.largest_m,
            "friction_force_n": structure.stiffness_n_per_m * self.largest_m,
            "particle_mass_kg": structure.mass_kg,
        }.get(name, 1.0)

    def _contact_time_s(self) -> float:
        """Give how long particle and wall touch [s]; 0 where that takes no time or cannot be said."""
        contact = self.prototype.contact
        if isinstance(contact, InstantContact) or not (self.prototype.particle and self.prototype.in_units):
            return 0.0
        return contact.contact_time / self.prototype.structure.angular_frequency

    def words(self) -> Iterator[str]:
        """Say what a specification leaves out."""
        prototype = self.prototype
        if not prototype.in_units:
            missing = listing(f"`{name}`" for name in SCALES if name not in prototype.known)
            yield f"It is in ratios: {missing} would make it one in metres, newtons and kilograms."
        contact = prototype.contact
        if not isinstance(contact, InstantContact) and prototype.particle:
            if not prototype.in_units:
                yield "Its impacts take no time, other than those fitted: a contact time is in seconds, and it is in ratios."
            elif isinstance(contact, CompliantContact):
                yield "Its impacts are of the model dwell, with the contact time of the compliant contact that was fitted."
        guessed = [place.rpartition(".")[2] for place in self.guesses]
        yield (
            f"Guessed are {spoken(guessed)}: edit them to what can be built and what shakes it, and add `limits` that must be "
            "kept."
        )


WIDTH = 120


def specification_text(specified: Specified) -> str:
    """Write a specification as YAML.

    Parameters
    ----------
    specified : Specified
        Its sentences head the text; what is guessed has a comment above it.
    """
    lines = [line for sentence in specified.words for line in _comment(sentence)]
    for key, value in specified.document.items():
        lines += _entry(specified, key, value)
    return "\n".join(lines) + "\n"


def _entry(specified: Specified, key: str, value: Any) -> Iterator[str]:
    yield from _guess(specified, key)
    inside = any(place.startswith(f"{key}.") for place in specified.guesses)
    if not (inside and isinstance(value, dict)):
        yield from _dumped({key: value})
        return
    yield f"{key}:"
    for name, each in value.items():
        for line in (*_guess(specified, f"{key}.{name}"), *_dumped({name: each})):
            yield f"  {line}"


def _guess(specified: Specified, place: str) -> Iterator[str]:
    if place in specified.guesses:
        yield from _comment(f"GUESS, to be edited: {specified.guesses[place]}")


def _comment(sentence: str) -> list[str]:
    return [f"# {line}" for line in textwrap.wrap(sentence, WIDTH)]


def _dumped(document: dict[str, Any]) -> list[str]:
    """Write one entry: collections of plain values on one line."""
    (value,) = document.values()
    flow = None if isinstance(value, dict | list) else False
    text = yaml.safe_dump(
        document, allow_unicode=True, sort_keys=False, default_flow_style=flow, width=10_000
    )
    return text.splitlines()
