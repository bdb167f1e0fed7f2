"""Faults: errors in a study, each with its place and a remedy."""

import difflib
import json
import math
import re
from collections.abc import Callable, Container, Iterable
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from damperlab.studies.spelling import unit_of
from damperlab.studies.user_error import UserError
from damperlab.studies.variables import MADE_BY

T = TypeVar("T")
U = TypeVar("U")

MAX_FAULTS = 100
"""Largest number of faults in one answer, which keeps the answer small. Further faults are only counted."""

WHOLE = "document"
"""Field name for an error of the complete document."""

NOTHING = "nothing"
"""Text for a missing value."""

PARTS = ("field", "found", "allowed", "advice", "message")
"""Fields of a fault in a problem document."""

_TEXT_SHOWN = 60
_FIELD_SHOWN = 300
_PLAIN_KEY = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,59}\Z")


@dataclass(frozen=True)
class Fault:
    """One error in a study.

    Parameters
    ----------
    field : str
        Path of the faulty value in the document, as in ``axes.clearance_ratio[3]``; `WHOLE` for the whole document.
    found : str
        The value found at this path.
    allowed : str
        The values allowed at this path.
    advice : str
        The remedy.
    message : str
        The error and the allowed values as a sentence, with ``{field}`` as a placeholder for the field. If empty, the
        sentence is formed from `field`, `found` and `allowed`.
    meant : str
        For an unknown key, the known key that was probably meant. For a missing key, another key that would determine
        the value. Empty if no key is to be suggested.
    """

    field: str
    found: str
    allowed: str
    advice: str
    message: str = ""
    meant: str = ""

    def __post_init__(self) -> None:
        """Shorten the field, because a key of a document may have megabytes."""
        if len(self.field) > _FIELD_SHOWN:
            object.__setattr__(self, "field", f"{self.field[:_FIELD_SHOWN]}…")

    def __str__(self) -> str:
        """Describe the error, the allowed values, and the remedy."""
        return f"{self.sentence} {sentence(self.advice)}".rstrip()

    @property
    def sentence(self) -> str:
        """The error and the allowed values, as a sentence."""
        field = f"`{self.field}`" if self.field else "The value"
        if self.message:
            return self.message.replace("{field}", field)
        if self.found == NOTHING:
            return f"{field} is missing; it must be {self.allowed}."
        return f"{field} must be {self.allowed}, not {self.found}."

    def document(self) -> dict[str, str]:
        """Return the fault as an entry of a problem document, with the property `sentence` as `message`."""
        return {name: getattr(self, name) for name in PARTS} | {"message": self.sentence}

    def under(self, parent: str) -> "Fault":
        """Return the same fault for a larger document that contains this document at the path ``parent``."""
        return replace(self, field=parent if parent and self.field == WHOLE else join(parent, self.field))


class StudyFaults(UserError, ValueError):
    """Every fault of a refused study.

    Parameters
    ----------
    faults : iterable of Fault
        At least one fault. The first `MAX_FAULTS` are listed, and the others are only counted.
    """

    def __init__(self, faults: Iterable[Fault]) -> None:
        listed = _once(list(faults))
        if len(listed) > MAX_FAULTS:
            more = len(listed) - MAX_FAULTS
            listed = listed[:MAX_FAULTS]
            listed.append(
                Fault(
                    "study",
                    f"{more} more faults",
                    "none",
                    "correct those that are listed, then submit again",
                    f"There are {counted(more, 'more fault')}.",
                )
            )
        self.faults: tuple[Fault, ...] = tuple(listed)
        super().__init__("\n".join(str(fault) for fault in listed))

    def __reduce__(self) -> tuple[type["StudyFaults"], tuple[tuple[Fault, ...]]]:
        """Make faults pickleable between processes."""
        return StudyFaults, (self.faults,)


def _once(faults: list[Fault]) -> list[Fault]:
    """Omit the fault of a missing key if an unknown key was probably written in its place."""
    meant = {fault.meant for fault in faults if fault.meant and fault.found != NOTHING}
    return [
        fault
        for fault in faults
        if fault.found != NOTHING or meant.isdisjoint((fault.field.rpartition(".")[2], fault.meant))
    ]


def attempt(reading: Callable[[], T], otherwise: U, faults: list[Fault]) -> T | U:
    """Call `reading` and return its result.

    If `reading` raises StudyFaults, append the faults to `faults` and return `otherwise`.
    """
    try:
        return reading()
    except StudyFaults as refused:
        faults.extend(refused.faults)
        return otherwise


def join(parent: str, child: str) -> str:
    """Join two paths, as in ``axes.clearance_ratio`` or ``metrics[3]``; an empty path is omitted."""
    if not parent or not child:
        return parent or child
    return parent + child if child.startswith("[") else f"{parent}.{child}"


def path(parts: Iterable[object]) -> str:
    """Return the path of a location in a document. A key that is not an identifier is quoted and shortened."""
    joined = ""
    for part in parts:
        if isinstance(part, int):
            joined += f"[{part}]"
        elif isinstance(part, str) and _PLAIN_KEY.match(part):
            joined = join(joined, part)
        else:
            joined += f"[{describe(part)}]"
    return joined


def printable(text: str) -> str:
    """Quote and shorten a text. If the text is not printable, escape its characters."""
    shown = json.dumps(text[:_TEXT_SHOWN], ensure_ascii=not text[:_TEXT_SHOWN].isprintable())
    return shown if len(text) <= _TEXT_SHOWN else f"{shown}… ({len(text)} characters)"


def describe(value: object) -> str:
    """Describe any value in a few words."""
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        if value.bit_length() > 200:
            return f"an integer of about {round(value.bit_length() * math.log10(2))} digits"
        return str(value)
    if isinstance(value, float):
        return "NaN" if math.isnan(value) else repr(value).replace("inf", "infinity")
    if isinstance(value, str):
        return f"the text {printable(value)}"
    if isinstance(value, dict):
        return "an empty mapping" if not value else f"a mapping of {counted(len(value), 'key')}"
    if isinstance(value, list | tuple):
        return "an empty list" if not value else f"a list of {counted(len(value), 'value')}"
    return f"a value of type {type(value).__name__[:_TEXT_SHOWN]}"


def counted(number: int, noun: str) -> str:
    """Return a number with a noun: ``1 value``, ``2 values``, ``10,000 values``."""
    return f"{number:,} {noun}{'' if number == 1 else 's'}"


MEANT: dict[str, tuple[str, ...]] = {
    "frequency_hz": ("excitation_frequency_hz", "frequency_ratio"),
    "excitation_frequency_hz": ("frequency_hz", "frequency_ratio"),
    **{ratio: (quantity,) for ratio, quantity in MADE_BY.items()},
}
"""For a key of one kind of document, the equivalent keys in other kinds, in order of preference. For
such a key, similar spelling would suggest a wrong key.
"""


def nearest(word: str, known: Iterable[str]) -> str | None:
    """Return the known name that was probably meant, or None."""
    names = list(known)
    if word in MEANT:
        return next((name for name in MEANT[word] if name in names), None)
    matches = difflib.get_close_matches(word[:_TEXT_SHOWN].lower(), names, n=1, cutoff=0.6)
    return matches[0] if matches else None


_PEAK_TO_PEAK = re.compile(r"double|(?<![a-z])(?:pp|p2p)(?![a-z])|(?:peak|pk)_?(?:to)?_?(?:peak|pk)")


def _unlike(key: str, near: str) -> str:
    """Say how the values of two keys differ, if one names a peak-to-peak or rms value and the other an amplitude."""
    if _PEAK_TO_PEAK.search(key.lower()):
        return ", half of a peak-to-peak value"
    return ", the largest value and not an rms" if "rms" in key.lower() and "rms" not in near else ""


def write_nearest(word: object, known: Iterable[str], otherwise: str = "choose one of these") -> str:
    """Return the advice to write the known word with the most similar spelling. If no word is similar, return
    `otherwise`.
    """
    near = nearest(word, known) if isinstance(word, str) else None
    return f"write {near}" if near else otherwise


def sentence(text: str) -> str:
    """Write advice as a sentence, with a capital letter and a full stop."""
    return text[:1].upper() + text[1:] + ("." if text and text[-1] not in ".?!" else "")


def listing(names: Iterable[str]) -> str:
    """Write names as a plain enumeration."""
    return ", ".join(names)


def unknown_key(field: str, key: object, known: tuple[str, ...], beside: Container[Any] = ()) -> Fault:
    """Return the fault of an unknown key, and suggest a similar name if there is one.

    Parameters
    ----------
    field : str
        Path of the key.
    key : object
        The key.
    known : tuple of str
        The allowed keys.
    beside : container
        Other keys of the same mapping, which are not suggested.
    """
    left = [name for name in known if name not in beside]
    near = nearest(key, left) if isinstance(key, str) else None
    advice = f"did you mean `{near}`{_unlike(str(key), near)}? Otherwise remove it" if near else "remove it"
    unit = unit_of(near or "")
    if near and unit and str(key).rpartition("_")[0] == near.rpartition("_")[0]:
        advice = f"write `{near}`, with its value in {unit}"
    found = f"the unknown key {printable(key)}" if isinstance(key, str) else f"{describe(key)} as a key"
    allowed = f"the keys {', '.join(known)}"
    told = f"{{field}} is not a known key; allowed are {listing(known)}."
    return Fault(field, found, allowed, advice, told, near or "")
