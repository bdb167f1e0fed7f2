"""Remarks of users on a study: a new name, tags and a note. Remarks are not part of the definition."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from damperlab.studies.brief import listed
from damperlab.studies.definition import MAX_NAME
from damperlab.studies.faults import Fault, StudyFaults, describe

MOST_TAGS = 20
MOST_NOTE = 4000
"""Largest number of characters of a note."""
TAG = re.compile(r"[a-z0-9][a-z0-9-]{0,39}")
KNOWN = ("tags", "note", "name")
"""Remarks on a study; for a design, only `name` is allowed."""
TAG_WORDS = "up to 40 lower-case letters a to z, digits and hyphens, the first no hyphen"


@dataclass(frozen=True)
class Remarks:
    """Checked tags, note and name. None leaves the present tags, note or name unchanged.

    Parameters
    ----------
    tags : tuple of str, optional
        Tags in sorted order, each once.
    note : str, optional
        Text of one or several lines.
    name : str, optional
        The new name of the study. The definition keeps the original name.
    """

    tags: tuple[str, ...] | None = None
    note: str | None = None
    name: str | None = None


def read_remarks(document: object, known: Sequence[str] = KNOWN) -> Remarks:
    """Check remarks on a study or a design.

    Parameters
    ----------
    document : object
        A mapping with the optional keys ``tags`` (a list of texts), ``note`` and ``name`` (texts).
    known : sequence of str
        The allowed keys.

    Raises
    ------
    StudyFaults
        If the remarks have faults; the error lists every fault.
    """
    names = listed(known)
    if not isinstance(document, dict):
        told = f"The remarks must be a mapping of {names}."
        advice = f'write {{"{known[-1]}": "…"}}'
        raise StudyFaults([Fault("remarks", describe(document), f"a mapping of {names}", advice, told)])
    faults = [
        Fault(str(name), describe(value), names, "remove it", "{field} is not a known key.")
        for name, value in document.items()
        if name not in known
    ]
    if not document:
        faults.append(Fault("remarks", "nothing", names, "add a value to store"))
    tags, note, called = document.get("tags"), document.get("note"), document.get("name")
    faults += [] if tags is None else _faults_of_tags(tags)
    faults += [] if note is None else _faults_of_text("note", note, MOST_NOTE, "\n\t")
    faults += [] if called is None else _faults_of_name(called)
    if faults:
        raise StudyFaults(faults)
    sorted_tags = None if tags is None else tuple(sorted(set(tags)))
    return Remarks(sorted_tags, *(None if text is None else text.strip() for text in (note, called)))


def _faults_of_tags(tags: Any) -> list[Fault]:
    different = {(type(tag), str(tag)): tag for tag in tags} if isinstance(tags, list | tuple) else {}
    if not isinstance(tags, list | tuple) or len(different) > MOST_TAGS:
        found = f"{len(tags)} tags" if isinstance(tags, list | tuple) else describe(tags)
        return [
            Fault(
                "tags",
                found,
                f"a list of at most {MOST_TAGS} tags",
                "keep the tags that you use for searching",
            )
        ]
    return [fault for tag in different.values() for fault in faults_of_tag("tags", tag)]


def faults_of_tag(field: str, tag: object) -> list[Fault]:
    """Find faults of one tag."""
    if isinstance(tag, str) and TAG.fullmatch(tag):
        return []
    return [Fault(field, describe(tag), TAG_WORDS, "write it as in rig-2")]


def _faults_of_name(name: Any) -> list[Fault]:
    if isinstance(name, str) and not name.strip():
        allowed = f"a printable text of 1 to {MAX_NAME:,} characters"
        return [
            Fault(
                "name", "an empty text", allowed, "write a name, or leave `name` out to keep the present one"
            )
        ]
    return _faults_of_text("name", name, MAX_NAME)


def _faults_of_text(field: str, text: Any, most: int, also: str = "") -> list[Fault]:
    if isinstance(text, str) and len(text) <= most and all(c.isprintable() or c in also for c in text):
        return []
    found = f"{len(text):,} characters" if isinstance(text, str) and len(text) > most else describe(text)
    return [Fault(field, found, f"a printable text of at most {most:,} characters", "shorten or correct it")]
