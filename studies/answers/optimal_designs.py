"""The best designs: every point of the five design dimensions judged by its response over the frequency."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from studies.answers.design_question import DESIGN, FREQUENCY, METRIC, OBJECTIVES, DesignQuestion
from studies.faults import counted
from studies.store.slabs import BUDGET, slabs
from studies.variables import DIMENSIONS, ResponseClass, Status


def optimal_designs(
    cube: xr.Dataset,
    objective: str = "resonance",
    band: tuple[float, float] | None = None,
    top: int = 10,
    exclude_locked: bool = False,
    max_impact_speed: float | None = None,
    ranges: Mapping[str, tuple[float, float]] | None = None,
) -> xr.Dataset:
    """Rank the designs of a cube.

    A design is judged only if every frequency that counts was computed and has a value. Means over a band are
    integrals by the trapezoidal rule over the frequencies of the grid.

    Parameters
    ----------
    cube : Dataset
        A study's cube, read slab by slab.
    objective : str
        One of `OBJECTIVES`.
    band : (float, float), optional
        Lowest and highest frequency ratio that count; every frequency without it.
    top : int
        How many designs, 1 to `MOST`.
    exclude_locked : bool
        Leave out designs that friction locks to the base at the judged frequency nearest r = 1: the trivial
        optimum.
    max_impact_speed : float, optional
        Leave out designs that impact faster than this anywhere in the band, over Z·ω_n.
    ranges : mapping of (float, float), optional
        Lowest and highest value of design dimensions.

    Returns
    -------
    Dataset
        Dimension rank, counted from 1; shorter than `top` where fewer designs qualify. Coordinates along it:
        the five design dimensions, and `frequency_ratio`, where the amplitude in the band is largest.
        Variables: `value`, its `error` (that of a peak at the peak, of a mean the weighted mean error, since
        errors of a periodic response do not average out; NaN where the study keeps none), `response_class`
        at `frequency_ratio`, and `locked_share`, the share of the judged frequencies at which the mass is
        locked. Attributes: `objective`, `designs` (all in the ranges), `incomplete`, `failed`, `locked`,
        `too_fast` (those left out, by reason), `complete` (share of the designs that were computed), `band`,
        `frequencies`, and `note`, which says it in words.

    Raises
    ------
    QueryFault
        If an argument is not allowed, nothing of the grid is in a range, or the study keeps no variable that
        is needed.
    """
    question = DesignQuestion.ask(cube, objective, band, top, exclude_locked, max_impact_speed, ranges or {})
    tally = dict.fromkeys(("designs", "incomplete", "failed", "locked", "too_fast"), 0)
    best = _Ranking(top)
    shape = tuple(question.axes[name].size for name in DESIGN)
    chunks = cube[METRIC].encoding.get("chunks", cube[METRIC].shape)
    frequencies = question.axes[FREQUENCY].size
    for slab in slabs(shape, tuple(chunks[:-1]), max(1, BUDGET // frequencies)):
        index = {name: question.axes[name][part] for name, part in zip(DESIGN, slab, strict=True)}
        index[FREQUENCY] = question.axes[FREQUENCY]
        best.take(_judge(cube, question, index, tally))
    return _answer(cube, question, best, tally)


def _judge(
    cube: xr.Dataset, question: DesignQuestion, index: Mapping[str, np.ndarray], tally: dict[str, int]
) -> dict[str, np.ndarray]:
    """Judge the designs of one slab; one row for each that qualifies."""

    def load(name: str) -> np.ndarray:
        """Give (design, frequency)."""
        values = cube[name].isel(index).transpose(*DIMENSIONS).values
        return np.asarray(values.reshape(-1, question.frequencies.size))

    status = load("status")
    amplitude = load(METRIC)
    missing = (status == Status.NOT_COMPUTED).any(axis=1)
    bad = ~missing & ((status > Status.MAX_CYCLES) | ~np.isfinite(amplitude)).any(axis=1)
    keep = ~missing & ~bad
    tally["designs"] += keep.size
    tally["incomplete"] += int(missing.sum())
    tally["failed"] += int(bad.sum())
    nothing = np.full_like(amplitude, np.nan)
    error = load("amplitude_error") if "amplitude_error" in cube else nothing
    kind = load("response_class") if "response_class" in cube else np.full_like(status, -1)
    locked = kind == ResponseClass.LOCKED
    if question.exclude_locked:
        tally["locked"] += int((keep & locked[:, question.nearest]).sum())
        keep &= ~locked[:, question.nearest]
    if question.max_impact_speed is not None:
        # no impact, no speed: a missing one is no reason to leave a design out
        too_fast = (load("impact_speed_max") > question.max_impact_speed).any(axis=1)
        tally["too_fast"] += int((keep & too_fast).sum())
        keep &= ~too_fast
    rows = np.flatnonzero(keep)
    amplitude, error, kind, locked = amplitude[rows], error[rows], kind[rows], locked[rows]
    place = amplitude.argmax(axis=1) if rows.size else np.zeros(0, np.intp)
    each = np.arange(rows.size)
    value, doubt = _weigh(question, amplitude, error, place)
    corner = np.unravel_index(rows, [index[name].size for name in DESIGN])
    found = {name: index[name][at] for name, at in zip(DESIGN, corner, strict=True)}
    found |= {FREQUENCY: question.axes[FREQUENCY][place], "value": value, "error": doubt}
    found |= {"response_class": kind[each, place], "locked_share": locked.mean(axis=1)}
    return found


def _weigh(
    question: DesignQuestion, amplitude: np.ndarray, error: np.ndarray, place: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Value and error of each design; the errors are carried through to first order, all with one sign."""
    if question.objective in ("resonance", "peak"):
        each = np.arange(place.size)
        return amplitude[each, place], error[each, place]
    if question.objective == "band_mean":
        return amplitude @ question.weights, error @ question.weights
    rms = np.sqrt(amplitude**2 @ question.weights)
    return rms, (amplitude * error) @ question.weights / np.where(rms > 0, rms, 1.0)


class _Ranking:
    """The best designs so far."""

    def __init__(self, top: int) -> None:
        self._top = top
        self.found: dict[str, np.ndarray] = {}

    def take(self, found: dict[str, np.ndarray]) -> None:
        """Take in the designs of one slab; of equal values the earlier one stands."""
        if self.found:
            found = {name: np.concatenate((self.found[name], found[name])) for name in found}
        order = np.argsort(found["value"], kind="stable")[: self._top]
        self.found = {name: array[order] for name, array in found.items()}


def _answer(
    cube: xr.Dataset, question: DesignQuestion, best: _Ranking, tally: Mapping[str, int]
) -> xr.Dataset:
    found = best.found
    described: dict[str, dict[str, Any]] = {
        "value": {"units": "1", "long_name": OBJECTIVES[question.objective]},
        "error": {"units": "1", "long_name": f"error of the {OBJECTIVES[question.objective]}"},
        "response_class": dict(cube["response_class"].attrs) if "response_class" in cube else {},
        "locked_share": {
            "units": "1",
            "long_name": "share of the judged frequencies at which the mass is locked",
        },
    }
    variables = {name: ("rank", found[name], attributes) for name, attributes in described.items()}
    coordinates: dict[str, Any] = {"rank": np.arange(1, found["value"].size + 1)}
    for name in (*DESIGN, FREQUENCY):
        coordinates[name] = ("rank", cube[name].values[found[name]], dict(cube[name].attrs))
    judged = tally["designs"] - tally["incomplete"]
    attributes = {
        "objective": question.objective,
        "band": [float(question.frequencies[0]), float(question.frequencies[-1])],
        "frequencies": int(question.frequencies.size),
        "complete": judged / tally["designs"],
        **tally,
        "note": _note(question, tally, cube.sizes[FREQUENCY], int(found["value"].size)),
    }
    return xr.Dataset(variables, coordinates, attributes)


def _note(question: DesignQuestion, tally: Mapping[str, int], computed: int, ranked: int) -> str:
    low, high = question.frequencies[0], question.frequencies[-1]
    sentences = [f"Ranked by the {OBJECTIVES[question.objective]}; smaller is better."]
    if question.frequencies.size == 1:
        why = "was computed" if computed == 1 else "counts here"
        sentences.append(
            f"Only one frequency {why}, r = {low:.10g}: the judgement holds at that frequency only. "
            "A particle that rides on the wall moves the resonance, so judge a design over a band before building it."
        )
    else:
        sentences.append(
            f"Judged at {question.frequencies.size} frequencies from r = {low:.10g} to {high:.10g}."
        )
    reasons = {
        "incomplete": "not computed yet at every frequency that counts",
        "failed": "failed at a frequency that counts",
        "locked": "locked to the base near resonance",
        "too_fast": "impact faster than allowed",
    }
    left_out = [f"{tally[name]} {reason}" for name, reason in reasons.items() if tally[name]]
    if left_out:
        sentences.append(f"Left out of {counted(tally['designs'], 'design')}: {', '.join(left_out)}.")
    if ranked == 0:
        sentences.append("No design is left.")
    return " ".join(sentences)
