"""Questions to a study's cube; a running study is asked for what is there, and the answer says how much that is."""

from collections.abc import Iterable, Mapping
from typing import Annotated, Any

import xarray as xr
from fastapi import APIRouter

from damperlab.service.answer_schemas import gives
from damperlab.service.answers import map_document, ranking_document, response_document
from damperlab.service.documents import Document
from damperlab.service.parameters import asks
from damperlab.service.previews import coarse_of, map_preview
from damperlab.service.problems import Problem, documented
from damperlab.service.state import TheService, TheStudy
from damperlab.studies.amplitudes import AMPLITUDE
from damperlab.studies.answers.compared_response import compared_response
from damperlab.studies.answers.frequency_response import frequency_response
from damperlab.studies.answers.map_difference import map_difference
from damperlab.studies.answers.ranking import ranked_designs
from damperlab.studies.answers.resonance_map import resonance_map
from damperlab.studies.answers.selection import dimensions_of, main_metric
from damperlab.studies.answers.suite import require_harmonic
from damperlab.studies.answers.window import window
from damperlab.studies.faults import Fault, StudyFaults, describe, listing
from damperlab.studies.field import given
from damperlab.studies.questions import (
    Followed,
    Judging,
    Plane,
    Ranking,
    Second,
    Selection,
    Subtracted,
    Window,
)
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store
from damperlab.studies.units import in_ratios
from damperlab.studies.variables import BEFORE, DIMENSIONS

ANSWER_POINTS = 4_000_000
"""Most points of one map; a screen has as many, and a larger answer would be built in memory."""


router = APIRouter(prefix="/api/v1/studies/{study_id}", tags=["queries"])


def answers(name: str) -> dict[str, Any]:
    """Declare the route of a question whose answer is one of `answer_schemas`."""
    return {
        "response_class": Document,
        "responses": {200: gives(name), **documented(404, 409, 422, 429, 503)},
    }


@router.get(
    "/resonance-map",
    **answers("ResonanceMap"),
    summary="One metric over two dimensions",
)
def ask_map(
    service: TheService,
    study: TheStudy,
    asked: Annotated[tuple[Plane, Selection, Subtracted, Window], asks(Plane, Selection, Subtracted, Window)],
) -> Document:
    """Slice the cube: `values[y][x]`. Others are fixed by `<dimension>=value`, or reduced with `over`.

    Without a word on the frequency the map shows the largest value over the study's band. With `minus` the answer has
    `other`, the values of the second study, and `difference`, those of the first less those of the second. A large study has
    a coarse grid, computed first; until the map is complete `preview` is the same map of that.
    """
    plane, selection, second, shown = asked
    cube = service.store.cube(study.id)
    x, y = named(cube, {"x": plane.x, "y": plane.y})
    _check_size(cube, *in_ratios(cube, (x, y)))
    if second.minus is None:
        answer = resonance_map(cube, x, y, selection, plane.over, plane.reduce)
    else:
        other = service.store.find(second.minus)
        its = service.store.cube(other.id)
        answer = map_difference(cube, its, x, y, selection, plane.over, plane.reduce)
        answer.attrs["studies"] = [study.id, other.id]
    if given(shown):
        answer = window(answer, {x: shown.x_range, y: shown.y_range}, shown.most)
    document = map_document(answer, selection.metric or main_metric(cube))
    first = coarse_of(study) if document["complete"] < 1 and second.minus is None else None
    if first is None:
        return answered(study, document)
    preview = map_preview(service.store, first, x, y, plane, selection)
    found = answered(study, document | ({} if preview is None else {"preview": preview}))
    # the coarse grid grows, or is deleted, while the study stays as it is
    found.headers["Cache-Control"] = "no-store"
    return found


@router.get(
    "/frequency-response",
    **answers("FrequencyResponse"),
    summary="One metric over the frequency ratio",
)
def ask_response(
    service: TheService,
    study: TheStudy,
    asked: Annotated[
        tuple[Followed, Second], asks(Followed, Second, dimensions=(*BEFORE, *DIMENSIONS, AMPLITUDE))
    ],
) -> Document:
    """Follow one design along the frequency; it is named by `<dimension>=value`."""
    selection, second = asked
    require_harmonic(study.dimensions, "frequency-response", amplitudes=True)
    cube = service.store.cube(study.id)
    if second.with_ is None:
        answer = frequency_response(cube, selection)
    elif selection.interpolate:
        advice = "leave one of the two out"
        raise StudyFaults(
            [
                Fault(
                    "interpolate",
                    "true",
                    "false where `with` is given",
                    advice,
                    "`interpolate` and `with` cannot be combined.",
                )
            ]
        )
    else:
        other = service.store.find(second.with_)
        require_harmonic(other.dimensions, "frequency-response", amplitudes=True)
        answer = compared_response(cube, service.store.cube(other.id), selection)
        answer.attrs["studies"] = [study.id, other.id]
    return answered(study, response_document(answer, selection.metric or main_metric(cube)))


@router.get(
    "/optimal-designs",
    **answers("RankedDesigns"),
    summary="Designs in the order of their response",
)
def ask_designs(
    service: TheService,
    study: TheStudy,
    asked: Annotated[tuple[Judging, Ranking], asks(Judging, Ranking)],
) -> Document:
    """Rank the designs of a study over its frequencies; `<dimension>=lower,higher` narrows the choice.

    Dampers of a ground-motion suite are ranked by their worst case over its records, scales and structures, those of a
    study over base amplitudes by theirs over amplitudes and frequencies.
    """
    answer = ranked_designs(
        service.store.cube(study.id), *asked, lambda others: with_follow_ups(service.store, study, others)
    )
    return answered(study, ranking_document(answer))


def with_follow_ups(store: Store, study: Record, follow_ups: Iterable[str]) -> dict[str, xr.Dataset]:
    """Open a study's cube and those of its follow-ups, by id."""
    records = [study, *map(store.find, follow_ups)]
    for record in records:
        require_harmonic(record.dimensions, "follow-ups")
    return {record.id: store.cube(record.id) for record in records}


def named(cube: xr.Dataset, given: Mapping[str, str | None]) -> list[str]:
    """Give the dimensions that must be named; refuse those that are not, with what the study has."""
    axes = [name for name in dimensions_of(cube) if cube[name].dtype.kind == "f"]
    missing = [
        Fault(field, "nothing", f"one of {listing(axes)}", "add it")
        for field, name in given.items()
        if name is None
    ]
    if missing:
        raise Problem(422, "invalid-parameters", "The address of the request has faults.", missing)
    return [name for name in given.values() if name is not None]


def _check_size(cube: xr.Dataset, x: str, y: str) -> None:
    points = cube.sizes.get(x, 1) * cube.sizes.get(y, 1)
    if points > ANSWER_POINTS:
        advice = "export the cube, or choose shorter dimensions"
        raise StudyFaults(
            (
                Fault(
                    "x, y",
                    f"{describe(points)} points",
                    f"at most {ANSWER_POINTS} points",
                    advice,
                    f"The map would have {points:,} points; at most {ANSWER_POINTS:,} are allowed.",
                ),
            )
        )


def answered(study: Record, answer: dict[str, Any]) -> Document:
    """Put the study in front of its answer.

    Raises
    ------
    Problem
        409 if the study stopped before anything of the answer was computed: nobody will compute it unless asked.
    """
    if study.state in ("cancelled", "failed") and answer.get("complete", 1) < 1:
        resume = f"POST /api/v1/studies/{study.id}/resume computes what is missing"
        if answer["complete"] == 0:
            detail = f"The study is {study.state}, and nothing of what was asked for is computed. {resume}."
            raise Problem(409, f"study-{study.state}", detail)
        answer = answer | {"note": f"{answer['note']} The study is {study.state}: {resume}."}
    return Document({"study": study.id, "name": study.name, "state": study.state, **answer})
