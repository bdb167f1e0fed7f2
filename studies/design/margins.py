"""How far each quantity of a damper may move alone."""

from dataclasses import dataclass, replace
from itertools import takewhile

from damperlab.studies.design.build import Build
from damperlab.studies.design.score import Score
from damperlab.studies.design.search import CLOSE, Search
from damperlab.studies.design.steps import Step
from damperlab.studies.specification.specification import CHOSEN

MOVES = (0.02, 0.05, 0.1, 0.2, 0.4)
"""Shares by which each quantity is moved alone."""
WITHIN = 1.1
"""How much above the stated worst case one may come that is moved, where no limit says it."""


@dataclass(frozen=True)
class Margin:
    """How far one quantity may move alone: it holds from `low` to `high`, and was seen to fail at the values beyond."""

    low: float
    high: float
    fails_below: float | None
    fails_above: float | None


def margins_of(search: Search, build: Build, stated: Score) -> Step[dict[str, Margin]]:
    """Move each quantity alone, ever further, until a limit or the bound is exceeded."""
    asked = search.asked
    names = [name for name in CHOSEN if name in asked.free or name in asked.tolerances]
    if build.particle_mass_kg == 0.0:
        names = [name for name in names if name == "friction_force_n"]
    bound = WITHIN * stated.most
    moved: dict[tuple[str, int], list[tuple[float, Build]]] = {}
    for name in names:
        value = getattr(build, name)
        size = value or asked.choices[name].stop
        for sign in (-1, 1):
            values = [value + sign * share * size for share in MOVES]
            top = 1.0 if name == "restitution" else float("inf")
            low = 0.0 if name in ("friction_force_n", "restitution") else 1e-3 * size
            kept = [each for each in values if low <= each <= top]
            moved[name, sign] = [(each, replace(build, **{name: each})) for each in kept]
    yield from search.known((each for row in moved.values() for _, each in row), 0)

    def fails(moved_build: Build) -> bool:
        judged = search.score(moved_build)
        return judged.violation > stated.violation or (judged.value > bound and not asked.limits_measure)

    # a worst case can only grow: where the coarse look shows a failure, nothing beyond it needs a closer one
    near = (list(takewhile(lambda one: not fails(one[1]), row)) for row in moved.values())
    yield from search.known((each for row in near for _, each in row), CLOSE)
    found: dict[str, Margin] = {}
    for name in names:
        ends: list[float] = []
        beyond: list[float | None] = []
        for sign in (-1, 1):
            end, failed = getattr(build, name), None
            for value, each in moved[name, sign]:
                if fails(each):
                    failed = value
                    break
                end = value
            ends.append(end)
            beyond.append(failed)
        found[name] = Margin(ends[0], ends[1], beyond[0], beyond[1])
    return found
