"""Answers as documents: what HTTP sends and what the command line prints with --json."""

from typing import Any

import numpy as np
import xarray as xr

from damperlab.service.columns import columns
from damperlab.studies.variables import VARIABLES, dimensions_of


def map_document(answer: xr.Dataset, metric: str) -> dict[str, Any]:
    """Put a resonance map into a document.

    Parameters
    ----------
    answer : Dataset
        Of `damperlab.studies.answers.resonance_map`, dimensions (y, x).
    metric : str
        The variable that was asked for.

    Returns
    -------
    dict
        ``x`` and ``y`` (the grid values), ``values`` as [y][x], and beside them, in the same shape, what
        says how far a value can be trusted; ``at`` the grid point of the other dimensions, ``note`` that
        choice in words, ``columns`` what each of them is.
    """
    y, x = (str(name) for name in answer[metric].dims)
    return {
        "x_dimension": x,
        "y_dimension": y,
        "x": answer[x].values,
        "y": answer[y].values,
        **_described(answer, metric),
    }


def response_document(answer: xr.Dataset, metric: str) -> dict[str, Any]:
    """Put a frequency response into a document.

    Parameters
    ----------
    answer : Dataset
        Of `damperlab.studies.answers.frequency_response`.
    metric : str
        The variable that was asked for.

    Returns
    -------
    dict
        ``frequency_ratio`` and ``values``, one entry a frequency, and the rest as in `map_document`.
    """
    return {"frequency_ratio": answer["frequency_ratio"].values, **_described(answer, metric)}


def designs_document(answer: xr.Dataset) -> dict[str, Any]:
    """Put ranked designs into a document.

    Parameters
    ----------
    answer : Dataset
        Of `optimal_designs`, `pareto_front`, or `merged_designs`, dimension rank.

    Returns
    -------
    dict
        ``designs``, the best first, each with its coordinates, ``value``, ``error``, ``response_class``
        by name and what else the answer says of it; ``designs_total``, and the counts of those that were left out.
    """
    first = ("rank", *dimensions_of(answer.coords), "value", "error", "response_class")
    names_of = (*first, *(str(name) for name in answer.data_vars if name not in first))
    rows = zip(*(answer[name].values.tolist() for name in names_of), strict=True)
    names = _flags("response_class")
    designs = [dict(zip(names_of, row, strict=True)) for row in rows]
    for design in designs:
        design["response_class"] = names[str(design["response_class"])]
    said = {str(name): value for name, value in answer.attrs.items()}
    said["designs_total"] = said.pop("designs")
    return {
        "units": "1",
        "long_name": answer["value"].attrs["long_name"],
        "designs": designs,
        "columns": columns(answer),
        **said,
    }


def ranking_document(answer: xr.Dataset) -> dict[str, Any]:
    """Put a ranking into a document: `designs_document`, or `worst_document` of dampers ranked by their worst case."""
    return worst_document(answer) if "metric" in answer.attrs else designs_document(answer)


def worst_document(answer: xr.Dataset) -> dict[str, Any]:
    """Put dampers that are ranked by their worst case into a document.

    Parameters
    ----------
    answer : Dataset
        Of `worst_case_designs`, dimension rank.

    Returns
    -------
    dict
        ``designs``, the best first, each with its damper, where its worst case is, and ``value``; ``designs_total``, and
        the counts of those that were left out.
    """
    names = ("rank", *(str(name) for name in answer.coords if name != "rank"), *map(str, answer.data_vars))
    rows = zip(*(answer[name].values.tolist() for name in names), strict=True)
    designs = [dict(zip(names, row, strict=True)) for row in rows]
    flags = _flags("response_class")
    for design in designs:
        if "response_class" in design:
            design["response_class"] = flags[str(design["response_class"])]
    said = {str(name): value for name, value in answer.attrs.items()}
    said["designs_total"] = said.pop("designs")
    return {
        "units": answer["value"].attrs["units"],
        "long_name": answer["value"].attrs["long_name"],
        "designs": designs,
        "columns": columns(answer),
        **said,
    }


def _described(answer: xr.Dataset, metric: str) -> dict[str, Any]:
    beside = {str(name): array.values for name, array in answer.data_vars.items() if name != metric}
    known = [VARIABLES[str(name)] for name in answer.data_vars if name in VARIABLES]
    return {
        "metric": metric,
        "units": answer[metric].attrs.get("units", "1"),
        "long_name": answer[metric].attrs.get("long_name", metric),
        "values": answer[metric].values,
        **beside,
        "meanings": {variable.name: _flags(variable.name) for variable in known if variable.flags},
        "at": {str(name): value.item() for name, value in answer.coords.items() if np.ndim(value) == 0},
        "columns": columns(answer),
        **answer.attrs,
    }


def _flags(name: str) -> dict[str, str]:
    flags = VARIABLES[name].flags
    assert flags is not None
    return {str(flag.value): flag.name.lower() for flag in flags}
