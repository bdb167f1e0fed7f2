"""Robust designs: force and clearance are fixed, the base amplitude is not, and the worst case counts.

A physical damper is a ray in the (d/Z, γ_F) plane: when the base amplitude grows by a factor a, both ratios shrink
by it. A ray is judged by its largest value over a range of amplitudes.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
import xarray as xr

from damperlab.studies.answers.contenders import ties
from damperlab.studies.answers.design_question import FREQUENCY, DesignQuestion
from damperlab.studies.answers.faults import QueryFault
from damperlab.studies.answers.judging import attributes_of, judge, new_tally, say_judged, say_limits
from damperlab.studies.answers.nearness import SAME
from damperlab.studies.answers.phrases import AMPLITUDE, RATIOS, Phrases, said
from damperlab.studies.answers.ranked_peaks import RankedPeaks
from damperlab.studies.answers.selection import require_stored
from damperlab.studies.answers.verdict import say_ties
from damperlab.studies.brief import PLACES, Brief, damper_of
from damperlab.studies.faults import Fault, counted
from damperlab.studies.questions import MOST_DESIGNS, Judging
from damperlab.studies.store.export.slabs import BUDGET
from damperlab.studies.variables import DIMENSIONS

RAY = ("clearance_ratio", "friction_ratio")
OTHERS = ("damping_ratio", "restitution", "mass_ratio")
MOST_AMPLITUDES = 200
ROUNDING = 1e-9


@dataclass(frozen=True)
class _Track:
    """Where rays from every nominal value of one axis meet the grid."""

    index: np.ndarray  # (nominal, amplitude), -1 beyond the axis
    distance: np.ndarray  # of the grid point from the ray, relative to the wanted value


def robust_designs(
    cube: xr.Dataset,
    amplitudes: tuple[float, float],
    judging: Judging = Judging(),
    top: int = 10,
) -> xr.Dataset:
    """Rank physical dampers by their worst case while the base amplitude varies.

    A damper is named by its clearance and friction ratios at the nominal amplitude, a grid point. At `a` times
    that amplitude it is at (d/Z)/a and γ_F/a, of which the nearest grid point is taken, in the ratio; nothing
    is interpolated, and `distance` says how far off the ray the worst of them lies. A grid with logarithmic
    axes of equal steps holds such rays exactly. A ray that leaves the grid, or meets a point without a value,
    is not judged.

    Parameters
    ----------
    cube : Dataset
        A study's cube; one plane of it is held at a time.
    amplitudes : (float, float)
        Lowest and highest base amplitude, over the nominal one; above 0.
    judging : Judging
        What one point is judged by, as in `optimal_designs`. Of locked dampers those are excluded that friction locks to the
        base at the judged frequency nearest r = 1 over the whole range of amplitudes; ranges are limits of the nominal values
        of the design dimensions, and of results at every amplitude.
    top : int
        How many dampers.

    Returns
    -------
    Dataset
        Dimension rank. Coordinates: the five design dimensions at the nominal amplitude. Variables: `value`
        (the worst case) with `error`; `amplitude` at which it is met, `frequency_ratio`, `response_class` and
        the grid point used there (`clearance_ratio_used`, `friction_ratio_used`); `best_case`;
        `nominal`, the value at a = 1 (NaN where 1 is outside the range); `distance`. Attributes as of
        `optimal_designs`, with `amplitudes` (those judged), `rays`, `left_grid`, `unknown`, and `confidence`,
        `as_good`, `chance_of_another` as of `verdict.verdict`, by the limits of all amplitudes of each damper.

    Raises
    ------
    QueryFault
        If an argument is not allowed, or no ray stays on the grid over the range.
    """
    low, high = amplitudes
    if not (0 < low <= high < math.inf):
        shown = f"{low:.10g} to {high:.10g}"
        raise QueryFault(
            Fault(
                "amplitudes",
                shown,
                "two numbers above 0, the lower one first",
                "write 0.5,2 for half to twice",
            )
        )
    if judging.exclude_locked:
        require_stored(cube, "exclude_locked", "response_class")
    limits = {name: limit for name, limit in judging.ranges.items() if name not in DIMENSIONS}
    question = DesignQuestion.ask(cube, replace(judging, exclude_locked=False, ranges=limits), top)
    nominal = DesignQuestion.ask(cube, judging, top).axes
    factors = _factors(cube, low, high)
    tracks = {name: _track(cube[name].values, factors) for name in RAY}
    tally = new_tally() | {"rays": 0, "left_grid": 0, "unknown": 0}
    best: dict[str, np.ndarray] = {}
    for corner in product(*(nominal[name] for name in OTHERS)):
        place = dict(zip(OTHERS, corner, strict=True))
        plane = _plane(cube, question, place, tally)
        found = _rays(
            cube, plane, tracks, {name: nominal[name] for name in RAY}, judging.exclude_locked, tally
        )
        found |= {name: np.full(found["value"].size, at) for name, at in place.items()}
        if best:
            found = {name: np.concatenate((best[name], found[name])) for name in found}
        order = np.argsort(found["value"], kind="stable")[:MOST_DESIGNS]
        best = {name: array[order] for name, array in found.items()}
    if tally["left_grid"] == tally["rays"]:
        span = _span(cube, nominal)
        raise QueryFault(
            Fault(
                "amplitudes",
                f"{low:.10g} to {high:.10g}, over which every ray leaves the grid",
                f"a range with a ratio of at most {span:.4g}",
                "narrow it, or compute a study with longer axes of clearance and friction",
                f"Over amplitudes from {low:.10g} to {high:.10g} every design leaves the study's grid; the ratio of the two "
                f"may be at most {span:.4g}.",
            )
        )
    equals = ties(best["value"], best["lowest"], best["highest"], question.standard_errors)
    answer = _answer(cube, question, factors, {name: array[:top] for name, array in best.items()}, tally)
    answer.attrs |= equals

    peaks = RankedPeaks.of(cube, question, _used(answer))

    def note(phrases: Phrases) -> dict[str, Any]:
        words = _note(cube, question, factors, answer, peaks, phrases)
        brief = _brief(cube, answer, peaks, phrases)
        return {
            "note": f"{words} {say_ties(equals)}".strip(),
            "verdict": list(brief.sentences),
            "brief": brief.document(),
        }

    answer.attrs |= said(cube, note)
    return answer


def _factors(cube: xr.Dataset, low: float, high: float) -> np.ndarray:
    """Amplitudes to judge: in equal ratios, no coarser than the finest step of either axis."""
    steps = [
        float(np.diff(np.log(axis)).min())
        for name in RAY
        if (axis := np.sort(cube[name].values[cube[name].values > 0])).size > 1
    ]
    if not steps or low == high:
        return np.unique([low, high])
    number = min(MOST_AMPLITUDES, math.ceil(math.log(high / low) / min(steps) - ROUNDING) + 1)
    return np.geomspace(low, high, max(2, number))


def _track(axis: np.ndarray, factors: np.ndarray) -> _Track:
    """Find the nearest grid point, in the ratio, to each nominal value over each factor."""
    wanted = axis[:, None] / factors
    if (axis <= 0).all():
        return _Track(np.zeros(wanted.shape, np.intp), np.zeros(wanted.shape))
    positive = np.flatnonzero(axis > 0)
    positive = positive[np.argsort(axis[positive])]
    logs = np.log(axis[positive])
    with np.errstate(divide="ignore"):
        nearest = positive[np.searchsorted((logs[1:] + logs[:-1]) / 2, np.log(wanted))]
    distance = np.abs(axis[nearest] / np.where(wanted > 0, wanted, 1.0) - 1)
    inside = (wanted >= axis[positive].min() * (1 - ROUNDING)) & (wanted <= axis.max() * (1 + ROUNDING))
    index = np.where(inside, nearest, -1)
    # no friction stays no friction at any amplitude
    zero = axis <= 0
    index[zero] = np.flatnonzero(zero)[:, None]
    distance[zero] = 0.0
    return _Track(index, distance)


def _span(cube: xr.Dataset, nominal: Mapping[str, np.ndarray]) -> float:
    """The largest ratio of two amplitudes over which a ray may stay on the grid."""
    spans = {
        name: float(axis.max() / axis.min())
        for name in RAY
        if (axis := cube[name].values[cube[name].values > 0]).size
    }
    if (cube[RAY[1]].values[nominal[RAY[1]]] <= 0).any():
        spans.pop(RAY[1], None)  # the ray of no friction moves along the clearance alone
    return min(spans.values(), default=1.0)


def _plane(
    cube: xr.Dataset, question: DesignQuestion, place: Mapping[str, int], tally: dict[str, int]
) -> dict[str, np.ndarray]:
    """Judge every point of one (d/Z, γ_F) plane, a row of clearance at a time; NaN where there is no value."""
    shape = (cube.sizes[RAY[0]], cube.sizes[RAY[1]])
    plane = {name: np.full(shape, np.nan) for name in ("value", "error", "lowest", "highest")}
    plane |= {name: np.full(shape, -1, np.int64) for name in ("response_class", FREQUENCY)}
    plane["locked_near_resonance"] = np.zeros(shape, np.bool_)
    chunk = cube["amplitude_ratio"].encoding.get("chunks", cube["amplitude_ratio"].shape)[3]
    for start in range(0, shape[0], chunk):
        index = {name: np.array([at]) for name, at in place.items()}
        index |= {RAY[0]: np.arange(start, min(start + chunk, shape[0])), RAY[1]: np.arange(shape[1])}
        index[FREQUENCY] = question.axes[FREQUENCY]
        found = judge(cube, question, index, tally)
        for name, array in plane.items():
            array[found[RAY[0]], found[RAY[1]]] = found[name]
    return plane


def _rays(
    cube: xr.Dataset,
    plane: Mapping[str, np.ndarray],
    tracks: Mapping[str, _Track],
    nominal: Mapping[str, np.ndarray],
    exclude_locked: bool,
    tally: dict[str, int],
) -> dict[str, np.ndarray]:
    """Judge the rays through every nominal grid point of a plane; one row for each that stays on known points."""
    amplitudes = tracks[RAY[0]].index.shape[1]
    parts = np.array_split(nominal[RAY[1]], -(-nominal[RAY[1]].size * amplitudes // BUDGET))
    rows: list[dict[str, np.ndarray]] = []
    for clearance, columns in product(nominal[RAY[0]], parts):
        d = tracks[RAY[0]].index[clearance][None, :]
        g = tracks[RAY[1]].index[columns]
        on = ((d >= 0) & (g >= 0)).all(axis=1)
        d, g = np.broadcast_arrays(np.maximum(d, 0), np.maximum(g, 0))
        values = plane["value"][d, g]
        known = on & np.isfinite(values).all(axis=1)
        tally["rays"] += columns.size
        tally["left_grid"] += int((~on).sum())
        tally["unknown"] += int((on & ~known).sum())
        if exclude_locked:
            locked = plane["locked_near_resonance"][d, g].all(axis=1)
            tally["locked"] += int((known & locked).sum())
            known &= ~locked
        worst = np.where(known[:, None], values, 0.0).argmax(axis=1)
        each = np.arange(columns.size)
        off = np.maximum(tracks[RAY[0]].distance[clearance][None, :], tracks[RAY[1]].distance[columns])
        at = d[each, worst], g[each, worst]
        found = {name: plane[name][at] for name in ("value", "error", "response_class", FREQUENCY)}
        # another amplitude may be the worst within its error
        found |= {name: plane[name][d, g].max(axis=1) for name in ("lowest", "highest")}
        found |= {"used_0": at[0], "used_1": at[1], "worst": worst, "distance": off.max(axis=1)}
        found |= {"best_case": values.min(axis=1), "nominal": plane["value"][clearance, columns]}
        found |= {RAY[0]: np.full(columns.size, clearance), RAY[1]: columns}
        rows.append({name: array[known] for name, array in found.items()})
    return {name: np.concatenate([row[name] for row in rows]) for name in rows[0]}


def _answer(
    cube: xr.Dataset,
    question: DesignQuestion,
    factors: np.ndarray,
    best: Mapping[str, np.ndarray],
    tally: Mapping[str, int],
) -> xr.Dataset:
    worst = f"largest over the base amplitudes of the {question.long_name}"
    inside = factors[0] <= 1 <= factors[-1]
    columns: dict[str, tuple[np.ndarray, str]] = {
        "value": (best["value"], worst),
        "error": (best["error"], f"error of the {worst}"),
        "amplitude": (factors[best["worst"]], "base amplitude of the worst case, over the nominal one"),
        "clearance_ratio_used": (
            cube[RAY[0]].values[best["used_0"]],
            "clearance ratio of the worst case's grid point",
        ),
        "friction_ratio_used": (
            cube[RAY[1]].values[best["used_1"]],
            "friction ratio of the worst case's grid point",
        ),
        "best_case": (best["best_case"], f"smallest over the base amplitudes of the {question.long_name}"),
        "nominal": (
            best["nominal"] if inside else np.full_like(best["value"], np.nan),
            "value at the nominal amplitude",
        ),
        "distance": (best["distance"], "largest relative distance of a grid point used from the ray"),
    }
    answer = xr.Dataset(
        {name: ("rank", array, {"units": "1", "long_name": text}) for name, (array, text) in columns.items()},
        {"rank": np.arange(1, best["value"].size + 1)},
    )
    kind = dict(cube["response_class"].attrs) if "response_class" in cube else {}
    answer["response_class"] = ("rank", best["response_class"].astype(np.int8), kind)
    for name in (*OTHERS, *RAY, FREQUENCY):
        answer.coords[name] = ("rank", cube[name].values[best[name]], dict(cube[name].attrs))
    answer.attrs = {**attributes_of(question, tally), "amplitudes": factors.tolist()}
    return answer


def _note(
    cube: xr.Dataset,
    question: DesignQuestion,
    factors: np.ndarray,
    answer: xr.Dataset,
    peaks: RankedPeaks,
    phrases: Phrases,
) -> str:
    steps = counted(factors.size, "step")
    if phrases.unit(AMPLITUDE):
        # what multiplies an amplitude ratio is the base amplitude itself
        low, high = phrases.number(AMPLITUDE, factors[0]), phrases.value(AMPLITUDE, factors[-1])
        over = f"base amplitudes from {low} to {high} in {steps}; force and clearance stay the same."
    else:
        over = (
            f"{factors[0]:.6g} to {factors[-1]:.6g} times the nominal amplitude in {steps}; force and clearance stay the "
            "same, so d/Z and γ_F shrink as the amplitude grows."
        )
    sentences = [
        f"Ranked by the {question.long_name}, the worst over {over}",
        say_judged(question, cube.sizes[FREQUENCY], phrases),
        say_limits(question, RATIOS),  # in units they are others at each base amplitude
    ]
    tally = answer.attrs
    reasons = {
        "left_grid": "leave the grid, because at some base amplitude their d/Z or γ_F lies beyond its axes",
        "unknown": "meet a point without a value",
        "locked": "locked to the base near resonance at every amplitude",
    }
    left_out = [f"{tally[name]} {reason}" for name, reason in reasons.items() if tally[name]]
    if left_out:
        sentences.append(f"Left out of {counted(tally['rays'], 'damper')}: {', '.join(left_out)}.")
    sentences.append(peaks.say(phrases, "damper"))
    if answer.sizes["rank"] == 0:
        sentences.append("No damper is left.")
    else:
        off = float(answer["distance"].max())
        how_far = f"is off by {100 * off:.3g} % at most" if off > SAME else "has it exactly"
        sentences.append(
            "At each base amplitude the grid point nearest to the damper's d/Z and γ_F stands for it; for the dampers shown it "
            f"{how_far}."
        )
    return " ".join(filter(None, sentences))


def _brief(cube: xr.Dataset, answer: xr.Dataset, peaks: RankedPeaks, phrases: Phrases) -> Brief:
    """Say which damper has the least worst case, where that is met, and what comes next."""
    factors, tally = answer.attrs["amplitudes"], answer.attrs
    if not answer.sizes["rank"]:
        left = f"{tally['left_grid']:,} of {counted(tally['rays'], 'damper')} leave the grid."
        return Brief(
            None, ("No damper is left.", left), (), "a narrower range of amplitudes, or longer axes."
        )
    varied = [name for name in (*OTHERS, *RAY) if cube.sizes[name] > 1]
    in_units = bool(phrases.unit(AMPLITUDE))

    def spelled(rank: int) -> tuple[str, str]:
        row = answer.isel(rank=rank)
        design = ", ".join(phrases.equal(name, row[name].item(), ".3g") for name in varied)
        value = row["value"].item()
        metres = phrases.value("amplitude_ratio", value * row["amplitude"].item(), ".3g")
        return f"X/Z = {value:.3g}{f' ({metres})' if in_units else ''}", design

    first = answer.isel(rank=0)
    low, high, worst = (
        phrases.value(AMPLITUDE, each, ".3g") if in_units else f"{each:.3g}"
        for each in (factors[0], factors[-1], first["amplitude"].item())
    )
    value, design = spelled(0)
    sentences = (
        f"Best over base amplitudes from {low} to {high}{'' if in_units else ' times the nominal one'}: {design}.",
        f"At worst {value}, at {worst} and {phrases.equal(FREQUENCY, first[FREQUENCY].item(), '.4g')}.",
        f"{tally['left_grid']:,} of {counted(tally['rays'], 'damper')} leave the grid and are not judged."
        if tally["left_grid"]
        else "",
    )
    rows = tuple((PLACES[rank], *spelled(rank)) for rank in range(1, min(answer.sizes["rank"], len(PLACES))))
    following = "longer axes of clearance and friction." if tally["left_grid"] else ""
    if peaks.where.any():
        following = f"compute {peaks.axis(phrases)}: a peak may be more than a tenth higher."
    acts = float(first["mass_ratio"].item()) > 0
    return Brief(damper_of(acts, float(first[RAY[1]].item()) > 0), sentences, rows, following)


def _used(answer: xr.Dataset) -> xr.Dataset:
    """Give the grid points of the worst cases."""
    return answer.assign_coords({name: answer[f"{name}_used"] for name in RAY})
