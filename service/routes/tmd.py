"""Questions that compare: with a tuned mass damper, and error with run time."""

from typing import Annotated

from fastapi import APIRouter

from damperlab.service.comparisons import columns_document
from damperlab.service.documents import Document
from damperlab.service.parameters import asks
from damperlab.service.routes.queries import answered, answers
from damperlab.service.routes.queries import router as queries
from damperlab.service.state import TheService, TheStudy
from damperlab.studies.amplitudes import AMPLITUDE
from damperlab.studies.answers.fragility import fragility
from damperlab.studies.answers.importance import importance
from damperlab.studies.answers.one_amplitude import at_one_amplitude, said_of_it
from damperlab.studies.answers.suite import require_harmonic
from damperlab.studies.answers.tmd_comparison import tmd_comparison
from damperlab.studies.answers.work_precision import work_precision
from damperlab.studies.questions import Design, Fragile, Tuning, Varied
from damperlab.studies.variables import BEFORE, DIMENSIONS

router = APIRouter(prefix=queries.prefix, tags=["queries"])


@router.get(
    "/tmd-comparison",
    **answers("TmdComparison"),
    summary="One design compared with a tuned mass damper",
)
def ask_tmd(
    service: TheService,
    study: TheStudy,
    asked: Annotated[
        tuple[Tuning, Design], asks(Tuning, Design, dimensions=(*BEFORE, *DIMENSIONS, AMPLITUDE))
    ],
) -> Document:
    """Compare both curves, their peaks, bandwidths and ratio; the masses are equal unless told otherwise."""
    tuning, design = asked
    require_harmonic(study.dimensions, "tmd-comparison", amplitudes=True)
    whole = service.store.cube(study.id)
    cube, at = at_one_amplitude(whole, design.at)
    answer = said_of_it(tmd_comparison(cube, tuning, at), cube, whole)
    return answered(study, columns_document(answer))


@router.get(
    "/importance",
    **answers("Importance"),
    summary="Which parameter matters",
)
def ask_importance(
    service: TheService, study: TheStudy, asked: Annotated[tuple[Varied], asks(Varied)]
) -> Document:
    """Share out the variance of a result over the grid: what each parameter explains alone, and what combinations do."""
    (varied,) = asked
    return answered(study, columns_document(importance(service.store.cube(study.id), varied)))


@router.get(
    "/fragility",
    **answers("Fragility"),
    summary="How likely a damper exceeds a limit as the records are scaled up",
)
def ask_fragility(
    service: TheService, study: TheStudy, asked: Annotated[tuple[Fragile], asks(Fragile)]
) -> Document:
    """Fit the probability of exceeding a limit over the scale of the records of a ground-motion suite."""
    (fragile,) = asked
    return answered(study, columns_document(fragility(service.store.cube(study.id), fragile)))


@router.get(
    "/work-precision",
    **answers("WorkPrecision"),
    summary="Error against run time over the points",
)
def ask_precision(service: TheService, study: TheStudy, asked: Annotated[tuple[()], asks()]) -> Document:
    """Sort the points by run time, and say how exact those of each time are."""
    require_harmonic(study.dimensions, "work-precision")
    return answered(study, columns_document(work_precision(service.store.cube(study.id))))
