"""Questions that compare: with a tuned mass damper, and error with run time."""

from typing import Annotated

from fastapi import APIRouter, Query
from pydantic import BaseModel, ConfigDict, Field

from damperlab.service.comparisons import columns_document
from damperlab.service.documents import Document
from damperlab.service.routes.queries import ANSWER, AlongFrequency, answered
from damperlab.service.routes.queries import router as queries
from damperlab.service.state import TheService, TheStudy
from damperlab.studies.answers.survey import require_harmonic
from damperlab.studies.answers.tmd_comparison import MOST_DETUNING, MOST_MASS, tmd_comparison
from damperlab.studies.answers.work_precision import work_precision
from damperlab.studies.tmd.tunings import CRITERIA
from damperlab.studies.vocabulary import Criterion, Excitation

router = APIRouter(prefix=queries.prefix, tags=["queries"], dependencies=queries.dependencies)

_TUNINGS = "; ".join(f"{name}: {meaning}" for name, meaning in CRITERIA.items())


class Nothing(BaseModel):
    """No parameters: a name that nobody reads would change nothing without a word."""

    model_config = ConfigDict(extra="forbid")


class TmdQuery(AlongFrequency):
    """Parameters of a comparison with a tuned mass damper."""

    mass_ratio: float | None = Field(
        None, gt=0, le=MOST_MASS, allow_inf_nan=False, description="μ; that of the design without it."
    )
    criterion: Criterion = Field("minimax", description=f"How it is tuned. {_TUNINGS}.")
    detuning: float = Field(
        0.0,
        gt=-1,
        le=MOST_DETUNING,
        allow_inf_nan=False,
        description="Relative error of the tuned mass damper's frequency.",
    )
    damping_detuning: float = Field(
        0.0,
        gt=-1,
        le=MOST_DETUNING,
        allow_inf_nan=False,
        description="Relative error of the tuned mass damper's damping.",
    )
    excitation: Excitation = Field(
        "base",
        description="What the tuned mass damper answers to; force: on the structure, X over its static deflection.",
    )


@router.get(
    "/tmd-comparison",
    **ANSWER,
    summary="One design compared with a tuned mass damper",
)
def ask_tmd(service: TheService, study: TheStudy, query: Annotated[TmdQuery, Query()]) -> Document:
    """Compare both curves, their peaks, bandwidths and ratio; the masses are equal unless told otherwise."""
    require_harmonic(study.dimensions, "tmd-comparison")
    at = {name: value for name, value in query.at().items() if name != "mass_ratio"}
    answer = tmd_comparison(
        service.store.cube(study.id),
        query.criterion,
        query.mass_ratio,
        query.detuning,
        query.damping_detuning,
        at,
        query.excitation,
    )
    return answered(study, columns_document(answer))


@router.get(
    "/work-precision",
    **ANSWER,
    summary="Error against run time over the points",
)
def ask_precision(service: TheService, study: TheStudy, query: Annotated[Nothing, Query()]) -> Document:
    """Sort the points by run time, and say how exact those of each time are."""
    require_harmonic(study.dimensions, "work-precision")
    return answered(study, columns_document(work_precision(service.store.cube(study.id))))
