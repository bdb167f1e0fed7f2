"""The best designs: every point of the five design dimensions judged by its response over the frequency."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from damperlab.studies.answers.design_question import FREQUENCY, DesignQuestion
from damperlab.studies.answers.flatness import flatness, say_flatness
from damperlab.studies.answers.judging import (
    REASONS,
    attributes_of,
    described,
    judged,
    new_tally,
    say_judged,
    say_limits,
)
from damperlab.studies.answers.nearness import same
from damperlab.studies.answers.phrases import Phrases, said, together
from damperlab.studies.answers.verdict import best_with_impacts, verdict
from damperlab.studies.faults import counted
from damperlab.studies.questions import MOST_DESIGNS, Judging
from damperlab.studies.store.export.slabs import BUDGET
from damperlab.studies.variables import ResponseClass


def optimal_designs(
    cube: xr.Dataset,
    judging: Judging = Judging(),
    top: int = 10,
) -> xr.Dataset:
    """Rank the designs of a cube.

    A design is judged only if every frequency that counts was computed and has a value. Means over a band are
    integrals by the trapezoidal rule over the frequencies of the grid.

    Parameters
    ----------
    cube : Dataset
        A study's cube, read slab by slab.
    judging : Judging
        What designs are judged by, and which of them. Of locked designs those are excluded that friction locks to the base
        at the judged frequency nearest r = 1: the trivial optimum.
    top : int
        How many designs, 1 to `MOST_DESIGNS`.

    Returns
    -------
    Dataset
        Dimension rank, counted from 1; shorter than `top` where fewer designs qualify. Coordinates along it:
        the five design dimensions, and `frequency_ratio`, where the amplitude in the band is largest.
        Variables: `value`, its `error` (that of a peak at the peak, of a mean the weighted mean error, since
        errors of a periodic response do not average out; NaN where the study keeps none), `response_class`
        at `frequency_ratio`, and `locked_share`, the share of the judged frequencies at which the mass is
        locked; both unknown, -1 and NaN, where the study keeps no class. `lowest` and `highest` are limits of
        the confidence stated, of each design by itself; `impact_share` is the share of the judged frequencies at which
        a particle that has mass strikes while the mass moves; `alike` counts further designs that have the very same response
        without impacts, which are folded into the first of them. Attributes: `objective`, `designs` (all in the
        ranges), `incomplete`, `failed`, `locked`, `too_fast`, `outside` (those left out, by reason), `complete` (share
        of the designs that were computed), `band`,
        `frequencies`, `flatness` of the best (see `flatness.flatness`), those of `verdict.verdict`, and `note`, which
        says how it was judged.

    Raises
    ------
    QueryFault
        If an argument is not allowed, nothing of the grid is in a range, or the study keeps no variable that
        is needed.
    """
    question = DesignQuestion.ask(cube, judging, top)
    tally = new_tally()
    best = _Ranking()
    for found in judged(cube, question, tally, (), BUDGET):
        best.take(found)
    answer = _described(cube, question, best.found)
    ranked = min(top, answer.sizes["rank"])
    flat = []
    if ranked:
        first = {name: int(best.found[name][0]) for name in question.design}
        flat = flatness(cube, question, first, float(best.found["value"][0]))

    def note(phrases: Phrases) -> dict[str, Any]:
        words = _note(question, tally, cube.sizes[FREQUENCY], ranked, phrases)
        return {"note": f"{words} {say_flatness(flat, phrases)}".strip()}

    answer.attrs = {**attributes_of(question, tally), "flatness": flat}
    active = best_with_impacts(_described(cube, question, best.active)) if best.active else None
    judgement = verdict(cube, question, answer, active, flat)
    answer.attrs |= together(said(cube, note), judgement)
    return answer.isel(rank=slice(top))


def _described(cube: xr.Dataset, question: DesignQuestion, found: Mapping[str, np.ndarray]) -> xr.Dataset:
    answer = described(cube, question, found)
    attributes = {"units": "1", "long_name": "further designs with exactly this response"}
    answer["alike"] = ("rank", found["alike"], attributes)
    return answer


class _Ranking:
    """The best designs so far, and the best of those whose particle strikes."""

    def __init__(self) -> None:
        self.found: dict[str, np.ndarray] = {}
        self.active: dict[str, np.ndarray] = {}

    def take(self, found: dict[str, np.ndarray]) -> None:
        """Take in the designs of one slab; of equal values the earlier one stands."""
        found["alike"] = np.zeros(found["value"].size, np.int64)
        strikes = found["impact_share"] > 0
        self.active = _first(self.active, {name: array[strikes] for name, array in found.items()}, 1)
        self.found = _folded(_first(self.found, found, MOST_DESIGNS))


def _first(known: dict[str, np.ndarray], more: dict[str, np.ndarray], number: int) -> dict[str, np.ndarray]:
    joined = {name: np.concatenate((known[name], more[name])) for name in more} if known else more
    order = np.argsort(joined["value"], kind="stable")[:number]
    return {name: array[order] for name, array in joined.items()}


def _folded(found: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Fold neighbours in the ranking that are one response without impacts, whatever the parameters that do not act."""
    idle = (found["response_class"] >= ResponseClass.LINEAR) & (found["impact_share"] == 0)
    value, kind = found["value"], found["response_class"]
    again = np.zeros(value.size, bool)
    again[1:] = idle[1:] & idle[:-1] & (kind[1:] == kind[:-1]) & same(value[1:], value[:-1])
    if not again.any():
        return found
    group = np.cumsum(~again) - 1
    alike = np.bincount(group, found["alike"] + 1).astype(np.int64) - 1
    folded = {name: array[~again] for name, array in found.items()}
    return folded | {"alike": alike}


def _note(
    question: DesignQuestion, tally: Mapping[str, int], computed: int, ranked: int, phrases: Phrases
) -> str:
    sentences = [
        f"Ranked by the {phrases.about(question.long_name)}; smaller is better.",
        say_judged(question, computed, phrases),
        say_limits(question, phrases),
    ]
    left_out = [f"{tally[name]} {reason}" for name, reason in REASONS.items() if tally[name]]
    if left_out:
        sentences.append(f"Left out of {counted(tally['designs'], 'design')}: {', '.join(left_out)}.")
    if ranked == 0:
        sentences.append("No design is left.")
    return " ".join(filter(None, sentences))
