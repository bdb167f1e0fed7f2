"""The grid of a study: the values along each of its dimensions."""

from fastapi import APIRouter

from damperlab.service.answer_schemas import gives
from damperlab.service.documents import Document
from damperlab.service.problems import documented
from damperlab.service.routes.questions import router as questions
from damperlab.service.state import TheService, TheStudy
from damperlab.studies.store.export.export import dimensions_of

router = APIRouter(prefix=questions.prefix, tags=["queries"])


@router.get(
    "/axes",
    response_class=Document,
    responses={200: gives("StudyAxes"), **documented(404, 503)},
    summary="The values of every dimension",
)
def axes(service: TheService, study: TheStudy) -> Document:
    """List the grid's values by dimension, and the names of the variables that the study stores."""
    cube = service.store.cube(study.id)
    return Document(
        {
            "study": study.id,
            "axes": {name: cube[name].values for name in dimensions_of(cube)},
            "variables": [str(name) for name in cube.data_vars],
        }
    )
