"""Pareto front of designs, and the number of further designs that may belong to the front within their errors."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from damperlab.studies.answers.comparing import CONFIDENCE, WIDTH, joined
from damperlab.studies.answers.design_question import DesignQuestion
from damperlab.studies.answers.judging import (
    attributes_of,
    described,
    judged,
    new_tally,
    say_judged,
    say_left_out,
    say_limits,
)
from damperlab.studies.answers.phrases import FREQUENCY, Phrases, said
from damperlab.studies.answers.query_fault import refused
from damperlab.studies.answers.selection import require_stored
from damperlab.studies.brief import Brief
from damperlab.studies.faults import counted, describe, listing, nearest
from damperlab.studies.questions import MOST_DESIGNS, Judging
from damperlab.studies.vocabulary import RESPECTS

if TYPE_CHECKING:
    import xarray as xr

_SHARES_ERROR = "dissipation_error"


def pareto_front(
    cube: "xr.Dataset",
    respects: Sequence[str],
    judging: Judging = Judging(),
    top: int = MOST_DESIGNS,
) -> "xr.Dataset":
    """Find the designs in which no compared quantity can be improved without a loss in another quantity.

    Parameters
    ----------
    cube : Dataset
        A study's cube, read slab by slab.
    respects : sequence of str
        The two or three compared quantities, each a key of `RESPECTS`. A leading minus, as in
        "-dissipation_impact", means that larger is better.
    judging, top : Judging, int
        As in `optimal_designs`. Only the `top` designs that are best in the first quantity are listed.

    Returns
    -------
    Dataset
        The designs in the form of `optimal_designs`, ordered by the first quantity. The Dataset has a variable for
        each quantity, and `alike`, the number of further designs with the same values of all quantities. The attribute
        `as_good` counts the other designs that may belong to the front, because the errors do not exclude it.
        The attribute `confidence` is the confidence of each limit. Both attributes are left out if the study
        stores no errors of amplitudes.

    Raises
    ------
    QueryFault
        If `optimal_designs` refuses the study, or if one of `respects` is unknown or not stored in the cube.
    """
    columns, signs = _read(cube, respects)
    question = DesignQuestion.ask(cube, judging, top)
    tally = new_tally()
    stored = tuple(name for name in columns if name in cube.data_vars)
    doubtful = "amplitude_error" in cube
    if _SHARES_ERROR in cube and any(name.startswith("dissipation") for name in columns):
        stored += (_SHARES_ERROR,)
    front: dict[str, np.ndarray] = {}
    may_belong: dict[str, np.ndarray] = {}
    for found in judged(cube, question, tally, stored):
        if doubtful:
            may_belong = joined(may_belong, found)
            sides = _limits(cube, columns, signs, may_belong)
            may_belong = {name: array[_unsurpassed(*sides)] for name, array in may_belong.items()}
        found["alike"] = np.zeros(found["value"].size, np.int64)
        found = joined(front, found)
        front = _front(found, _compared(cube, columns, signs, found))
    doubt: dict[str, float] = {}
    if doubtful and front:
        belong = int((front["alike"] + 1).sum())
        doubt = {"confidence": CONFIDENCE, "as_good": may_belong["value"].size - belong}
    length = front["value"].size
    front = {name: array[: question.top] for name, array in front.items()}
    answer = described(cube, question, front)
    for name, column in zip(respects, columns, strict=True):
        bare = name.removeprefix("-")
        values = cube[column].values[front[column]] if column in cube.dims else front[column]
        answer[bare] = ("rank", values, {"units": "1", "long_name": RESPECTS[bare][1]})
    answer["alike"] = (
        "rank",
        front["alike"],
        {"units": "1", "long_name": "further designs that are equal in every respect"},
    )
    answer.attrs = {**attributes_of(question, tally), "pareto": list(respects), **doubt}

    def note(phrases: Phrases) -> dict[str, Any]:
        wanted = ", ".join(_wanted(name, question, phrases) for name in respects)
        listed = f" The {question.top} best in the first respect are listed." if length > question.top else ""
        head = f"{counted(length, 'design')} that no other design beats in every respect: {wanted}."
        sentences = [
            f"{head}{listed}",
            say_judged(question, cube.sizes[FREQUENCY], phrases),
            say_limits(question, phrases),
            f"{counted(int(doubt['as_good']), 'more design')} may also be unbeaten within the errors "
            f"({CONFIDENCE:.0%} confidence for each)."
            if doubt.get("as_good")
            else "",
            say_left_out(tally),
        ]
        return {"note": " ".join(filter(None, sentences)), "brief": Brief(None, (head,)).document()}

    answer.attrs |= said(cube, note)
    return answer


def _read(cube: "xr.Dataset", respects: Sequence[str]) -> tuple[list[str], np.ndarray]:
    bare = [name.removeprefix("-") for name in respects]
    if not 2 <= len(set(bare)) == len(bare) <= 3:
        raise refused(
            "pareto",
            describe(",".join(respects)),
            f"two or three different quantities of {listing(RESPECTS)}",
            "name each of them once",
        )
    for name in bare:
        if name not in RESPECTS:
            near = nearest(name, RESPECTS)
            advice = f"did you mean {near}?" if near else "choose one of them"
            raise refused("pareto", describe(name), f"one of {listing(RESPECTS)}", advice)
        column = RESPECTS[name][0]
        if column != "value" and column not in cube.dims:
            require_stored(cube, "pareto", column, otherwise=f"leave {name} out")
    signs = np.array([-1.0 if name.startswith("-") else 1.0 for name in respects])
    return [RESPECTS[name][0] for name in bare], signs


def _compared(
    cube: "xr.Dataset", columns: Sequence[str], signs: np.ndarray, found: Mapping[str, np.ndarray]
) -> np.ndarray:
    """Return the compared values as an array (design, quantity). Smaller is better in every column."""
    values = [cube[name].values[found[name]] if name in cube.dims else found[name] for name in columns]
    return np.asarray(np.stack(values, axis=1) * signs)


def _limits(
    cube: "xr.Dataset",
    columns: Sequence[str],
    signs: np.ndarray,
    found: Mapping[str, np.ndarray],
) -> tuple[np.ndarray, np.ndarray]:
    """Return lower and upper limits in the form of `_compared`. Without an error, both limits are the value itself."""
    low = _compared(cube, columns, signs, found)
    high = low.copy()
    for at, (name, sign) in enumerate(zip(columns, signs, strict=True)):
        if name == "value":
            sides = found["lowest"], np.nan_to_num(found["highest"], nan=np.inf)
        elif name.startswith("dissipation") and _SHARES_ERROR in found:
            width = WIDTH * found[_SHARES_ERROR]
            sides = found[name] - width, found[name] + width
        else:
            continue
        low[:, at], high[:, at] = sides if sign > 0 else (-sides[1], -sides[0])
    return low, high


def _unsurpassed(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Find the designs that no other design surely beats.

    Design A surely beats design B if every upper limit of A is at most the lower limit of B, and at least one is
    smaller.
    """
    surpassed = np.zeros(low.shape[0], bool)
    rest = high[np.lexsort(high.T[::-1])]
    while rest.size:
        # each beaten design is also beaten by an unbeaten design, so a comparison with the unbeaten designs suffices
        best = rest[0]
        surpassed |= (best <= low).all(axis=1) & (best < low).any(axis=1)
        rest = rest[~(rest >= best).all(axis=1)]
    return ~surpassed


def _front(found: dict[str, np.ndarray], compared: np.ndarray) -> dict[str, np.ndarray]:
    """Keep the designs that no other design beats, ordered by the first quantity. Of equal designs, keep the first."""
    order = np.lexsort(compared.T[::-1])
    found, rest = {name: array[order] for name, array in found.items()}, compared[order]
    places = np.arange(order.size)
    kept: list[int] = []
    while places.size:
        # the designs are sorted, so no later design beats the first design of `rest`
        first = rest[0]
        kept.append(int(places[0]))
        same = (rest == first).all(axis=1)
        found["alike"][places[0]] = (found["alike"][places[same]] + 1).sum() - 1
        beaten = (rest >= first).all(axis=1)
        places, rest = places[~beaten], rest[~beaten]
    return {name: array[kept] for name, array in found.items()}


def _wanted(name: str, question: DesignQuestion, phrases: Phrases) -> str:
    """Name a compared quantity, and say whether larger or smaller is better."""
    column, meaning = RESPECTS[name.removeprefix("-")]
    label = phrases.label(column)
    named = phrases.about(question.long_name) if column == "value" else meaning if label == column else label
    return f"{named} ({'larger' if name.startswith('-') else 'smaller'} is better)"
