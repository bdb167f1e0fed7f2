"""Reading of a study from its stored definition."""

import hashlib
from dataclasses import replace
from typing import Any

from damperlab.studies.definition import Study, parse_study
from damperlab.studies.ground.suite import Suite
from damperlab.studies.kind import AnyStudy
from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.files.shelf import Shelf


class DefinitionDamaged(StoreFault):
    """The stored definition of a study differs from the submitted definition."""


def parse_stored(definition: Any, digest: str) -> Study | Suite:
    """Read the definition of a stored study.

    Parameters
    ----------
    definition : dict
        The definition in the catalogue or in the cube.
    digest : str
        Digest of the submitted study, which depends on every coordinate.

    Raises
    ------
    DefinitionDamaged
        If the definition does not have this digest.
    """
    try:
        study = parse_study(definition)
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise _damaged(digest, f"a definition that cannot be read ({error})") from error
    if study.digest != digest:
        raise _damaged(digest, f"the definition of study {study.digest[:12]}")
    return study


def with_attachments(study: Study | Suite, shelf: Shelf) -> Study | Suite:
    """Read the ground-motion records of a suite from the cube's files; return a harmonic study unchanged.

    Raises
    ------
    OSError, ValueError
        If the file of a record is lost or damaged.
    """
    if isinstance(study, Study):
        return study
    motions = {record.id: record.read(shelf.get(record.key)) for record in study.records}
    return replace(study, motions=motions)


def lost_attachments(shelf: Shelf, study: AnyStudy) -> list[str]:
    """Return the names of the cube's ground-motion records that are missing or damaged.

    Raises
    ------
    OSError
        If the files cannot be read.
    """
    return [key for key, sha256 in study.attached.items() if _sha256(shelf, key) != sha256]


def _sha256(shelf: Shelf, key: str) -> str:
    try:
        return hashlib.sha256(shelf.get(key)).hexdigest()
    except FileNotFoundError:
        return ""


def _damaged(digest: str, found: str) -> DefinitionDamaged:
    return DefinitionDamaged(
        f"definition of study {digest[:12]}",
        found,
        f"a definition with digest {digest}",
        "run `damperlab store verify` to find what is damaged; the study is not computed meanwhile",
        f"The stored definition of study {digest[:12]} is damaged: it is {found} instead of the one "
        f"with digest {digest}.",
    )
