"""The answer to a refinement: the result, its uncertainty, and the cost of continuing."""

from typing import TYPE_CHECKING, Annotated, Any

from typing_extensions import TypedDict

from damperlab.studies.brief import InShort, Notes, notes_document
from damperlab.studies.shapes import Count, Like, Measured, OfStudy, Table
from damperlab.studies.store.record import Record

if TYPE_CHECKING:
    from damperlab.studies.answers.follow_up import Refinement


class Refined(TypedDict):
    """Uncertainty of an optimum or a class boundary, and the follow-ups that reduce it."""

    known: bool
    found: Table
    steps: dict[str, Measured]
    points: Count
    fine_points: Count
    spent: dict[str, Measured]
    definition: dict[str, Any] | None
    definitions: list[dict[str, Any]]
    note: str
    notes: Notes
    brief: InShort | None


class RefinementDocument(Refined, OfStudy):
    """A refinement together with its study."""


Entered = Annotated[dict[str, Any], Like(Record, "definition")]
"""Record of a follow-up study that was submitted."""


class FollowUpsDocument(RefinementDocument):
    """A refinement, and the records of the follow-up studies that were submitted."""

    follow_up: Entered
    follow_ups: list[Entered]


def refinement_document(found: "Refinement") -> Refined:
    """Return a refinement as a document, without the id, the name and the state of the study."""
    definitions = [study.document() for study in found.studies]
    return {
        "known": found.known,
        "found": found.found,
        "steps": found.steps,
        "points": found.points,
        "fine_points": found.fine_points,
        "spent": found.spent,
        "definition": definitions[0] if definitions else None,
        "definitions": definitions,
        "note": found.say(),
        "notes": notes_document(list(found.notes)),
        "brief": None if found.brief is None else found.brief.document(),
    }
