"""What people say of a study beside its definition: tags to find it by, and a note."""

import re
from dataclasses import dataclass
from typing import Any

from damperlab.studies.faults import Fault, StudyFaults, describe

MOST_TAGS = 20
MOST_NOTE = 4000
"""Characters of a note."""
TAG = re.compile(r"[a-z0-9][a-z0-9-]{0,39}")
TAG_WORDS = "up to 40 lower-case letters a to z, digits and hyphens, the first no hyphen"


@dataclass(frozen=True)
class Remarks:
    """Checked tags and note; None leaves what is there.

    Parameters
    ----------
    tags : tuple of str, optional
        Sorted, each once.
    note : str, optional
        Text of several lines.
    """

    tags: tuple[str, ...] | None = None
    note: str | None = None


def read_remarks(document: object) -> Remarks:
    """Check what somebody says of a study.

    Parameters
    ----------
    document : object
        ``tags``, a list of texts, and ``note``, a text; each may be left out.

    Raises
    ------
    StudyFaults
        With every fault.
    """
    if not isinstance(document, dict):
        told = "The remarks must be a mapping with `tags`, `note` or both."
        advice = 'write {"tags": ["rig-2"], "note": "…"}'
        raise StudyFaults([Fault("remarks", describe(document), "a mapping of tags and note", advice, told)])
    faults = [
        Fault(str(name), describe(value), "tags and note", "remove it", "{field} is not a known key.")
        for name, value in document.items()
        if name not in ("tags", "note")
    ]
    if not document:
        faults.append(Fault("remarks", "nothing", "tags, note or both", "add what is to be kept"))
    tags, note = document.get("tags"), document.get("note")
    faults += [] if tags is None else _faults_of_tags(tags)
    faults += [] if note is None else _faults_of_note(note)
    if faults:
        raise StudyFaults(faults)
    return Remarks(None if tags is None else tuple(sorted(set(tags))), None if note is None else note.strip())


def _faults_of_tags(tags: Any) -> list[Fault]:
    different = {(type(tag), str(tag)): tag for tag in tags} if isinstance(tags, list | tuple) else {}
    if not isinstance(tags, list | tuple) or len(different) > MOST_TAGS:
        found = f"{len(tags)} tags" if isinstance(tags, list | tuple) else describe(tags)
        return [
            Fault(
                "tags", found, f"a list of at most {MOST_TAGS} tags", "keep those by which it is looked for"
            )
        ]
    return [fault for tag in different.values() for fault in faults_of_tag("tags", tag)]


def faults_of_tag(field: str, tag: object) -> list[Fault]:
    """Find what is wrong with one tag."""
    if isinstance(tag, str) and TAG.fullmatch(tag):
        return []
    return [Fault(field, describe(tag), TAG_WORDS, "write it as in rig-2")]


def _faults_of_note(note: Any) -> list[Fault]:
    if isinstance(note, str) and len(note) <= MOST_NOTE and all(c.isprintable() or c in "\n\t" for c in note):
        return []
    found = f"{len(note):,} characters" if isinstance(note, str) and len(note) > MOST_NOTE else describe(note)
    return [
        Fault("note", found, f"a printable text of at most {MOST_NOTE:,} characters", "shorten or correct it")
    ]
