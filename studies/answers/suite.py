"""The best dampers of a ground-motion suite or over base amplitudes, and what to ask of such studies instead of others."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from damperlab.studies.amplitudes import AMPLITUDE
from damperlab.studies.answers.ends import ends_of_damper
from damperlab.studies.answers.excited import amplitude_called
from damperlab.studies.answers.faults import QueryFault, empty_range
from damperlab.studies.answers.nearness import inside as within
from damperlab.studies.answers.phrases import Phrases
from damperlab.studies.answers.selection import (
    check_dimension,
    check_metric,
    coded,
    completeness,
    count,
    dimensions_of,
    main_metric,
    require_stored,
)
from damperlab.studies.brief import PLACES, Brief, Damper, Note, damper_of, listed, notes_document
from damperlab.studies.faults import Fault, counted, describe, listing
from damperlab.studies.ground.builtin import whole_id
from damperlab.studies.ground.variables import RECORD
from damperlab.studies.kinds import AMPLITUDES, SUITE, kind_of
from damperlab.studies.store.export.slabs import BUDGET, slabs
from damperlab.studies.units import coordinates_in_units
from damperlab.studies.variables import ResponseClass, Status

MOST = 10_000
"""Most dampers in one answer."""

_MET = {"frequency_ratio": "frequencies", "damping_ratio": "damping ratios of the structure"}
_LEFT_OUT = {
    "failed": "with a case that failed",
    "incomplete": "not computed yet",
    "locked": "locked to the base near resonance at every base amplitude",
}


def require_harmonic(dimensions: Sequence[str], asked: str, amplitudes: bool = False) -> None:
    """Raise `QueryFault` where a study is asked for what only others of the response to a harmonic base have.

    Parameters
    ----------
    dimensions : sequence of str
        Of the study.
    asked : str
        The question, as it is called.
    amplitudes : bool
        Whether a study over base amplitudes can be asked too.
    """
    kind = kind_of(dimensions)
    if kind is AMPLITUDES and not amplitudes:
        raise QueryFault(
            Fault(
                "study",
                f"{kind.words}, over {listing(dimensions)}",
                f"a study with one base amplitude for {asked}",
                _instead(asked),
                f"This study is {kind.words}, and {asked} is a question about a study with one base amplitude.",
            )
        )
    if kind is SUITE:
        raise QueryFault(
            Fault(
                "study",
                f"a ground-motion suite, over {listing(dimensions)}",
                f"a study of the response to a harmonic base for {asked}",
                "ask for a map over two of its dimensions, for its optimal designs, or for an export",
                f"This study is a ground-motion suite, and {asked} is a question about the response to a harmonic base.",
            )
        )


def _instead(asked: str) -> str:
    """Say what to ask a study over base amplitudes in place of a question that it does not answer."""
    if asked in ("refine", "follow-ups"):
        return (
            "submit it again with finer axes of clearance_m and friction_force_n about its best damper, or with one base "
            "amplitude; points that are known are not computed again"
        )
    return "ask for a map, a response or its optimal designs, or submit the study with one base amplitude"


def worst_case_designs(
    cube: xr.Dataset,
    metric: str | None = None,
    top: int = 10,
    records: Sequence[str] | None = None,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    exclude_locked: bool = False,
) -> xr.Dataset:
    """Rank dampers by their worst case: over the records, scales and structures of a suite, or over base amplitudes.

    Parameters
    ----------
    cube : Dataset
        Of a ground-motion suite or of a study over base amplitudes, read a slab of dampers at a time.
    metric : str, optional
        What counts, the smaller the better; the peak displacement against the base, or the amplitude ratio, if not given.
    top : int
        How many, 1 to `MOST`.
    records : sequence of str, optional
        Only these records count, by id or by an earthquake's name.
    ranges : mapping of (float, float), optional
        Lowest and highest value of dimensions: of the dampers that are ranked, and of the cases that count.
    exclude_locked : bool
        Leave out dampers whose friction locks the mass to its base at every base amplitude, near resonance.

    Returns
    -------
    Dataset
        Dimension rank, counted from 1. Coordinates along it: the four dimensions of the damper, and those of the case
        that is its worst. Variables: `value`, and what the study keeps of that case beside it: `growth` of the perturbed
        starts, `error` of an amplitude, `response_class`. A damper with a case that failed or was not computed is left
        out. Attributes: `metric`, `designs` (all in the ranges), `failed`, `incomplete`, `locked`, `complete`, `points`,
        `points_failed`, and `note`, which says it in words.

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
    damper = kind_of(cube.sizes).designs
    counting = _counting(cube, records, ranges or {})
    part = cube.isel(counting)
    cases = tuple(name for name in dimensions_of(part) if name not in damper)
    extents = tuple(part.sizes[name] for name in cases)
    shape = tuple(part.sizes[name] for name in damper)
    if exclude_locked:
        require_stored(cube, "exclude_locked", "response_class")
    stored = dict(
        zip(dimensions_of(cube), cube["status"].encoding.get("chunks", cube["status"].shape), strict=True)
    )
    chunks = tuple(stored[name] for name in damper)
    beside = _beside(part, metric)
    best: dict[str, np.ndarray] = {}
    computed = points_failed = failed = incomplete = locked = 0
    for box in slabs(shape, chunks, max(1, BUDGET // math.prod(extents))):
        slab = part.isel(dict(zip(damper, box, strict=True)))
        status = _cases_last(slab["status"], damper, cases)
        counts = count(status)
        computed, points_failed = computed + counts[0], points_failed + counts[1]
        bad = (status > Status.MAX_CYCLES).any(axis=-1)
        missing = (status == Status.NOT_COMPUTED).any(axis=-1) & ~bad
        failed, incomplete = failed + int(bad.sum()), incomplete + int(missing.sum())
        held = _locked(slab, damper) & ~(bad | missing) if exclude_locked else np.zeros_like(bad)
        locked += int(held.sum())
        values = _cases_last(slab[metric], damper, cases).astype(float)
        place = np.where(np.isnan(values), -np.inf, values).argmax(axis=-1)[..., None]
        found = {"value": np.take_along_axis(values, place, -1)[..., 0], "case": place[..., 0]}
        for name, source in beside.items():
            found[name] = np.take_along_axis(_cases_last(slab[source], damper, cases), place, -1)[..., 0]
        where = np.meshgrid(
            *(np.arange(extent)[span] for extent, span in zip(shape, box, strict=True)), indexing="ij"
        )
        found |= dict(zip(damper, where, strict=True))
        good = ~(bad | missing | held)
        best = _best(best, {name: array[good] for name, array in found.items()}, top)
    at_case = dict(zip(cases, np.unravel_index(best["case"], extents), strict=True))
    columns: dict[str, Any] = {
        name: ("rank", part[name].values[index], part[name].attrs)
        for name, index in ({name: best[name] for name in damper} | at_case).items()
    }
    data = {"value": ("rank", best["value"], dict(part[metric].attrs))}
    data |= {name: ("rank", best[name], dict(part[source].attrs)) for name, source in beside.items()}
    ranked = best["value"].size
    attributes = {
        "metric": metric,
        "designs": math.prod(shape),
        "failed": failed,
        "incomplete": incomplete,
        **({"locked": locked} if exclude_locked else {}),
        **completeness(computed, points_failed, int(part["status"].size)),
    }
    attributes["note"] = _note(part, metric, attributes, ranked)
    ends: dict[str, list[Any]] = {}
    if ranked:
        # along its whole axis, whatever range was asked for
        first = {
            name: int(counting[name][best[name][0]] if name in counting else best[name][0]) for name in damper
        }
        ends = ends_of_damper(cube, metric, counting, first)
    attributes["notes"] = notes_document([Note("end_of_range", "hint", ends)] if ends else [])
    answer = xr.Dataset(data, {"rank": np.arange(1, ranked + 1), **columns}, attributes)
    answer.attrs["brief"] = _brief(cube, answer, damper, ends).document()
    answer.attrs["verdict"] = answer.attrs["brief"]["sentences"]
    return answer


def _best(best: dict[str, np.ndarray], found: dict[str, np.ndarray], top: int) -> dict[str, np.ndarray]:
    """Take in the dampers of one slab; of equal values the earlier one stands."""
    if best:
        found = {name: np.concatenate((best[name], found[name])) for name in found}
    order = np.argsort(found["value"], kind="stable")[:top]
    return {name: array[order] for name, array in found.items()}


def _beside(part: xr.Dataset, metric: str) -> dict[str, str]:
    """Name what is told of a worst case beside its value, and the variables that it is read from."""
    found = {"growth": "growth", "response_class": "response_class"}
    if metric in ("amplitude_ratio", "amplitude_m"):
        found["error"] = metric.replace("amplitude", "amplitude_error").removesuffix("_ratio")
    return {name: source for name, source in found.items() if source in part.data_vars and source != metric}


def _locked(slab: xr.Dataset, damper: tuple[str, ...]) -> np.ndarray:
    """Say which dampers are locked in every case at the frequency nearest resonance."""
    nearest = int(np.abs(slab["frequency_ratio"].values - 1.0).argmin())
    classes = slab["response_class"].isel(frequency_ratio=nearest)
    met = tuple(str(name) for name in classes.dims if name not in damper)
    return np.asarray((_cases_last(classes, damper, met) == ResponseClass.LOCKED).all(axis=-1))


def _cases_last(array: xr.DataArray, damper: tuple[str, ...], cases: tuple[str, ...]) -> np.ndarray:
    """Read an array with the damper's dimensions in front, and all cases along one axis."""
    values = array.transpose(*damper, *cases).values
    return np.asarray(values.reshape(*values.shape[: len(damper)], -1))


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
    units = {each.name: each for each in coordinates_in_units(cube)}
    for asked, (low, high) in ranges.items():
        name = asked
        if asked in units:
            name, low, high = (units[asked].source, *(end / units[asked].factor for end in (low, high)))
        check_dimension(cube, asked, name, (RECORD,))
        values = cube[name].values
        inside = np.flatnonzero(within(values, low, high))
        if not inside.size:
            raise QueryFault(empty_range(asked, name, low, high, values))
        index[name] = inside
    return index


def _brief(
    cube: xr.Dataset, answer: xr.Dataset, damper: tuple[str, ...], ends: Mapping[str, list[Any]]
) -> Brief:
    """Say which damper is best, under what it does worst, and what comes next."""
    if not answer.sizes["rank"]:
        return Brief(None, (f"No damper is left of {answer.attrs['designs']:,}.",))
    phrases, metric = Phrases.of(cube), str(answer.attrs["metric"])
    # a suite has its dampers in SI units itself
    varied = [name for name in damper if cube.sizes[name] > 1]
    met = [
        str(name) for name in answer.coords if name != "rank" and name not in damper and cube.sizes[name] > 1
    ]

    def spelled(rank: int) -> tuple[str, str, str]:
        row = {str(name): answer[name].values[rank].item() for name in (*varied, *met, "value")}
        value = phrases.value(metric, row["value"], ".3g")
        if not phrases.unit(metric):
            value += f" {answer['value'].attrs.get('units', '1')}".removesuffix(" 1")
        where = [row[name] if name == RECORD else phrases.equal(name, row[name], ".3g") for name in met]
        return value, ", ".join(phrases.equal(name, row[name], ".3g") for name in varied), ", ".join(where)

    value, design, where = spelled(0)
    sentences = [
        f"Best damper: {design or 'the only one'}. At worst {value}{f', at {where}' if where else ''}."
    ]
    if answer.attrs["complete"] < 1:
        sentences.append(f"So far: {answer.attrs['complete']:.0%} of the points are computed.")
    if ends:
        sentences.append(f"It lies at the end of {listed(map(phrases.symbol, ends))}.")
    rows = [(PLACES[rank], *spelled(rank)[:2]) for rank in range(1, min(answer.sizes["rank"], len(PLACES)))]
    beyond = ", ".join(
        f"{phrases.label(name)} {'above' if end == 'upper' else 'below'} {phrases.value(name, at, '.3g')}"
        for name, (end, at) in ends.items()
    )
    return Brief(_kind(answer), tuple(sentences), tuple(rows), f"{beyond}." if beyond else "")


def _kind(answer: xr.Dataset) -> Damper:
    """Name the best damper by its parts."""
    mass = float(answer["mass_ratio" if "mass_ratio" in answer.coords else "particle_mass_kg"].values[0])
    friction = float(answer["friction_force_n"].values[0])
    return damper_of(mass > 0.0, friction > 0.0)


def _note(part: xr.Dataset, metric: str, said: Mapping[str, Any], ranked: int) -> str:
    met: tuple[str, ...]
    if kind_of(part.sizes) is SUITE:
        structures = part.sizes["natural_frequency_hz"] * part.sizes["damping_ratio"]
        met = (
            counted(part.sizes[RECORD], "record"),
            counted(part.sizes["scale"], "scale"),
            counted(structures, "structure"),
        )
    else:
        met = (counted(part.sizes[AMPLITUDE], amplitude_called(part)),)
        met += tuple(f"{part.sizes[n]} {words}" for n, words in _MET.items() if part.sizes[n] > 1)
    long_name = part[metric].attrs.get("long_name", metric)
    sentences = [
        f"Ranked by the largest {long_name.removeprefix('largest ')} over {', '.join(met)}; smaller is better."
    ]
    left_out = [f"{said[name]} {why}" for name, why in _LEFT_OUT.items() if said.get(name)]
    if left_out:
        sentences.append(f"Left out of {counted(said['designs'], 'damper')}: {', '.join(left_out)}.")
    if not ranked:
        sentences.append("No damper is left.")
    return " ".join(sentences)
