"""Routes that submit follow-up studies, around an optimum or a class boundary, or with particle friction."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Annotated, Any

from anyio.to_thread import run_sync
from starlette.requests import Request
from typing_extensions import TypeAliasType

from damperlab.service.answer_types import gives
from damperlab.service.documents import Document
from damperlab.service.parameters import asks
from damperlab.service.problems import documented, lacking
from damperlab.service.questions.optimal_designs import OPTIMAL_DESIGNS, with_follow_ups
from damperlab.service.questions.question import Subject
from damperlab.service.questions.refinement import (
    FollowUpsDocument,
    Refined,
    RefinementDocument,
    refinement_document,
)
from damperlab.service.routes.questions import answered
from damperlab.service.routes.questions import router as questions
from damperlab.service.routes.strict import strict_router
from damperlab.service.settings import Settings
from damperlab.service.state import Service, TheService, TheStudy
from damperlab.service.work.apart import store_of
from damperlab.studies.answers.follow_up import Refinement
from damperlab.studies.answers.selection import dimensions_of
from damperlab.studies.definition import parse_harmonic
from damperlab.studies.plan import make_plan
from damperlab.studies.questions import Boundary, FollowUps, Judging, Ranking, Search, Step
from damperlab.studies.store.provenance import REFINES
from damperlab.studies.store.record import Record
from damperlab.studies.variables import BEFORE, DIMENSIONS
from damperlab.worker.dispatch.cost_model import seconds_per_point
from damperlab.worker.provenance import provenance

if TYPE_CHECKING:
    import xarray as xr

router = strict_router(questions.prefix)

RefinementOrFollowUps = TypeAliasType("RefinementOrFollowUps", FollowUpsDocument | RefinementDocument)
FOLLOW_UPS: dict[int | str, dict[str, Any]] = {
    200: gives(
        RefinementOrFollowUps,
        "Nothing new was stored: the request was a dry run, nothing was left to compute, or the follow-up "
        "studies already existed",
    ),
    201: gives(FollowUpsDocument, "Stored and queued", Location="Address of the first follow-up study."),
    **documented(404, 409, 422, 429, 503, 507),
}


def refine(
    settings: Settings, study: Record, known: FollowUps, search: Search, judging: Judging
) -> Refinement:
    """Submit follow-up studies where a better design may lie. `with` names the follow-up studies that are complete."""
    from damperlab.studies.answers.refine import refine_optimum  # imported only if the route is used

    cubes = _cubes(settings, study, known)  # called first, because `_cubes` refuses other kinds of study
    return refine_optimum(parse_harmonic(study.definition), cubes, search, judging)


def refine_class(
    settings: Settings, study: Record, known: FollowUps, boundary: Boundary, step: Step
) -> Refinement:
    """Search for a change of the response class along one dimension, at fixed values of the other dimensions."""
    from damperlab.studies.answers.refine import refine_boundary

    cubes = _cubes(settings, study, known)
    if boundary.along is None:
        raise lacking(["along"], dimensions_of(cubes[study.id]))
    definition = parse_harmonic(study.definition)
    return refine_boundary(definition, cubes, boundary.along, boundary.at, step.tolerance)


def particle_friction(settings: Settings, study: Record, known: FollowUps, judging: Judging) -> Refinement:
    """Submit follow-up studies of the best damper in which friction acts on the particle.

    `with` names the follow-up studies that are complete. When all follow-up studies are complete, request the optimal
    designs, and name these studies in `with`. That answer gives the largest friction coefficient at which the damper
    is as good as without particle friction.
    """
    from damperlab.studies.answers.particle_friction import find_friction

    subject = Subject(study, store_of(settings), "friction")
    ranked = OPTIMAL_DESIGNS.of(subject, judging, Ranking(with_=known.with_))
    return find_friction(subject.cube, ranked, judging)


def _cubes(settings: Settings, study: Record, known: FollowUps) -> "Mapping[str, xr.Dataset]":
    return with_follow_ups(Subject(study, store_of(settings), "refine"), known.with_)


def _add(path: str, summary: str, function: Callable[..., Refinement], *questions: type) -> None:
    """Add the route of a search; `questions` are the types of the function's arguments."""
    values = asks(*questions, dimensions=(*BEFORE, *DIMENSIONS))

    async def search(
        request: Request, service: TheService, study: TheStudy, asked: Annotated[tuple[Any, ...], values]
    ) -> Document:
        found = await service.work.run(request, function, service.settings, study, *asked)
        return await _follow(service, study, found, asked[0].dry_run)

    router.add_api_route(
        path,
        search,
        methods=["POST"],
        response_class=Document,
        responses=FOLLOW_UPS,
        summary=summary,
        description=function.__doc__,
        name=function.__name__,
        tags=["studies"],
    )


_add("/refine", "A follow-up study around the best design", refine, FollowUps, Search, Judging)
_add(
    "/refine-boundary",
    "A follow-up study around a change of response class",
    refine_class,
    *(FollowUps, Boundary, Step),
)


_add(
    "/particle-friction",
    "Follow-up studies of the best damper with friction on its particle",
    particle_friction,
    *(FollowUps, Judging),
)


async def _follow(service: Service, study: Record, found: Refinement, dry_run: bool) -> Document:
    document = refinement_document(found)
    if not found.studies or dry_run:
        return answered(study, {**document})
    return await run_sync(_submit, service, study, found, document, limiter=service.submissions)


def _submit(service: Service, study: Record, found: Refinement, document: Refined) -> Document:
    submitted = [
        service.store.submit(each, make_plan(each, seconds_per_point), provenance() | {REFINES: study.id})
        for each in found.studies
    ]
    service.dispatcher.wake()
    follow_ups = [
        {key: value for key, value in record.document().items() if key != "definition"}
        for record, _ in submitted
    ]
    answer: FollowUpsDocument = {
        "study": study.id,
        "name": study.name,
        "state": study.state,
        **document,
        "follow_up": follow_ups[0],
        "follow_ups": follow_ups,
    }
    created = any(new for _, new in submitted)
    location = {"Location": f"/api/v1/studies/{follow_ups[0]['id']}"}
    return Document(answer, 201 if created else 200, location)
