"""Robust designs, and follow-up studies around an optimum or a class boundary."""

from typing import Annotated

from fastapi import APIRouter, Query
from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from damperlab.service.answers import designs_document
from damperlab.service.comparisons import refinement_document
from damperlab.service.documents import Document
from damperlab.service.problems import documented
from damperlab.service.routes.queries import (
    ANSWER,
    At,
    Dimension,
    RankingQuery,
    answered,
    named,
    pair,
    read_range,
    with_follow_ups,
)
from damperlab.service.routes.queries import router as queries
from damperlab.service.state import TheService, TheStudy
from damperlab.studies.answers.contenders import CONFIDENCE
from damperlab.studies.answers.design_question import MOST
from damperlab.studies.answers.follow_up import Refinement
from damperlab.studies.answers.race import BUDGET as CYCLES
from damperlab.studies.answers.race import INDIFFERENCE, race_designs
from damperlab.studies.answers.refine import (
    BUDGET,
    FINEST,
    TOLERANCE,
    VALUE_TOLERANCE,
    refine_boundary,
    refine_optimum,
)
from damperlab.studies.answers.robust import robust_designs
from damperlab.studies.answers.survey import require_harmonic
from damperlab.studies.definition import parse_harmonic
from damperlab.studies.plan import make_plan
from damperlab.worker.cost import seconds_per_point
from damperlab.worker.provenance import provenance

router = APIRouter(prefix=queries.prefix, dependencies=queries.dependencies)


class RobustQuery(RankingQuery):
    """Parameters of a ranking by the worst case over base amplitudes."""

    amplitudes: Annotated[str, AfterValidator(read_range)] = Field(
        max_length=100,
        description="Lowest and highest base amplitude over the nominal one.",
        examples=["0.5,2"],
    )
    top: int = Field(10, ge=1, le=MOST, description="How many dampers.")


class FollowUp(BaseModel):
    """What both kinds of refinement take."""

    model_config = ConfigDict(extra="forbid")

    with_: str | None = Field(
        None, alias="with", max_length=2000, description="Ids of the follow-ups that are done, by commas."
    )
    dry_run: bool = Field(False, description="Say what is known and what would be computed; store nothing.")


Tolerance = Annotated[float, Field(ge=FINEST, allow_inf_nan=False, description="Step to be known to.")]


class RefineQuery(FollowUp, RankingQuery):
    """Parameters of a refinement where better designs may lie."""

    tolerance: Tolerance = TOLERANCE
    value_tolerance: float = Field(
        VALUE_TOLERANCE,
        ge=1e-6,
        le=0.5,
        description="Share of the value by which a better design must be better to be looked for.",
    )
    budget: int = Field(BUDGET, ge=0, le=10**9, description="Points that all follow-ups together may take.")


class RaceQuery(FollowUp, RankingQuery):
    """Parameters of a race between the designs that may be the best."""

    confidence: float = Field(
        CONFIDENCE, ge=0.5, le=0.9999, description="Confidence with which the best design is to be known."
    )
    indifference: float = Field(
        INDIFFERENCE,
        ge=1e-4,
        le=0.5,
        description="Relative difference below which two designs count as equally good.",
    )
    budget: float = Field(
        CYCLES,
        ge=0,
        allow_inf_nan=False,
        description="Largest total number of excitation cycles of all rounds.",
    )


class BoundaryQuery(FollowUp, At):
    """Parameters of a refinement around a change of response class."""

    tolerance: Tolerance = TOLERANCE
    along: Dimension | None = Field(None, description="The dimension that is searched; to be named.")
    frequency_ratio: float | None = Field(None, allow_inf_nan=False)


@router.get(
    "/robust-designs",
    **ANSWER,
    summary="Dampers in the order of their worst case while the base amplitude varies",
    tags=["queries"],
)
def ask_robust(service: TheService, study: TheStudy, query: Annotated[RobustQuery, Query()]) -> Document:
    """Rank rays in the (d/Z, γ_F) plane: force and clearance are fixed, the base amplitude is not."""
    require_harmonic(study.dimensions, "robust-designs")
    amplitudes = pair(query.amplitudes)
    assert amplitudes is not None
    answer = robust_designs(service.store.cube(study.id), amplitudes, top=query.top, **query.judging())
    return answered(study, designs_document(answer))


@router.post(
    "/refine",
    response_class=Document,
    responses={201: {"description": "The follow-up is stored and queued"}, **documented(404, 409, 422, 503)},
    summary="A follow-up study around the best design",
    tags=["studies"],
)
def refine(service: TheService, study: TheStudy, query: Annotated[RefineQuery, Query()]) -> Document:
    """Search where a better design may lie; name the follow-ups that are done with `with`."""
    cubes = with_follow_ups(service, study, query.with_)
    found = refine_optimum(
        parse_harmonic(study.definition),
        cubes,
        query.tolerance,
        value_tolerance=query.value_tolerance,
        budget=query.budget,
        **query.judging(),
    )
    return _follow(service, study, found, query.dry_run)


@router.post(
    "/race",
    response_class=Document,
    responses={
        201: {"description": "The follow-ups are stored and queued"},
        **documented(404, 409, 422, 503),
    },
    summary="Follow-up studies that compute the designs longer that may be the best",
    tags=["studies"],
)
def race(service: TheService, study: TheStudy, query: Annotated[RaceQuery, Query()]) -> Document:
    """Take one round of a race; name the follow-ups that are done with `with`, until `known` or no follow-up comes."""
    cubes = with_follow_ups(service, study, query.with_)
    rules = (query.confidence, query.indifference, query.budget)
    found = race_designs(parse_harmonic(study.definition), cubes, *rules, **query.judging())
    return _follow(service, study, found, query.dry_run)


@router.post(
    "/refine-boundary",
    response_class=Document,
    responses={201: {"description": "The follow-up is stored and queued"}, **documented(404, 409, 422, 503)},
    summary="A follow-up study around a change of response class",
    tags=["studies"],
)
def refine_class(service: TheService, study: TheStudy, query: Annotated[BoundaryQuery, Query()]) -> Document:
    """Search along one dimension, the others fixed, for where the class of response changes."""
    cubes = with_follow_ups(service, study, query.with_)
    (along,) = named(cubes[study.id], {"along": query.along})
    found = refine_boundary(parse_harmonic(study.definition), cubes, along, query.at(), query.tolerance)
    return _follow(service, study, found, query.dry_run)


def _follow(service: TheService, study: TheStudy, found: Refinement, dry_run: bool) -> Document:
    document = refinement_document(found)
    if not found.studies or dry_run:
        return answered(study, document)
    submitted = [
        service.store.submit(each, make_plan(each, seconds_per_point), provenance() | {"refines": study.id})
        for each in found.studies
    ]
    service.dispatcher.wake()
    follow_ups = [
        {key: value for key, value in record.document().items() if key != "definition"}
        for record, _ in submitted
    ]
    answer = {"study": study.id, "name": study.name, "state": study.state, **document}
    answer |= {"follow_up": follow_ups[0], "follow_ups": follow_ups}
    created = any(new for _, new in submitted)
    location = {"Location": f"/api/v1/studies/{follow_ups[0]['id']}"}
    return Document(answer, 201 if created else 200, location)
