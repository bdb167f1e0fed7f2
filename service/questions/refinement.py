"""What a refinement is answered with: what is known, how well, and what computing on costs."""

from typing import TYPE_CHECKING, Any

from damperlab.service.questions.shapes import Count, InShort, Notes, Number, OfStudy, Table
from damperlab.studies.brief import notes_document

if TYPE_CHECKING:
    from damperlab.studies.answers.follow_up import Refinement as Found


class Refinement(OfStudy):
    """How well an optimum or a class boundary is known, and the follow-ups that tell more."""

    known: bool
    found: Table
    steps: dict[str, Number]
    points: Count
    fine_points: Count
    spent: dict[str, Number]
    definition: dict[str, Any] | None
    definitions: list[dict[str, Any]]
    note: str
    notes: Notes
    brief: InShort | None


def refinement_document(found: "Found") -> dict[str, Any]:
    """Put a refinement into a document, but for the study in front."""
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
        "brief": found.brief and found.brief.document(),
    }
