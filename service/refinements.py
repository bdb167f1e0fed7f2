"""A refinement as a document: what HTTP sends and what the command line prints with --json."""

from typing import Any

from damperlab.studies.answers.follow_up import Refinement
from damperlab.studies.brief import notes_document


def refinement_document(refinement: Refinement) -> dict[str, Any]:
    """Put a refinement into a document: what is known, how well, and what computing on costs."""
    definitions = [study.document() for study in refinement.studies]
    return {
        "known": refinement.known,
        "found": refinement.found,
        "steps": refinement.steps,
        "points": refinement.points,
        "fine_points": refinement.fine_points,
        "spent": refinement.spent,
        "definition": definitions[0] if definitions else None,
        "definitions": definitions,
        "note": refinement.say(),
        "notes": notes_document(list(refinement.notes)),
        "brief": refinement.brief and refinement.brief.document(),
    }
