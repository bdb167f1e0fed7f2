"""The best designs of a study, judged by the responses over the frequency."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from damperlab.studies.answers.alike import alike
from damperlab.studies.answers.comparing import Found, least
from damperlab.studies.answers.design_question import DesignQuestion, judging_in_ratios
from damperlab.studies.answers.excited import name_of
from damperlab.studies.answers.flatness import flatness, say_flatness
from damperlab.studies.answers.judging import (
    attributes_of,
    described,
    judged,
    new_tally,
    say_judged,
    say_left_out,
    say_limits,
)
from damperlab.studies.answers.nearness import nearest_place, same
from damperlab.studies.answers.phrases import FREQUENCY, Phrases, noted, said, together
from damperlab.studies.answers.query_fault import QueryFault, refused
from damperlab.studies.answers.verdict import best_with_impacts, verdict
from damperlab.studies.faults import counted
from damperlab.studies.questions import MOST_DESIGNS, Judging
from damperlab.studies.variables import ResponseClass

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray


def optimal_designs(
    cube: "xr.Dataset",
    judging: Judging = Judging(),
    top: int = 10,
) -> "xr.Dataset":
    """Rank the designs of a cube.

    A design is judged only if the response has a value at every judged frequency. Means over a band are computed by the
    trapezoidal rule over the frequencies of the grid.

    Parameters
    ----------
    cube : Dataset
        A study's cube, read slab by slab.
    judging : Judging
        The criterion, and which designs are judged. `exclude_locked` leaves out the trivial optimum: designs that
        friction locks to the base at the judged frequency nearest r = 1.
    top : int
        Largest number of designs in the answer, 1 to `MOST_DESIGNS`.

    Returns
    -------
    Dataset
        Dimension rank, counted from 1. The coordinates are the dimensions of the design, and `frequency_ratio`, the
        frequency of the largest amplitude in the band. Variables: `value`, its `error`, `response_class` at
        `frequency_ratio`, and `locked_share`, the share of the judged frequencies at which the mass is locked. The
        error of a peak is the error of the response at the peak. The error of a mean is the weighted mean error, since
        errors of a periodic response do not average out. If the study does not store errors or classes, errors and
        `locked_share` are NaN, and `response_class` is -1. `lowest` and `highest` are limits with the stated
        confidence, for each design separately. `impact_share` is the share of the judged frequencies at which a
        particle with mass strikes while the mass moves. `alike` counts further designs without impacts that have the
        same response and are not listed separately. Attributes: `objective`, `designs` (number
        of all designs in the ranges), `incomplete`, `failed`, `locked`, `too_fast`, `outside` (numbers of designs left
        out, by reason), `complete` (share of the designs that were computed), `band`, `frequencies`. There are also
        `flatness` of the best design (see `flatness.flatness`), the attributes of `verdict.verdict`, and `note`, which
        says how designs were judged.

    Raises
    ------
    QueryFault
        If an argument is not allowed, no grid point is in a range, or the study does not store a variable that is
        needed.
    """
    ranked = _Ranked.of(cube, DesignQuestion.ask(cube, judging, top))
    answer = ranked.designs
    flat = _flatness(cube, ranked.question, answer)
    judgement = verdict(cube, ranked.question, answer, best_with_impacts(ranked.active), flat)
    answer.attrs |= {"flatness": flat} | together(ranked.note(flat), judgement)
    return answer.isel(rank=slice(top))


def merged_designs(
    cubes: "Mapping[str, xr.Dataset]",
    judging: Judging = Judging(),
    top: int = 10,
) -> "xr.Dataset":
    """Rank the designs of several studies together. Each design is judged at the frequencies of its own study.

    Parameters
    ----------
    cubes : mapping of Dataset
        The cubes, with the ids of the studies as keys: first the study to refine, then its follow-ups. A follow-up
        without a design in the ranges adds nothing.
    judging, top : Judging, int
        As in `optimal_designs`; the objective is determined for the first study.

    Returns
    -------
    Dataset
        The answer has the form of `optimal_designs`. `study` is the id of the study that contains each design. A design
        in several studies appears once, with the value that has the smallest error. `complete` covers all studies. The
        counts of designs left out are for the first study.

    Raises
    ------
    QueryFault
        If `optimal_designs` refuses the first study, or if another study is judged at other frequencies.
    """
    ids = list(cubes)
    cubes = dict(zip(ids, alike(cubes.values()), strict=True))
    cube = cubes[ids[0]]
    # use the units of the first study, because follow-ups may be given in ratios alone
    judging = judging_in_ratios(cube, judging)
    question = DesignQuestion.ask(cube, judging, top)
    judging = replace(judging, objective=question.objective)
    first = _Ranked.of(cube, question)
    parts = {ids[0]: first}
    for name in ids[1:]:
        try:
            theirs = DesignQuestion.ask(cubes[name], judging, top)
        except QueryFault as error:
            if error.fault.field in set(judging.ranges).intersection(question.design):
                continue
            raise
        _check_frequencies(cubes[name], question, theirs)
        parts[name] = _Ranked.of(cubes[name], theirs)
    answer = _joined({name: part.designs for name, part in parts.items()}, question)
    answer.attrs["studies"] = ids
    tallies = [part.tally for part in parts.values()]
    incomplete, designs = (sum(tally[name] for tally in tallies) for name in ("incomplete", "designs"))
    answer.attrs["complete"] = 1 - incomplete / designs
    merged = f"Merged with {counted(len(ids) - 1, 'follow-up')}."
    around = _flatness(cube, question, first.designs)
    words = noted(first.note(around), said(cube, lambda _: {"note": merged}))
    active = best_with_impacts(answer.isel(rank=np.flatnonzero(answer["impact_share"].values > 0)[:1]))
    home = cubes[str(answer["study"].values[0])] if answer.sizes["rank"] else cube
    flat = _flatness(home, question, answer)
    judgement = verdict(cube, question, answer, active, flat, cubes)
    answer.attrs |= {"flatness": flat} | together(words, judgement)
    return answer.isel(rank=slice(top))


@dataclass(frozen=True)
class _Ranked:
    """The ranked designs of one study.

    Parameters
    ----------
    cube, question : Dataset, DesignQuestion
        The study, and the question.
    designs, active : Dataset
        The `MOST_DESIGNS` best designs, the best first, and the best design whose particle strikes.
    tally : dict of int
        Counts of the designs that were left out.
    """

    cube: "xr.Dataset"
    question: DesignQuestion
    designs: "xr.Dataset"
    active: "xr.Dataset"
    tally: Mapping[str, int]

    @classmethod
    def of(cls, cube: "xr.Dataset", question: DesignQuestion) -> "_Ranked":
        """Rank the designs slab by slab."""
        tally = new_tally()
        best: Found = {}
        active: Found = {}
        for found in judged(cube, question, tally):
            found["alike"] = np.zeros(found["value"].size, np.int64)
            strikes = found["impact_share"] > 0
            active = least(active, {name: array[strikes] for name, array in found.items()}, 1)
            best = _folded(least(best, found, MOST_DESIGNS))
        designs, acting = (_described(cube, question, each) for each in (best, active))
        designs.attrs = attributes_of(question, tally)
        return cls(cube, question, designs, acting, tally)

    def note(self, flat: list[dict[str, Any]]) -> dict[str, Any]:
        """Describe how the designs were judged, and how flat the optimum is."""

        def note(phrases: Phrases) -> dict[str, Any]:
            sentences = [
                f"Ranked by the {phrases.about(self.question.long_name)}; smaller is better.",
                say_judged(self.question, self.cube.sizes[FREQUENCY], phrases),
                say_limits(self.question, phrases),
                say_left_out(self.tally),
                "" if self.designs.sizes["rank"] else "No design is left.",
                say_flatness(flat, phrases),
            ]
            return {"note": " ".join(filter(None, sentences))}

        return said(self.cube, note)


def _described(cube: "xr.Dataset", question: DesignQuestion, found: Found) -> "xr.Dataset":
    answer = described(cube, question, found)
    attributes = {"units": "1", "long_name": "further designs with exactly this response"}
    answer["alike"] = ("rank", found["alike"], attributes)
    return answer


def _folded(found: Found) -> Found:
    """Combine neighbouring designs of the ranking if they have no impacts, the same class and the same value."""
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


def _check_frequencies(cube: "xr.Dataset", question: DesignQuestion, theirs: DesignQuestion) -> None:
    """Refuse a follow-up if its band or its number of frequencies differs from that of the first study.

    With fewer frequencies, more of a peak is missed, so designs judged at fewer frequencies would seem better.
    """
    ours, r = question.frequencies, theirs.frequencies
    if ours.size != r.size or not np.allclose((ours[0], ours[-1]), (r[0], r[-1]), rtol=1e-9, atol=0.0):
        phrases = Phrases.of(cube)
        name = name_of(cube)
        judged = f"{f'Study {name}' if name else 'A study'} is judged at {_say_frequencies(r, phrases)}"
        told = f"{judged}, and the study it is to be ranked with at {_say_frequencies(ours, phrases)}."
        advice = (
            "compute both studies at the same frequencies, or name follow-ups of this study, refined with the same "
            "objective and band"
        )
        found = f"{name or 'a study'}, judged at {_say_frequencies(r, phrases)}"
        raise refused("with", found, f"studies judged at {_say_frequencies(ours, phrases)}", advice, told)


def _say_frequencies(r: "NDArray[np.float64]", phrases: Phrases) -> str:
    counts = f"{r.size:,} {'frequency' if r.size == 1 else 'frequencies'}"
    return f"{counts}, {phrases.span(FREQUENCY, float(r[0]), float(r[-1]), '.5g')}"


def _joined(parts: "Mapping[str, xr.Dataset]", question: DesignQuestion) -> "xr.Dataset":
    import xarray as xr

    named = [part.assign(study=("rank", np.full(part.sizes["rank"], name))) for name, part in parts.items()]
    joined = xr.concat(named, "rank", combine_attrs="override", join="outer")
    coordinates = np.stack([joined[name].values for name in question.design], axis=1)
    errors = joined["error"].values
    # of equal designs, keep the design with the smallest error, and of equal errors the design of the earlier study
    order = np.lexsort((np.arange(errors.size), np.where(np.isnan(errors), np.inf, errors)))
    _, kept = np.unique(coordinates[order], axis=0, return_index=True)
    places = order[kept]
    places = places[np.argsort(joined["value"].values[places], kind="stable")]
    ranked = joined.isel(rank=places).assign_coords(rank=np.arange(1, places.size + 1))
    ranked["study"].attrs["long_name"] = "study that holds the design"
    return ranked


def _flatness(home: "xr.Dataset", question: DesignQuestion, ranked: "xr.Dataset") -> list[dict[str, Any]]:
    """Return the result of `flatness` for the best design. The list is empty if no design is ranked."""
    if not ranked.sizes["rank"]:
        return []
    axes = {name: np.arange(home.sizes[name]) for name in question.design}
    axes[FREQUENCY] = np.array([nearest_place(home[FREQUENCY].values, r) for r in question.frequencies])
    best = ranked.isel(rank=0)
    place = question.place_of(best, home)
    return flatness(home, replace(question, axes=axes), place, float(best["value"]))
