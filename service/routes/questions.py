"""Routes that evaluate the results of a study, also while the study runs."""

from inspect import cleandoc
from os import SEEK_END
from pathlib import Path
from typing import Annotated, Any, BinaryIO

from anyio.to_thread import run_sync
from starlette.requests import Request
from starlette.responses import Response, StreamingResponse
from typing_extensions import TypedDict

from damperlab.service.answer_types import gives
from damperlab.service.documents import Document
from damperlab.service.edge.conditional import TAGGED_BYTES
from damperlab.service.parameters import asks
from damperlab.service.problems import Problem, documented
from damperlab.service.questions.every import BY_ROUTE, EVERY
from damperlab.service.questions.question import Question, Subject, in_front
from damperlab.service.routes.strict import strict_router
from damperlab.service.state import TheService, TheStudy
from damperlab.service.work.apart import is_large, pieces, written
from damperlab.studies.kinds import EVERY_DIMENSION
from damperlab.studies.shapes import Says
from damperlab.studies.store.export.export import dimensions_of
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store
from damperlab.studies.units import quantities_of

router = strict_router("/api/v1/studies/{study_id}", "queries")


class StudyAxes(TypedDict):
    """The values of every dimension of a study, and the variables that it stores."""

    study: str
    axes: Annotated[dict[str, list[float | str]], Says(propertyNames={"enum": list(EVERY_DIMENSION)})]
    variables: list[str]
    in_units: Annotated[
        dict[str, float],
        Says(description="Factors from ratios to SI units, if the study has a structure."),
    ]


@router.get(
    "/axes",
    response_class=Document,
    responses={200: gives(StudyAxes), **documented(404, 503)},
    summary="The values of every dimension",
)
def axes(service: TheService, study: TheStudy) -> Document:
    """List the values along every dimension, the stored variables, and the factors from ratios to SI units."""
    cube = service.store.cube(study.id)
    return Document(
        StudyAxes(
            study=study.id,
            axes={name: cube[name].values.tolist() for name in dimensions_of(cube)},
            variables=[str(name) for name in cube.data_vars],
            in_units={each.source: each.factor for each in quantities_of(study.definition)},
        )
    )


def _add(question: Question[Any]) -> None:
    """Add the route of a question."""
    values = asks(*question.asks, dimensions=question.dimensions)

    async def ask(
        request: Request, service: TheService, study: TheStudy, asked: Annotated[tuple[Any, ...], values]
    ) -> Response:
        if not is_large(service, study):
            return await run_sync(_answer, service.store, study, question.route, asked)
        headers, file = await written(request, service, study, _write, question.route, asked)
        return await run_sync(_sent, file, headers)

    router.add_api_route(
        f"/{question.route}",
        ask,
        response_class=Document,
        responses={200: gives(question.gives), **documented(404, 409, 422, 429, 503)},
        summary=question.summary,
        description=cleandoc(question.answer.__doc__ or ""),
        name=question.operation or f"ask_{question.command}",
    )


for _question in EVERY:
    _add(_question)


def _answer(store: Store, study: Record, route: str, asked: tuple[Any, ...]) -> Document:
    question = BY_ROUTE[route]
    subject = Subject(study, store, question.route, http=True)
    document = question.form.write(question.of(subject, *asked))
    return answered(study, document)


def _write(store: Store, study: Record, place: Path, route: str, asked: tuple[Any, ...]) -> dict[str, str]:
    answer = _answer(store, study, route, asked)
    place.write_bytes(answer.body)
    return dict(answer.headers)


def _sent(file: BinaryIO, headers: dict[str, str]) -> Response:
    """Send the content of a file.

    A short file is sent in one piece, so that the answer gets an ETag and can be cached.
    """
    size = file.seek(0, SEEK_END)
    if size > TAGGED_BYTES:
        return StreamingResponse(pieces(file, 0, size), headers=headers)
    return Response(b"".join(pieces(file, 0, size)), headers=headers)


def answered(study: Record, answer: dict[str, Any]) -> Document:
    """Make the document of an answer, which begins with the id, the name and the state of the study.

    Raises
    ------
    Problem
        If the study was cancelled or failed before any point of the answer was computed (status 409). Such a
        study must be resumed before the question can be answered.
    """
    if study.state in ("cancelled", "failed") and answer.get("complete", 1) < 1:
        resume = f"POST /api/v1/studies/{study.id}/resume computes the missing points"
        if answer["complete"] == 0:
            detail = f"The study is {study.state}, and no requested point is computed. {resume}."
            raise Problem(409, f"study-{study.state}", detail)
        answer = answer | {"note": f"{answer['note']} The study is {study.state}: {resume}."}
    return Document(in_front(study, answer))
