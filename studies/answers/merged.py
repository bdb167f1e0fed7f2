"""One ranking over a study and its follow-ups."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from damperlab.studies.answers.alike import alike
from damperlab.studies.answers.design_question import FREQUENCY, DesignQuestion, judging_in_ratios
from damperlab.studies.answers.faults import QueryFault
from damperlab.studies.answers.flatness import flatness
from damperlab.studies.answers.nearness import nearest_place
from damperlab.studies.answers.optimal_designs import optimal_designs
from damperlab.studies.answers.phrases import noted, said, together
from damperlab.studies.answers.verdict import best_with_impacts, verdict
from damperlab.studies.faults import Fault, counted
from damperlab.studies.questions import MOST_DESIGNS, Judging


def merged_designs(
    cubes: Mapping[str, xr.Dataset],
    judging: Judging = Judging(),
    top: int = 10,
) -> xr.Dataset:
    """Rank the designs of several studies together, each judged at the frequencies of its own study.

    Parameters
    ----------
    cubes : mapping of Dataset
        By the study's id; the first is the study that was refined. A follow-up that holds no design in
        the ranges adds nothing.
    judging, top : Judging, int
        As in `optimal_designs`; the objective is resolved for the first study.

    Returns
    -------
    Dataset
        As of `optimal_designs`, with `study`, the id each design was found in; a design that several studies
        hold stands once, with the value of the smallest error: the value of the longest run, not the luckiest one.
        `complete` is of all studies, flatness and left-out counts those of the first.

    Raises
    ------
    QueryFault
        As `optimal_designs` on the first study, or where another one was judged at other frequencies.
    """
    ids = list(cubes)
    cubes = dict(zip(ids, alike(cubes.values()), strict=True))
    # follow-ups need not have the units of the study, and their faults name ratios
    judging = judging_in_ratios(cubes[ids[0]], judging)
    question = DesignQuestion.ask(cubes[ids[0]], judging)
    judging = replace(judging, objective=question.objective)
    answers = {ids[0]: optimal_designs(cubes[ids[0]], judging, MOST_DESIGNS)}
    first = answers[ids[0]]
    for name in ids[1:]:
        try:
            answers[name] = optimal_designs(cubes[name], judging, MOST_DESIGNS)
        except QueryFault as error:
            if error.fault.field in set(judging.ranges).intersection(question.design):
                continue
            raise
        same = ("band", "frequencies")
        if [answers[name].attrs[key] for key in same] != [first.attrs[key] for key in same]:
            low, high = answers[name].attrs["band"]
            count = answers[name].attrs["frequencies"]
            span = f"{low:g} to {high:g}" if count > 1 else f"{low:g}"
            found = f"{name}, judged at {counted(count, 'frequency ratio')}, {span}"
            told = f"Study {name} is judged at other frequencies ({span}) than the study it is to be ranked with."
            advice = "name follow-ups of this study, refined with the same objective and band"
            raise QueryFault(Fault("with", found, "studies at the same frequencies", advice, told))
    parts = [
        answer.assign(study=("rank", np.full(answer.sizes["rank"], name))) for name, answer in answers.items()
    ]
    joined = xr.concat(parts, "rank", combine_attrs="override", join="outer")
    coordinates = np.stack([joined[name].values for name in question.design], axis=1)
    errors = joined["error"].values
    # of one design the smallest error; where that is equal, as of periodic responses, the earlier study
    order = np.lexsort((np.arange(errors.size), np.where(np.isnan(errors), np.inf, errors)))
    _, kept = np.unique(coordinates[order], axis=0, return_index=True)
    places = order[kept]
    places = places[np.argsort(joined["value"].values[places], kind="stable")]
    ranked = joined.isel(rank=places).assign_coords(rank=np.arange(1, places.size + 1))
    ranked["study"].attrs["long_name"] = "study that holds the design"
    ranked.attrs["studies"] = ids
    incomplete, designs = (
        sum(answer.attrs[name] for answer in answers.values()) for name in ("incomplete", "designs")
    )
    ranked.attrs["complete"] = 1 - incomplete / designs
    merged = f"Merged with {counted(len(ids) - 1, 'follow-up')}."
    words = noted(first.attrs, said(cubes[ids[0]], lambda _: {"note": merged}))
    if places.size:
        words = together(words, _verdict(cubes, ranked, replace(question, top=top)))
    ranked.attrs |= words
    return ranked.isel(rank=slice(top))


def _verdict(
    cubes: Mapping[str, xr.Dataset],
    ranked: xr.Dataset,
    question: DesignQuestion,
) -> dict[str, Any]:
    """Judge the merged ranking as the first study asks, around its best design as that one's study shows it."""
    cube = next(iter(cubes.values()))
    strikes = np.flatnonzero(ranked["impact_share"].values > 0)[:1]
    active = best_with_impacts(ranked.isel(rank=strikes)) if strikes.size else None
    home = cubes[str(ranked["study"].values[0])]
    everything = {name: np.arange(home.sizes[name]) for name in question.design}
    theirs = replace(question, axes={**everything, FREQUENCY: _frequencies(home, question)})
    design = {name: nearest_place(home[name].values, ranked[name].values[0]) for name in question.design}
    flat = flatness(home, theirs, design, float(ranked["value"].values[0]))
    return {"flatness": flat, **verdict(cube, question, ranked, active, flat, cubes)}


def _frequencies(home: xr.Dataset, question: DesignQuestion) -> np.ndarray:
    """Where the frequencies that count lie in another study; they were checked to be the same ones."""
    axis = home[FREQUENCY].values
    return np.array([nearest_place(axis, r) for r in question.frequencies])
