"""What a ground-motion suite answers: its best dampers, and what to ask it instead of what only harmonic studies know."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from damperlab.studies.answers.faults import QueryFault, empty_range
from damperlab.studies.answers.selection import (
    check_dimension,
    check_metric,
    coded,
    completeness,
    count,
    dimensions_of,
    main_metric,
)
from damperlab.studies.faults import Fault, counted, describe, listing
from damperlab.studies.ground.builtin import whole_id
from damperlab.studies.ground.variables import DAMPER, RECORD
from damperlab.studies.kinds import SUITE, kind_of
from damperlab.studies.store.slabs import BUDGET, slabs
from damperlab.studies.variables import Status

MOST = 10_000
"""Most dampers in one answer."""


def require_harmonic(dimensions: Sequence[str], asked: str) -> None:
    """Raise `QueryFault` where a suite is asked for what only the response to a harmonic base has.

    Parameters
    ----------
    dimensions : sequence of str
        Of the study.
    asked : str
        The question, as it is called.
    """
    if kind_of(dimensions) is SUITE:
        raise QueryFault(
            Fault(
                "study",
                f"a ground-motion suite, over {listing(dimensions)}",
                f"a study of the response to a harmonic base for {asked}",
                "ask for a map over two of its dimensions, for its optimal designs, or for an export",
                f"This study is a ground-motion suite, and {asked} is a question about the response to a harmonic base.",
            )
        )


def worst_case_designs(
    cube: xr.Dataset,
    metric: str | None = None,
    top: int = 10,
    records: Sequence[str] | None = None,
    ranges: Mapping[str, tuple[float, float]] | None = None,
) -> xr.Dataset:
    """Rank the dampers of a suite by their worst case over its records, scales and structures.

    Parameters
    ----------
    cube : Dataset
        A suite's cube, read a slab of dampers at a time.
    metric : str, optional
        What counts, the smaller the better; the peak displacement against the base if not given.
    top : int
        How many, 1 to `MOST`.
    records : sequence of str, optional
        Only these records count, by id or by an earthquake's name.
    ranges : mapping of (float, float), optional
        Lowest and highest value of dimensions: of the dampers that are ranked, and of the cases that count.

    Returns
    -------
    Dataset
        Dimension rank, counted from 1. Coordinates along it: the four dimensions of the damper, and the record, scale and
        structure where its worst case is. Variables: `value`, and `growth` of the perturbed starts there where the suite
        keeps it. A damper with a case that failed or was not computed is left out. Attributes: `metric`, `designs` (all
        in the ranges), `failed`, `incomplete`, `complete`, `points`, `points_failed`, and `note`, which says it in words.

    Raises
    ------
    QueryFault
        If an argument is not allowed, or nothing of the grid is in a range.
    """
    metric = main_metric(cube) if metric is None else metric
    check_metric(cube, metric)
    if coded(cube, metric):
        told = f"{metric} holds codes, which have no order, so dampers cannot be ranked by it."
        raise QueryFault(Fault("metric", metric, "a quantity", "choose a metric that is a quantity", told))
    if not 1 <= top <= MOST:
        raise QueryFault(Fault("top", describe(top), f"a number from 1 to {MOST:,}", "ask for fewer"))
    part = cube.isel(_counting(cube, records, ranges or {}))
    cases = tuple(name for name in dimensions_of(part) if name not in DAMPER)
    extents = tuple(part.sizes[name] for name in cases)
    shape = tuple(part.sizes[name] for name in DAMPER)
    stored = dict(
        zip(dimensions_of(cube), cube["status"].encoding.get("chunks", cube["status"].shape), strict=True)
    )
    chunks = tuple(stored[name] for name in DAMPER)
    beside = [name for name in ("growth",) if name in part.data_vars and name != metric]
    best: dict[str, np.ndarray] = {}
    computed = points_failed = failed = incomplete = 0
    for box in slabs(shape, chunks, max(1, BUDGET // math.prod(extents))):
        slab = part.isel(dict(zip(DAMPER, box, strict=True)))
        status = _cases_last(slab["status"], cases)
        counts = count(status)
        computed, points_failed = computed + counts[0], points_failed + counts[1]
        bad = (status > Status.MAX_CYCLES).any(axis=-1)
        missing = (status == Status.NOT_COMPUTED).any(axis=-1) & ~bad
        failed, incomplete = failed + int(bad.sum()), incomplete + int(missing.sum())
        values = _cases_last(slab[metric], cases).astype(float)
        place = np.where(np.isnan(values), -np.inf, values).argmax(axis=-1)[..., None]
        found = {"value": np.take_along_axis(values, place, -1)[..., 0], "case": place[..., 0]}
        for name in beside:
            found[name] = np.take_along_axis(_cases_last(slab[name], cases), place, -1)[..., 0]
        where = np.meshgrid(
            *(np.arange(extent)[span] for extent, span in zip(shape, box, strict=True)), indexing="ij"
        )
        found |= dict(zip(DAMPER, where, strict=True))
        good = ~(bad | missing)
        best = _best(best, {name: array[good] for name, array in found.items()}, top)
    at_case = dict(zip(cases, np.unravel_index(best["case"], extents), strict=True))
    columns: dict[str, Any] = {
        name: ("rank", part[name].values[index], part[name].attrs)
        for name, index in ({name: best[name] for name in DAMPER} | at_case).items()
    }
    data = {"value": ("rank", best["value"], dict(part[metric].attrs))}
    data |= {name: ("rank", best[name], dict(part[name].attrs)) for name in beside}
    ranked = best["value"].size
    attributes = {
        "metric": metric,
        "designs": math.prod(shape),
        "failed": failed,
        "incomplete": incomplete,
        **completeness(computed, points_failed, int(part["status"].size)),
    }
    attributes["note"] = _note(part, metric, attributes, ranked)
    return xr.Dataset(data, {"rank": np.arange(1, ranked + 1), **columns}, attributes)


def _best(best: dict[str, np.ndarray], found: dict[str, np.ndarray], top: int) -> dict[str, np.ndarray]:
    """Take in the dampers of one slab; of equal values the earlier one stands."""
    if best:
        found = {name: np.concatenate((best[name], found[name])) for name in found}
    order = np.argsort(found["value"], kind="stable")[:top]
    return {name: array[order] for name, array in found.items()}


def _cases_last(array: xr.DataArray, cases: tuple[str, ...]) -> np.ndarray:
    """Read an array with the damper's dimensions in front, and all cases along one axis."""
    values = array.transpose(*DAMPER, *cases).values
    return np.asarray(values.reshape(*values.shape[: len(DAMPER)], -1))


def _counting(
    cube: xr.Dataset, records: Sequence[str] | None, ranges: Mapping[str, tuple[float, float]]
) -> dict[str, np.ndarray]:
    index: dict[str, np.ndarray] = {}
    if records is not None:
        known = cube[RECORD].values.tolist()
        for each in records:
            if whole_id(each) not in known:
                advice = "leave it out for all"
                raise QueryFault(Fault(RECORD, describe(each), f"one or more of {listing(known)}", advice))
        index[RECORD] = np.flatnonzero(np.isin(known, [whole_id(each) for each in records]))
    for name, (low, high) in ranges.items():
        check_dimension(cube, name, name, (RECORD,))
        values = cube[name].values
        inside = np.flatnonzero((values >= low) & (values <= high))
        if not inside.size:
            raise QueryFault(empty_range(name, name, low, high, values))
        index[name] = inside
    return index


def _note(part: xr.Dataset, metric: str, said: Mapping[str, Any], ranked: int) -> str:
    structures = part.sizes["natural_frequency_hz"] * part.sizes["damping_ratio"]
    met = (
        counted(part.sizes[RECORD], "record"),
        counted(part.sizes["scale"], "scale"),
        counted(structures, "structure"),
    )
    long_name = part[metric].attrs.get("long_name", metric)
    sentences = [f"Ranked by the largest {long_name} over {', '.join(met)}; smaller is better."]
    left_out = [
        f"{said[name]} {why}"
        for name, why in (("failed", "with a case that failed"), ("incomplete", "not computed yet"))
        if said[name]
    ]
    if left_out:
        sentences.append(f"Left out of {counted(said['designs'], 'damper')}: {', '.join(left_out)}.")
    if not ranked:
        sentences.append("No damper is left.")
    return " ".join(sentences)
