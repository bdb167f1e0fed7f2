"""Comparisons and follow-ups as documents: what HTTP sends and what the command line prints with --json."""

from typing import Any

import xarray as xr

from damperlab.service.columns import columns
from damperlab.studies.answers.follow_up import Refinement
from damperlab.studies.brief import notes_document
from damperlab.studies.variables import VARIABLES


def columns_document(answer: xr.Dataset) -> dict[str, Any]:
    """Put an answer with one dimension into a document, a list for each of its variables.

    Parameters
    ----------
    answer : Dataset
        Of `tmd_comparison` or `work_precision`.

    Returns
    -------
    dict
        The dimension and every variable by name, ``columns`` (what each of them is), ``at`` (coordinates
        without a dimension), ``meanings`` of codes, and the attributes.
    """
    (dimension,) = (str(name) for name in answer.sizes)
    arrays = {name: answer[name] for name in (dimension, *(str(name) for name in answer.data_vars))}
    return {
        **{name: array.values for name, array in arrays.items()},
        "columns": columns(answer),
        "at": {str(name): float(value) for name, value in answer.coords.items() if value.ndim == 0},
        "meanings": {
            name: {str(flag.value): flag.name.lower() for flag in flags}
            for name in arrays
            if name in VARIABLES and (flags := VARIABLES[name].flags) is not None
        },
        **answer.attrs,
    }


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
