"""The budget of a design: converts core minutes into points."""

from typing_extensions import TypedDict

from damperlab.studies.plan import make_plan
from damperlab.studies.shapes import Count
from damperlab.studies.specification.specification import Specification
from damperlab.worker.dispatch.cost_model import seconds_per_point

FEWEST, MOST = 100, 10_000_000
"""Smallest and largest number of points of a budget."""
HERE_SECONDS = 2.0
"""A study with at most this expected time [s] is computed by the searching process itself, because a cluster would take
longer.
"""


class DesignSize(TypedDict):
    """Content of a specification, and the points within its budget."""

    name: str
    digest: str
    chosen: list[str]
    budget_points: Count
    understood: list[str]


def size_document(asked: Specification, budget: int, understood: list[str]) -> DesignSize:
    """Describe a specification, without computing."""
    return {
        "name": asked.name,
        "digest": asked.digest,
        "chosen": list(asked.free),
        "budget_points": budget,
        "understood": understood,
    }


def budget_of(asked: Specification) -> int:
    """Convert the budget of a specification into points, by the expected time of its first look.

    The budget is in points instead of seconds, so that a design is the same on every machine.
    """
    if asked.budget_points is not None:
        return asked.budget_points
    from damperlab.studies.design.design import (
        designing,  # imported here: a service needs only the names above
    )

    first = next(designing(asked, MOST)).studies
    seconds = sum(float(make_plan(study, seconds_per_point).block_seconds.sum()) for study in first)
    points = sum(study.points for study in first)
    return min(max(int(60.0 * asked.budget_minutes * points / seconds), FEWEST), MOST)
