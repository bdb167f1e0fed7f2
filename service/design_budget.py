"""Converts the budget of a design from core minutes into a number of points."""

from typing_extensions import TypedDict

from damperlab.studies.plan import make_plan
from damperlab.studies.shapes import Count
from damperlab.studies.specification.specification import Specification
from damperlab.worker.dispatch.cost_model import seconds_per_point

FEWEST, MOST = 100, 10_000_000
"""Smallest and largest budget, in points."""
HERE_SECONDS = 2.0
"""Longest expected run time of a study that a process computes without a cluster [s]."""


class DesignSize(TypedDict):
    """Summary of a specification, with its budget in points."""

    name: str
    digest: str
    chosen: list[str]
    budget_points: Count
    understood: list[str]


def size_document(asked: Specification, budget: int, understood: list[str]) -> DesignSize:
    """Return the summary of a specification."""
    return {
        "name": asked.name,
        "digest": asked.digest,
        "chosen": list(asked.free),
        "budget_points": budget,
        "understood": understood,
    }


def budget_of(asked: Specification) -> int:
    """Return the budget of a specification in points.

    A budget in minutes is converted with the expected time per point of the first round of studies. The search counts
    points instead of seconds, so that the design is the same on every machine.
    """
    if asked.budget_points is not None:
        return asked.budget_points
    from damperlab.studies.design.design import (
        designing,  # imported only here, because the start of the service does not need it
    )

    first = next(designing(asked, MOST)).studies
    seconds = sum(float(make_plan(study, seconds_per_point).block_seconds.sum()) for study in first)
    points = sum(study.points for study in first)
    return min(max(int(60.0 * asked.budget_minutes * points / seconds), FEWEST), MOST)
