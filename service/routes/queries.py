"""Questions to a study's cube; a running study is asked for what is there, and the answer says how much that is."""

from collections.abc import Iterable, Mapping
from typing import Annotated, Any

import xarray as xr
from fastapi import APIRouter, Depends, Query
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, WithJsonSchema, create_model
from starlette.requests import Request

from damperlab.service.answers import designs_document, map_document, response_document, worst_document
from damperlab.service.documents import Document
from damperlab.service.problems import Problem, documented
from damperlab.service.state import Service, TheService, TheStudy
from damperlab.studies.answers.compared_response import compared_response
from damperlab.studies.answers.design_question import MOST
from damperlab.studies.answers.faults import QueryFault
from damperlab.studies.answers.frequency_response import frequency_response
from damperlab.studies.answers.merged import merged_designs
from damperlab.studies.answers.optimal_designs import optimal_designs
from damperlab.studies.answers.pareto import RESPECTS, pareto_front, read_respects
from damperlab.studies.answers.resonance_map import resonance_map
from damperlab.studies.answers.selection import dimensions_of, main_metric
from damperlab.studies.answers.survey import require_harmonic, worst_case_designs
from damperlab.studies.answers.window import window
from damperlab.studies.faults import Fault, StudyFaults, describe, listing
from damperlab.studies.ground.variables import DIMENSIONS as SURVEY_DIMENSIONS
from damperlab.studies.ground.variables import RECORD
from damperlab.studies.registry import EVERY_DIMENSION, EVERY_VARIABLE, is_survey
from damperlab.studies.store.record import Record
from damperlab.studies.units import in_ratios
from damperlab.studies.variables import DIMENSIONS, VARIABLES, Variable
from damperlab.studies.vocabulary import Objective, Reduction

ANSWER_POINTS = 4_000_000
"""Most points of one map; a screen has as many, and a larger answer would be built in memory."""


def once(request: Request) -> None:
    """Refuse a parameter that is given twice: one of the two would win without a word."""
    names = [name for name, _ in request.query_params.multi_items()]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise StudyFaults(Fault(name, "several values", "one value", "keep one of them") for name in twice)


router = APIRouter(prefix="/api/v1/studies/{study_id}", tags=["queries"], dependencies=[Depends(once)])

ANSWER: dict[str, Any] = {"response_class": Document, "responses": documented(404, 409, 422, 503)}
"""What every question's route is declared with."""


def read_range(text: str) -> str:
    """Check `lower,higher`, the text of a range."""
    low, comma, high = text.partition(",")
    try:
        if comma and float(low) <= float(high):
            return text
    except ValueError:
        pass
    raise ValueError("two numbers, lower,higher")


def _one_of(names: Iterable[str]) -> WithJsonSchema:
    """Describe the names of both kinds of study; the question, which knows the study, refuses those it has not."""
    return WithJsonSchema({"type": "string", "enum": list(names)})


Metric = Annotated[str, _one_of(EVERY_VARIABLE)]
Dimension = Annotated[str, _one_of(EVERY_DIMENSION)]
Value = Annotated[
    float | None, Field(allow_inf_nan=False, description="The nearest grid point is taken, and said.")
]
Range = Annotated[
    str | None,
    AfterValidator(lambda text: None if text is None else read_range(text)),
    Field(max_length=100, description="Two numbers, `lower,higher`."),
]


class At(BaseModel):
    """The point of a study at which something is asked."""

    model_config = ConfigDict(extra="forbid")

    damping_ratio: Value = None
    restitution: Value = None
    mass_ratio: Value = None
    clearance_ratio: Value = None
    friction_ratio: Value = None

    def at(self) -> dict[str, Any]:
        """Give the dimensions that were named, with their values."""
        return {name: value for name in EVERY_DIMENSION if (value := getattr(self, name, None)) is not None}


class AlongFrequency(At):
    """The point of a curve, which has no frequency ratio: one that is given is refused in words that say why."""

    frequency_ratio: Value = Field(None, description="Refused: the curve runs along it.")


class SliceQuery(At):
    """What a map and a curve have in common."""

    metric: Metric | None = Field(
        None,
        description="A variable that the study stores; amplitude_ratio by default, peak_relative_displacement_m for a "
        "ground-motion suite.",
    )
    interpolate: bool = Field(
        False, description="Interpolate between grid points where the response class does not change."
    )


class MapQuery(SliceQuery):
    """Parameters of a map."""

    # without them the refusal names the dimensions of the study, which only the route knows
    x: Dimension | None = Field(
        None, description="Dimension along the rows of `values`; to be named.", examples=["friction_ratio"]
    )
    y: Dimension | None = Field(
        None, description="Dimension across the rows; to be named.", examples=["frequency_ratio"]
    )
    over: Dimension | None = Field(None, description="A third dimension, to reduce.")
    reduce: Reduction | None = Field(None, description="How `over` is reduced; max by default.")
    frequency_ratio: Value = None
    record: str | None = Field(
        None,
        max_length=100,
        description="A record of a ground-motion suite; the worst of all records by default.",
    )
    scale: Value = None
    natural_frequency_hz: Value = None
    particle_mass_kg: Value = None
    clearance_m: Value = None
    friction_force_n: Value = None
    x_range: Range = None
    y_range: Range = None
    most: int | None = Field(
        None, ge=2, le=2000, description="Most values along x and along y: evenly spaced ones stay."
    )


class ResponseQuery(AlongFrequency, SliceQuery):
    """Parameters of a frequency response."""

    with_: str | None = Field(
        None,
        alias="with",
        max_length=200,
        description="A second study to compare with, such as the downward sweep of a hysteresis; `apart` gives the ranges "
        "where they differ.",
    )


def _result_range(variable: Variable) -> Any:
    meaning = f"{variable.long_name}: designs outside this range at any considered frequency are excluded."
    return Range, Field(None, description=f"`lower,higher` of the {meaning}")


ResultRanges = create_model(
    "ResultRanges",
    __config__=ConfigDict(extra="forbid"),
    **{v.name: _result_range(v) for v in VARIABLES.values() if v.flags is None},
)
"""A range of any result that is a quantity."""


class RankingQuery(ResultRanges):
    """What designs are judged by, and which of them."""

    objective: Objective | None = Field(
        None,
        description="What a design is judged by; peak, or resonance where one frequency was computed and no band is given.",
    )
    band: Range = None
    exclude_locked: bool = Field(
        False, description="Exclude designs in which friction locks the mass to its base."
    )
    max_impact_speed: float | None = Field(None, ge=0, allow_inf_nan=False, description="Over Z·ω_n.")
    damping_ratio: Range = None
    restitution: Range = None
    mass_ratio: Range = None
    clearance_ratio: Range = None
    friction_ratio: Range = None
    frequency_ratio: Range = Field(None, description="Refused: `band` is the range of frequency ratios.")

    def judging(self) -> dict[str, Any]:
        """Give the arguments that every ranking of `damperlab.studies.answers` takes."""
        names = (*DIMENSIONS, *ResultRanges.model_fields)
        ranges = {name: found for name in names if (found := pair(getattr(self, name, None))) is not None}
        return {
            "objective": self.objective,
            "band": pair(self.band),
            "exclude_locked": self.exclude_locked,
            "max_impact_speed": self.max_impact_speed,
            "ranges": ranges,
        }


class DesignsQuery(RankingQuery):
    """Parameters of a ranking."""

    top: int = Field(10, ge=1, le=MOST, description="Number of designs to list.")
    pareto: str | None = Field(
        None,
        max_length=200,
        description=f"Two or three of {listing(RESPECTS)}; the front instead of a ranking. A minus in front "
        "means larger is better.",
        examples=["amplitude,mass"],
    )
    with_: str | None = Field(
        None,
        alias="with",
        max_length=2000,
        description="Ids of follow-up studies to rank with this one, by commas.",
    )
    metric: Metric | None = Field(
        None,
        description="Result that dampers of a ground-motion suite are ranked by; peak_relative_displacement_m by default.",
    )
    record: str | None = Field(
        None,
        max_length=2000,
        description="Records of a ground-motion suite to consider, separated by commas; all by default.",
    )
    scale: Range = None
    natural_frequency_hz: Range = None
    particle_mass_kg: Range = None
    clearance_m: Range = None
    friction_force_n: Range = None

    def worst_case(self) -> dict[str, Any]:
        """Give the arguments of a survey's ranking; raise `QueryFault` for what only harmonic studies have."""
        known = (*SURVEY_DIMENSIONS, "metric", "top")
        for name in sorted(self.model_fields_set.difference(known)):
            advice = (
                "leave it out: dampers are ranked by their worst case over records, scales and structures"
            )
            allowed = f"of a survey one of {listing(known)}"
            raise QueryFault(Fault(name.rstrip("_"), "a value", allowed, advice))
        ranges = {name: pair(getattr(self, name)) for name in SURVEY_DIMENSIONS if name != RECORD}
        return {
            "metric": self.metric,
            "top": self.top,
            "records": None if self.record is None else self.record.split(","),
            "ranges": {name: found for name, found in ranges.items() if found is not None},
        }

    def refuse_survey(self) -> None:
        """Raise `QueryFault` where something was given that only surveys have."""
        known = {*SURVEY_DIMENSIONS, "metric"}.difference(DIMENSIONS)
        for name in sorted(self.model_fields_set & known):
            allowed = "what a study of the response to a harmonic base has"
            raise QueryFault(
                Fault(name, "a value", allowed, "leave it out: it applies to ground-motion suites only")
            )


@router.get(
    "/resonance-map",
    **ANSWER,
    summary="One metric over two dimensions",
)
def ask_map(service: TheService, study: TheStudy, query: Annotated[MapQuery, Query()]) -> Document:
    """Slice the cube: `values[y][x]`. Others are fixed by `<dimension>=value`, or reduced with `over`.

    Without a word on the frequency the map shows the largest value over the study's band.
    """
    cube = service.store.cube(study.id)
    x, y = named(cube, {"x": query.x, "y": query.y})
    _check_size(cube, *in_ratios(cube, (x, y)))
    metric = query.metric or main_metric(cube)
    answer = resonance_map(cube, x, y, metric, query.over, query.reduce, query.at(), query.interpolate)
    if query.x_range or query.y_range or query.most:
        answer = window(answer, {x: pair(query.x_range), y: pair(query.y_range)}, query.most)
    return answered(study, map_document(answer, metric))


@router.get(
    "/frequency-response",
    **ANSWER,
    summary="One metric over the frequency ratio",
)
def ask_response(service: TheService, study: TheStudy, query: Annotated[ResponseQuery, Query()]) -> Document:
    """Follow one design along the frequency; it is named by `<dimension>=value`."""
    require_harmonic(study.dimensions, "frequency-response")
    cube = service.store.cube(study.id)
    metric = query.metric or main_metric(cube)
    if query.with_ is None:
        answer = frequency_response(cube, metric, query.at(), query.interpolate)
    elif query.interpolate:
        advice = "leave one of the two out"
        raise StudyFaults([Fault("interpolate", "true", "false where `with` is given", advice)])
    else:
        other = service.store.find(query.with_)
        require_harmonic(other.dimensions, "frequency-response")
        answer = compared_response(cube, service.store.cube(other.id), metric, query.at())
        answer.attrs["studies"] = [study.id, other.id]
    return answered(study, response_document(answer, metric))


@router.get(
    "/optimal-designs",
    **ANSWER,
    summary="Designs in the order of their response",
)
def ask_designs(service: TheService, study: TheStudy, query: Annotated[DesignsQuery, Query()]) -> Document:
    """Rank the designs of a study over its frequencies; `<dimension>=lower,higher` narrows the choice.

    Dampers of a ground-motion suite are ranked by their worst case over its records, scales and structures.
    """
    if is_survey(study.dimensions):
        worst = worst_case_designs(service.store.cube(study.id), **query.worst_case())
        return answered(study, worst_document(worst))
    query.refuse_survey()
    if query.pareto is not None and query.with_ is not None:
        advice = "leave one of the two out"
        raise StudyFaults([Fault("with", describe(query.with_), "nothing where `pareto` is given", advice)])
    asked = {"top": query.top, **query.judging()}
    if query.with_ is not None:
        ranked = merged_designs(with_follow_ups(service, study, query.with_), **asked)
    elif query.pareto is not None:
        ranked = pareto_front(service.store.cube(study.id), read_respects(query.pareto), **asked)
    else:
        ranked = optimal_designs(service.store.cube(study.id), **asked)
    return answered(study, designs_document(ranked))


def with_follow_ups(service: Service, study: Record, with_: str | None) -> dict[str, xr.Dataset]:
    """Open a study's cube and those of the studies that `with` names, by id."""
    records = [study, *(service.store.find(ref.strip()) for ref in (with_ or "").split(",") if ref.strip())]
    for record in records:
        require_harmonic(record.dimensions, "follow-ups")
    return {record.id: service.store.cube(record.id) for record in records}


def pair(text: str | None) -> tuple[float, float] | None:
    """Read `lower,higher`, which was checked."""
    if text is None:
        return None
    low, _, high = text.partition(",")
    return float(low), float(high)


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
            (Fault("x, y", f"{describe(points)} points", f"at most {ANSWER_POINTS} points", advice),)
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
