"""Margins: by how much each quantity of a damper may change while all others stay."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import takewhile

from damperlab.studies.answers.particle_friction import COEFFICIENTS, WITHIN
from damperlab.studies.design.build import Build
from damperlab.studies.design.score import Score
from damperlab.studies.design.search import CLOSE, Search
from damperlab.studies.design.steps import Step
from damperlab.studies.quantity import PARTICLE_FRICTION
from damperlab.studies.shapes import Measured
from damperlab.studies.specification.damper import QUANTITIES
from damperlab.studies.specification.specification import OF_DAMPER, Specification, beside_rubbing

MOVED = "each quantity moved alone"
"""Name of the margins in the list of parts that the budget did not cover."""
MOVES = (0.02, 0.05, 0.1, 0.2, 0.4)
"""Relative changes of each quantity."""
FEW = 3
"""Number of changes examined first."""


@dataclass(frozen=True)
class Margin:
    """Range of one quantity while all others stay.

    Limits are kept from `low` to `high`, and exceeded at `fails_below` and `fails_above`. `fails_below` is
    None if no smaller examined value exceeds a limit, and `fails_above` if no larger examined value does.
    """

    low: Measured
    high: Measured
    fails_below: float | None
    fails_above: float | None

    def span(self, spelled: Callable[[float], str]) -> str:
        """Write the range. An end is marked if it is only the lowest or the highest examined value."""
        low, high = spelled(self.low), spelled(self.high)
        if low == high:
            return f"{low} only"
        lowest = " (the lowest examined)" if self.fails_below is None else ""
        highest = " (the highest examined)" if self.fails_above is None else ""
        return f"{low}{lowest} to {high}{highest}"


def margins_of(search: Search, build: Build, stated: Score) -> Step[dict[str, Margin]]:
    """Change each quantity alone in growing steps, until a limit or the bound is exceeded.

    If the specification assumes no friction of the particle in its cavity, this friction is also increased from 0.
    """
    moved: dict[tuple[str, int], list[tuple[float, Build]]] = {}
    names = _moved(search, build)
    for name in names:
        for sign in (-1, 1):
            values = (_value(search, build, name, sign * share) for share in MOVES)
            kept = [each for each in values if each is not None]
            moved[name, sign] = [(each, build.with_values({name: each})) for each in kept]
    if build.particle_mass_kg > 0.0 and _may_rub(search.asked):
        names.append(PARTICLE_FRICTION.name)
        moved[PARTICLE_FRICTION.name, -1] = []
        rubbing = [(each, build.with_values({PARTICLE_FRICTION.name: each})) for each in COEFFICIENTS]
        moved[PARTICLE_FRICTION.name, 1] = rubbing
    # a worst case can only grow with more frequencies, so changes beyond a failure are not examined
    near: dict[tuple[str, int], list[Build]] = {key: [] for key in moved}
    for first, last in ((0, FEW), (FEW, None)):
        further = {
            key: [each for _, each in row[first:last]]
            for key, row in moved.items()
            if len(near[key]) == first
        }
        yield from search.known(_in_doubt(search, further.values(), stated), 0)
        for key, row in further.items():
            near[key] += takewhile(lambda each: not _fails(search, each, stated), row)
    yield from search.known((each for row in near.values() for each in row), CLOSE)
    found: dict[str, Margin] = {}
    for name in names:
        ends: list[float] = []
        beyond: list[float | None] = []
        for sign in (-1, 1):
            end, failed = build.value(name), None
            for value, each in moved[name, sign]:
                if _fails(search, each, stated):
                    failed = value
                    break
                end = value
            ends.append(end)
            beyond.append(failed)
        found[name] = Margin(ends[0], ends[1], beyond[0], beyond[1])
    return found


def _moved(search: Search, build: Build) -> list[str]:
    """Return the names of the quantities of a damper that are chosen or have tolerances."""
    asked = search.asked
    names = [name for name in OF_DAMPER if name in asked.free or name in asked.tolerances]
    if build.particle_mass_kg == 0.0:
        names = [name for name in names if name == "friction_force_n"]
    return names


def _may_rub(asked: Specification) -> bool:
    """Whether the specification assumes no friction of the particle, but could be combined with such friction."""
    beside = beside_rubbing(asked.in_units, asked.choices)
    return not asked.rubs and not any(beside.values())


def _value(search: Search, build: Build, name: str, share: float) -> float | None:
    """Return a quantity after a relative change; None if the changed value is not allowed.

    The change is relative to the end of the range if the value is 0.
    """
    value = build.value(name)
    size = value or search.asked.choices[name].stop
    top = QUANTITIES[name].highest
    low = 0.0 if name not in ("clearance_m", "particle_mass_kg") else 1e-3 * size
    moved = float(value + share * size)
    return moved if low <= moved <= top else None


def _in_doubt(search: Search, rows: Iterable[list[Build]], stated: Score) -> list[Build]:
    """Return the builds that exceed the limits on the damper by at most `stated.violation`.

    A build with a larger excess fails, so its response need not be computed.
    """
    return [each for row in rows for each in row if each.excess(search.asked) <= stated.violation]


def _fails(search: Search, moved: Build, stated: Score) -> bool:
    """Whether a build exceeds a limit by more than `stated.violation`, or exceeds the bound of the measure.

    If the measure has a limit, there is no bound; otherwise the bound is `WITHIN` times the stated worst
    case.
    """
    if moved.excess(search.asked) > stated.violation:
        return True
    judged = search.score(moved)
    within = search.asked.limits_measure or judged.value <= WITHIN * stated.most
    return judged.violation > stated.violation or not within
