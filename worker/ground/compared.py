"""Types for the result of a comparison of dampers under one record."""

from dataclasses import dataclass, field
from typing import Annotated, Any

from typing_extensions import TypedDict

from damperlab.studies.ground.motion import MotionOfId
from damperlab.studies.shapes import Like, Measured, Says, Table
from damperlab.studies.vocabulary import CASES, Criterion
from damperlab.worker.ground.measures import GroundResponse


@dataclass(frozen=True, kw_only=True)
class _Case(GroundResponse):
    label: str
    spread: Table = field(default_factory=dict)


class Tuned(TypedDict):
    """Parameters of a tuned mass damper, and the criterion by which it was tuned."""

    criterion: Criterion
    mass_ratio: Measured
    tuning: Measured
    damping_ratio: Measured


class Comparison(TypedDict):
    """Result of a comparison of dampers under one record."""

    record: MotionOfId
    length_scale_m: Measured
    design: dict[str, Measured]
    contact: Annotated[dict[str, Any], Says(required=["model"])]
    tmd: Tuned | None
    cases: Annotated[
        dict[str, Annotated[dict[str, Any], Like(_Case)]], Says(propertyNames={"enum": list(CASES)})
    ]
