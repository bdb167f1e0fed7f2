"""Maps of a study that is not complete: what its coarse grid shows of the places that are not computed yet."""

from typing import Any

from damperlab.service.questions.forms import MAP
from damperlab.studies.answers.query_fault import QueryFault
from damperlab.studies.answers.resonance_map import resonance_map
from damperlab.studies.coarse import coarse
from damperlab.studies.definition import Study
from damperlab.studies.questions import Plane, Selection
from damperlab.studies.store.cube.definition import parse_stored
from damperlab.studies.store.faults import StudyNotFound
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store

SHOWN = ("x", "y", "values", "at", "complete", "note")
"""What is told of the coarse map; all else is as in the map of the study."""


def coarse_of(record: Record) -> Study | None:
    """Give the coarse grid that a study has, computed or not; None where it has none."""
    return coarse(parse_stored(record.definition, record.digest))


def map_preview(
    store: Store, first: Study, x: str, y: str, plane: Plane, selection: Selection
) -> dict[str, Any] | None:
    """Answer a question for a map from the coarse grid of a study.

    Parameters
    ----------
    store : Store
        Where both are.
    first : Study
        Of `coarse_of`.
    x, y : str
        The dimensions of the map.
    plane, selection : Plane, Selection
        The rest of the question; other dimensions are taken at the nearest value that the coarse grid has.

    Returns
    -------
    dict or None
        `study`, the id of the coarse grid, and of its map what `SHOWN` names; None where there is none, or nothing of it.
    """
    found = store.newest(first.digest)
    if found is None or not found.blocks_done:
        return None
    try:
        answer = resonance_map(store.cube(found.id), x, y, selection, plane.over, plane.reduce)
    except (QueryFault, StudyNotFound):
        return None  # as where values are to be interpolated between points that it does not have
    document = MAP.write(answer)
    return {"study": found.id, **{name: document[name] for name in SHOWN}}
