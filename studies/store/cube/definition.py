"""A study read from its stored definition: the same coordinates to the last bit, or an error."""

from dataclasses import replace
from typing import Any

from damperlab.studies.definition import Study, parse_study
from damperlab.studies.faults import Fault
from damperlab.studies.ground.suite import Suite
from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.files.shelf import Shelf


class DefinitionDamaged(StoreFault):
    """The stored definition of a study differs from the submitted one."""


def parse_stored(definition: Any, digest: str) -> Study | Suite:
    """Read the definition of a stored study.

    Parameters
    ----------
    definition : dict
        The definition in the catalogue or the cube.
    digest : str
        Digest of the study at submission, which covers every coordinate.

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
    """Give a study together with the files in its cube.

    Raises
    ------
    OSError, ValueError
        If one of the files is lost or damaged.
    """
    if isinstance(study, Study):
        return study
    motions = {record.id: record.read(shelf.get(record.key)) for record in study.records}
    return replace(study, motions=motions)


def _damaged(digest: str, found: str) -> DefinitionDamaged:
    return DefinitionDamaged(
        Fault(
            f"definition of study {digest[:12]}",
            found,
            f"a definition with digest {digest}",
            "run `damperlab store verify` to find what is damaged; the study is not computed meanwhile",
            f"The stored definition of study {digest[:12]} is damaged: it is {found} instead of the one "
            f"with digest {digest}.",
        )
    )
