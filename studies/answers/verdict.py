"""What a ranking means, in sentences that every door shares: the best, what is as good, and why not to trust it yet."""

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from damperlab.studies.answers.band import runs
from damperlab.studies.answers.contenders import chance_of_another, contend
from damperlab.studies.answers.design_question import DESIGN, FREQUENCY, METRIC, DesignQuestion
from damperlab.studies.answers.ends import end_of, say_ends
from damperlab.studies.answers.flatness import NO_VALUE
from damperlab.studies.answers.nearness import nearest_place
from damperlab.studies.answers.phrases import RATIOS, Phrases, said
from damperlab.studies.answers.ranked_peaks import RankedPeaks
from damperlab.studies.faults import counted
from damperlab.studies.variables import DIMENSIONS, ResponseClass, Status

NO_ACTION: dict[int, str] = {
    ResponseClass.LINEAR: "neither friction nor the particle acts",
    ResponseClass.LOCKED: "friction locks the mass to its base",
    ResponseClass.NO_IMPACT: "the particle never meets a wall",
}
"""Responses in which the particle does nothing, and what happens there."""

UNRESOLVED = 0.03
"""Relative error above which the value of the best design counts as not resolved."""
DOUBTS = (
    "one_frequency",
    "hidden_peak",
    "cut_off",
    "end_of_range",
    "neighbourhood_unknown",
    "rugged",
    "error",
)
"""Kinds of doubt, the gravest first; those after `hidden_peak` are about the optimum alone, not about the best with impacts."""
MOST_RUNS = 3
"""Runs of frequencies that a sentence names."""
NEXT_BAND = {"start": 0.8, "stop": 1.25, "num": 19}
"""Frequencies to compute next, where a study has one."""


def best_with_impacts(found: xr.Dataset) -> dict[str, Any] | None:
    """Give the best design whose particle strikes at a frequency that counts, None where there is none or nobody knows."""
    if found.sizes["rank"] == 0:
        return None
    rank = {name: found[name].values.item() for name in (*DIMENSIONS, "value", "error", "impact_share")}
    kind = ResponseClass(int(found["response_class"].values.item()))
    return {**rank, "response_class": kind.name.lower()}


def verdict(
    cube: xr.Dataset,
    question: DesignQuestion,
    ranked: xr.Dataset,
    active: Mapping[str, Any] | None,
    flat: list[dict[str, Any]],
    homes: Mapping[str, xr.Dataset] | None = None,
) -> dict[str, Any]:
    """Judge a ranking.

    Parameters
    ----------
    cube, question : Dataset, DesignQuestion
        The study that was asked.
    ranked : Dataset
        Its designs, the best first, with `lowest` and `highest`: all that may be the best among them.
    active : mapping or None
        Of `best_with_impacts`.
    flat : list of dict
        Of `flatness.flatness`.
    homes : mapping of Dataset, optional
        The studies that hold the designs, by the id that stands as `study` in `ranked`; `cube` holds all of them if not given.

    Returns
    -------
    dict
        Attributes of the answer: `confidence`; `as_good`, how many further designs may be the best within their errors;
        `chance_of_another`, the probability that one of them is (left out where errors are not known);
        `best_with_impacts` (left out where there is none); `next_frequencies`, what to compute where one frequency
        counts; `verdict`, all of it in sentences; `doubts`, those of them that say why the best value may not hold, each
        with its `kind` (`DOUBTS`); `in_units`, the same sentences in units (left out where the study is given in ratios
        alone).
    """
    if ranked.sizes["rank"] == 0:
        return said(cube, lambda _: {"verdict": ["There is no optimum."], "doubts": []})
    values, errors = ranked["value"].values, ranked["error"].values
    may_be = contend(ranked["lowest"].values, ranked["highest"].values)
    # the first is the best, and may be it: its lower limit is below every value
    chance = chance_of_another(values[may_be], errors[may_be], 0)
    found: dict[str, Any] = {"confidence": question.doubt.confidence, "as_good": int(may_be[1:].sum())}
    if not math.isnan(chance):
        found["chance_of_another"] = chance
    if active is not None:
        found["best_with_impacts"] = dict(active)
    if question.frequencies.size == 1:
        found["next_frequencies"] = dict(NEXT_BAND)
    ties = _say_ties(ranked, found, bool(np.isnan(errors[0])))
    struck = [] if active is None or homes or not _idle(ranked, 0) else _struck(cube, question, active)
    peaks = RankedPeaks.of(cube, question, ranked, active, homes)

    def sentences(phrases: Phrases) -> dict[str, Any]:
        hidden = peaks.say(phrases)
        alone = _say_alone(cube, question, phrases)
        ends = _say_ends(cube, ranked, flat, phrases)
        error = _say_error(float(values[0]), float(errors[0]))
        cut_off = "" if homes else _say_cut_off(cube, question, ranked)
        every = [
            f"Optimum: {say_design(ranked, 0, phrases)}",
            hidden,
            ties,
            *_say_idle(cube, question, ranked, active, struck, phrases),
            alone,
            cut_off,
            *ends.values(),
            error,
        ]
        doubts = {"one_frequency": alone, "hidden_peak": hidden, "cut_off": cut_off, **ends, "error": error}
        return {
            "verdict": [sentence for sentence in every if sentence],
            "doubts": [{"kind": kind, "sentence": doubts[kind]} for kind in DOUBTS if doubts.get(kind)],
        }

    return found | said(cube, sentences)


def say_next(phrases: Phrases) -> str:
    """Say which frequencies to compute where a study has one."""
    start, stop = (phrases.number(FREQUENCY, NEXT_BAND[end]) for end in ("start", "stop"))
    band = f"{phrases.label(FREQUENCY)} from {start} to {stop}{phrases.unit(FREQUENCY)}"
    return f"Compute {band} in {NEXT_BAND['num']} steps next"


def _say_idle(
    cube: xr.Dataset,
    question: DesignQuestion,
    ranked: xr.Dataset,
    active: Mapping[str, Any] | None,
    struck: list[list[float]],
    phrases: Phrases,
) -> list[str]:
    if not _idle(ranked, 0):
        return []
    kind = int(ranked["response_class"].values[0])
    frequencies = question.frequencies.size
    held = round(float(ranked["locked_share"].values[0]) * frequencies)
    # what holds at the frequency where the response is largest need not hold at the others
    partly = (
        f"{NO_ACTION[ResponseClass.LOCKED]} at {held} of {frequencies} frequencies"
        if 0 < held < frequencies
        else ""
    )
    if not json.loads(cube.attrs.get("study", "{}")).get("particle", True):
        # of a particle that the study leaves out there is nothing to say
        return [f"In this design {partly or NO_ACTION[kind]}."] if kind == ResponseClass.LOCKED else []
    massless = float(ranked["mass_ratio"].values[0]) == 0
    still = "the particle has no mass" if massless else "the particle never meets a wall"
    why = NO_ACTION.get(kind, still)
    if partly:
        why = f"{partly}, and {'' if massless else 'at the others '}{still}"
    sentences = [f"In this design {why}: it does not act as a particle damper."]
    if active is not None:
        sentences.append(f"Best design with impacts: {_say_active(active, frequencies, struck, phrases)}")
    elif "response_class" in cube:
        sentences.append("No design that was judged has impacts.")
    return sentences


def _say_alone(cube: xr.Dataset, question: DesignQuestion, phrases: Phrases) -> str:
    if question.frequencies.size > 1:
        return ""
    only = "was computed" if cube.sizes[FREQUENCY] == 1 else "counts here"
    return (
        f"Only {phrases.equal(FREQUENCY, question.frequencies[0], '.10g')} {only}, so no design is recommended for use: a "
        "design that is quiet at one frequency may resonate next to it. "
        + (
            f"{say_next(phrases)}, and judge by the peak."
            if cube.sizes[FREQUENCY] == 1
            else "Judge by the peak over the band that was computed."
        )
    )


def say_design(ranked: xr.Dataset, rank: int, phrases: Phrases = RATIOS) -> str:
    """Put one ranked design into words."""
    design = ranked.isel(rank=rank)
    # unknown is the class of a computed design only where the study does not store it
    kind = ResponseClass(int(design["response_class"]))
    words = kind.sentence if kind is not ResponseClass.UNKNOWN else ""
    row = {name: float(design[name]) for name in (*DIMENSIONS, "value", "error")}
    head = _say_row(row, phrases)
    r = phrases.equal(FREQUENCY, row[FREQUENCY])
    if ranked.attrs["frequencies"] == 1:
        return f"{phrases.symbol(METRIC)} = {head}, {r}. {words}".strip()
    largest = f"At its largest, {r}: {words}" if words else f"It is largest at {r}."
    share = float(design["impact_share"])
    if kind < ResponseClass.SYMMETRIC and share > 0:  # which alone would read as if the particle never struck
        frequencies = int(ranked.attrs["frequencies"])
        largest += f" The particle strikes at {round(share * frequencies)} of {frequencies} frequencies."
    return f"{phrases.about(design['value'].attrs['long_name'])} {head}. {largest}"


def _say_active(
    active: Mapping[str, Any], frequencies: int, struck: list[list[float]], phrases: Phrases
) -> str:
    kind = ResponseClass[str(active["response_class"]).upper()].sentence
    r = phrases.equal(FREQUENCY, active[FREQUENCY])
    if frequencies == 1:
        return f"{_say_row(active, phrases)}, {r}. {kind}"
    count = round(active["impact_share"] * frequencies)
    where = "".join(f", {phrases.span(FREQUENCY, low, high)}" for low, high in struck)
    return (
        f"{_say_row(active, phrases)}. Its particle strikes at {count} of {frequencies} frequencies"
        f"{where if 0 < len(struck) <= MOST_RUNS else ''}. At its largest, {r}: {kind}"
    )


def _struck(cube: xr.Dataset, question: DesignQuestion, design: Mapping[str, Any]) -> list[list[float]]:
    """Give the runs of frequencies at which the particle of one design strikes while the mass moves."""
    place = {name: nearest_place(cube[name].values, design[name]) for name in DESIGN}
    one = cube.isel({**place, FREQUENCY: question.axes[FREQUENCY]})
    strikes = one["response_class"].values >= ResponseClass.SYMMETRIC
    if "impacts_per_cycle" in one:
        strikes &= one["impacts_per_cycle"].values > 0
    return runs(question.frequencies, strikes)


def _say_row(row: Mapping[str, Any], phrases: Phrases) -> str:
    at = ", ".join(phrases.equal(name, row[name]) for name in DESIGN)
    return f"{phrases.measured(float(row['value']), float(row['error']))} at {at}"


def _idle(ranked: xr.Dataset, rank: int) -> bool:
    return float(ranked["impact_share"].values[rank]) == 0


def _say_ties(ranked: xr.Dataset, said: Mapping[str, Any], unknown: bool) -> str:
    alike = int(ranked["alike"].values[0]) if "alike" in ranked else 0
    parts = []
    if alike:
        parts.append(
            f"{counted(alike, 'more design')} {'has' if alike == 1 else 'have'} exactly this response."
        )
    if unknown:
        parts.append(
            "The study keeps no error of its amplitudes, so it is not known how many designs are as good."
        )
    else:
        parts.append(say_ties(said))
    return " ".join(filter(None, parts))


def say_ties(said: Mapping[str, Any]) -> str:
    """Say how many designs may be as good as the best, and how likely the best is another; nothing where none may."""
    if not said.get("as_good"):
        return ""
    chance = said.get("chance_of_another")
    likely = "" if chance is None else f"; the best is another with a probability of {_share(chance)}"
    return (
        f"{counted(said['as_good'], 'more design')} may be as good within the errors "
        f"({said['confidence']:.0%} confidence for all designs together, errors taken as normal){likely}."
    )


def _share(chance: float) -> str:
    if chance < 0.001:
        return "less than 0.1 %"
    return f"{100 * chance:.2g} %" if chance < 0.995 else "more than 99 %"


def _say_ends(
    cube: xr.Dataset, ranked: xr.Dataset, flat: list[dict[str, Any]], phrases: Phrases
) -> dict[str, str]:
    """Give the doubts that the neighbours of the optimum on the grid raise, by kind."""
    ends = []
    for entry in flat:
        if entry["below"] is None and entry["above"] is None:
            continue  # as good all along the axis
        name = entry["dimension"]
        ends.append(end_of(cube[name].values, entry["value"], name, phrases))
    coarse = [phrases.symbol(entry["dimension"]) for entry in flat if entry["worse"]]
    unknown = [phrases.symbol(entry["dimension"]) for entry in flat if entry["unknown"]]
    doubts = {"end_of_range": say_ends([end for end in ends if end])}
    if unknown:
        doubts["neighbourhood_unknown"] = (
            f"The neighbourhood of the optimum is not known along {' and '.join(unknown)}: a design next to it {NO_VALUE}."
        )
    if coarse:
        doubts["rugged"] = (
            f"The neighbourhood of the optimum is rugged along {' and '.join(coarse)}: the next design on the grid is "
            "more than a tenth worse. A tolerance in manufacture may cost as much, and a better design may lie between; "
            "`refine` looks there."
        )
    return doubts


def _say_error(value: float, error: float) -> str:
    if error == error and value > 0 and error > UNRESOLVED * value:
        return (
            f"The error of the optimum is {error / value:.1%} of its value: compute it longer (`race`, or a smaller "
            "`steady.tolerance` with more `max_cycles`)."
        )
    return ""


def _say_cut_off(cube: xr.Dataset, question: DesignQuestion, ranked: xr.Dataset) -> str:
    if "status" not in cube:
        return ""
    place = {name: nearest_place(cube[name].values, float(ranked[name].values[0])) for name in DESIGN}
    status = cube["status"].isel({**place, FREQUENCY: question.axes[FREQUENCY]}).values
    cut = int((status == Status.MAX_CYCLES).sum())
    if not cut:
        return ""
    return (
        f"The run of {cut} of the {counted(status.size, 'response')} of the optimum ended at `max_cycles`, before the response "
        "was known to the tolerance: the error may be larger than stated."
    )
