"""From a specification to an answer: the search, what builds do, how far each dimension may move, and what else there is."""

from collections.abc import Generator, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
import xarray as xr

from damperlab.studies.definition import Study
from damperlab.studies.design.absorber import Beside, tuned_beside
from damperlab.studies.design.book import Book, BudgetSpent, Wanted
from damperlab.studies.design.build import Build
from damperlab.studies.design.intervals import clopper_pearson
from damperlab.studies.design.score import Score, score, worst
from damperlab.studies.design.search import CLOSE, CLOSEST, Effort, Search, amplitudes_of
from damperlab.studies.faults import Fault, StudyFaults, counted
from damperlab.studies.specification.specification import CHOSEN, LIMITED, OF_STRUCTURE, Choice, Specification

SMALL = {
    "friction_alone": Effort(kept=4, finalists=3, rounds=1, reserve=0.4),
    "particle_alone": Effort(kept=4, finalists=3, rounds=1, reserve=0.2),
}
"""Of the searches for what the answer is compared with."""
AMPLITUDES = 7
"""Base amplitudes under which the recommended damper is looked at."""
SHOWN = 9
"""Base amplitudes of the figure that shows where the damper stops working."""
MOVES = (0.01, 0.02, 0.05, 0.1, 0.2, 0.4)
"""Shares by which each quantity is moved alone."""
WITHIN = 1.1
"""How much above the stated worst case one may come that is moved, where no limit says it."""
SEED = 20
"""Of builds and starts drawn: the same ones in every run."""
STARTS = 12
"""Starts of the damper as drawn, one of them rest."""
FOR_BUILDS = 0.5
"""Share of what is left of the budget that builds may take."""
WORST = 5
"""Builds drawn whose peaks are bracketed: those that may be the worst."""
OF_DAMPER = {
    "friction_alone": ("clearance_m", "particle_mass_kg", "restitution"),
    "particle_alone": ("friction_force_n",),
}
"""What each part of the damper is without."""
CALLED = {"friction_alone": "friction alone", "particle_alone": "the particle alone"}


@dataclass(frozen=True)
class Alternative:
    """Another damper for the same specification.

    Parameters
    ----------
    build : Build
        The best that was found.
    score : Score
        Its worst case over band, amplitudes and the corners of its tolerances.
    """

    build: Build
    score: Score


@dataclass(frozen=True)
class Builds:
    """What builds within the tolerances do.

    Parameters
    ----------
    drawn, passed : int
        How many, and how many keep every limit (where there is none, the stated bound).
    low, high : float
        Interval of the probability.
    bound : float or None
        What counted as kept where the specification has no limit, in the unit of the measure.
    """

    drawn: int
    passed: int
    low: float
    high: float
    bound: float | None


@dataclass(frozen=True)
class Margin:
    """How far one quantity may move alone: it holds from `low` to `high`, and was seen to fail at the values beyond."""

    low: float
    high: float
    fails_below: float | None
    fails_above: float | None


@dataclass(frozen=True)
class Starts:
    """What other starts than rest lead the damper as drawn to, under the largest base amplitude.

    Parameters
    ----------
    count, frequencies : int
        Starts at each of so many frequencies.
    several : int
        Frequencies at which they lead to more than one response.
    worst : float
        The largest amplitude of any, in the unit of lengths.
    frequency_ratio : float
        Where that is.
    beyond : int
        Frequencies at which some start leads to more than the stated worst case is at most.
    """

    count: int
    frequencies: int
    several: int
    worst: float
    frequency_ratio: float
    beyond: int


@dataclass(frozen=True)
class Found:
    """All that a search has found.

    Parameters
    ----------
    asked, book : Specification, Book
        What was asked, and every point.
    build : Build
        The recommended damper.
    nominal, compared, stated : Score
        Its worst case as drawn; with the corners of its tolerances, as the alternatives are judged; and with
        everything that was computed of it.
    builds : Builds or None
        None without tolerances.
    margins : dict of Margin
        By quantity.
    alternatives : dict of Alternative
        `friction_alone`, `particle_alone`.
    absorber : Beside or None
        The tuned mass damper.
    front : tuple of (float, Score)
        Where the mass is chosen: the best response of every mass looked at that none lighter reaches.
    shown : tuple of float
        Base amplitudes under which the damper as drawn is known at every frequency of the survey, also beyond the range.
    starts : Starts or None
        What other starts than rest lead to; None where something else than the displacement is measured,
        or where the budget did not allow it.
    as_good : int
        Further dampers judged that may be as good within the errors.
    stopped : str
        "complete" or "budget".
    step : float
        The last step, as a share of the ranges.
    left_out : tuple of str
        What the budget did not allow.
    """

    asked: Specification
    book: Book
    build: Build
    nominal: Score
    compared: Score
    stated: Score
    builds: Builds | None
    margins: dict[str, Margin]
    alternatives: dict[str, Alternative]
    absorber: Beside | None
    front: tuple[tuple[float, Score], ...]
    shown: tuple[float, ...]
    starts: Starts | None
    as_good: int
    stopped: str
    step: float
    left_out: tuple[str, ...]


T = TypeVar("T")
Step = Generator[list[Wanted] | Study, None, T]
"""A part of a search: yields what must be known next."""


@dataclass(frozen=True)
class Ask:
    """What a search needs next.

    Parameters
    ----------
    studies : tuple of Study
        To be computed, but for those that are stored.
    stage : str
        What they are for.
    spent, budget : int
        Points known, and most points.
    """

    studies: tuple[Study, ...]
    stage: str
    spent: int
    budget: int


Rounds = Generator[Ask, Iterable[xr.Dataset], Found]
"""Asks for studies, is sent their cubes, returns what was found."""


def designing(asked: Specification, budget: int) -> Rounds:
    """Search: ask for the studies that must be known next, be sent their cubes, and return what was found.

    What it asks for depends on the specification, the budget and the values of the cubes alone, so a search that was
    interrupted is begun anew: what it asks for is stored already, up to where it was.

    Parameters
    ----------
    asked : Specification
        What is designed.
    budget : int
        Most points. The search leaves half of them for what follows it, and ends where it would not.

    Raises
    ------
    StudyFaults
        If the budget does not allow the first look.
    """
    book = Book(asked, budget)
    steps = _steps(asked, book)
    try:
        wanted = next(steps)
        while True:
            studies = (wanted,) if isinstance(wanted, Study) else book.studies(wanted)
            if sum(study.points for study in studies) > book.left:
                wanted = steps.throw(BudgetSpent())
                continue
            if studies:
                cubes = yield Ask(studies, book.stage, book.spent, budget)
                book.add(cubes)
            wanted = next(steps)
    except StopIteration as end:
        found: Found = end.value
        return found


def next_round(asked: Specification, budget: int, cubes: Mapping[str, xr.Dataset]) -> Ask | Found:
    """Give what a search needs next, or what it has found.

    Parameters
    ----------
    asked, budget
        As in `designing`.
    cubes : mapping of Dataset
        What is done, by the digest of its study; more than is needed does no harm.

    Returns
    -------
    Ask or Found
        The first round of which a cube is missing, with all its studies.
    """
    rounds = designing(asked, budget)
    try:
        ask = next(rounds)
        while all(study.digest in cubes for study in ask.studies):
            ask = rounds.send([cubes[study.digest] for study in ask.studies])
    except StopIteration as end:
        found: Found = end.value
        return found
    return ask


def _steps(asked: Specification, book: Book) -> Step[Found]:
    search = Search(asked, book)
    _require(search)
    best = yield from search.run()
    build = search.lattice.build(best)
    compared = search.robust[best]
    judged = [compared]
    left: list[str] = []
    scan = amplitudes_of(asked, AMPLITUDES)
    book.stage = f"{counted(len(scan), 'base amplitude')} of the recommended damper"
    yield from _within(search.known([build], CLOSE + 1, scan), left, "further base amplitudes of the range")
    nominal = score(book, build, (*scan, *search.amplitudes))
    judged.append(nominal)
    as_good = sum(
        other.value - other.error < compared.most and other.violation <= compared.violation
        for candidate, other in search.robust.items()
        if candidate != best
    )
    drawn: list[Build] = []
    if asked.tolerances and asked.builds:
        book.stage = "builds drawn within the tolerances"
        drawn = (yield from _within(_drawn(search, build), left, "builds within the tolerances")) or []
    alternatives: dict[str, Alternative] = {}
    for name, parts in OF_DAMPER.items():
        book.stage = f"the best of {CALLED[name]}"
        found = yield from _within(
            _alternative(without(asked, parts), book, SMALL[name]), left, f"the best of {CALLED[name]}"
        )
        if found is not None:
            alternatives[name] = found
    book.stage = "each quantity moved alone"
    margins = yield from _within(_margins(search, build, worst(judged)), left, "each quantity moved alone")
    front: tuple[tuple[float, Score], ...] | None = ()
    if "particle_mass_kg" in search.lattice.names:
        book.stage = "response against mass"
        front = yield from _within(_front(search), left, "response against mass")
    book.stage = f"the recommended damper from {STARTS} starts"
    yield from _within(_started(search, build, nominal), left, "other starts than rest")
    shown = tuple(float(each) for each in np.geomspace(*beyond_of(asked), SHOWN))
    book.stage = "the recommended damper beyond its base amplitudes"
    yield from _within(search.known([build], CLOSE, shown), left, "base amplitudes beyond the range")
    scores = [search.score(each) for each in drawn]
    stated = worst([*judged, *scores])
    return Found(
        asked=asked,
        book=book,
        build=build,
        nominal=nominal,
        compared=compared,
        stated=stated,
        builds=_counted(asked, scores, worst(judged).most) if scores else None,
        margins=margins or {},
        alternatives=alternatives,
        absorber=tuned_beside(asked, build.particle_mass_kg / asked.structure.mass_kg),
        front=front or (),
        shown=tuple(each for each in shown if book.curve(build, each).r.size),
        starts=_starts(asked, book.from_many_starts, stated.most),
        as_good=as_good,
        stopped=search.stopped or "complete",
        step=search.step,
        left_out=tuple(left),
    )


def beyond_of(asked: Specification) -> tuple[float, float]:
    """Give the base amplitudes between which a damper is shown: half the least to twice the largest."""
    return asked.excitation.lowest_m / 2.0, asked.excitation.highest_m * 2.0


def _within(step: Step[T], left_out: list[str], what: str) -> Step[T | None]:
    """Take a step that is no part of the search; where the budget does not allow it, note that and give None."""
    try:
        return (yield from step)
    except BudgetSpent:
        left_out.append(what)
        return None


def _started(search: Search, build: Build, nominal: Score) -> Step[None]:
    """Compute the damper as drawn from several starts."""
    asked, book = search.asked, search.book
    mass = build.place(asked.structure, asked.excitation.highest_m)[2]
    at = (*search.survey.sample(mass, 0.0, False), build.own(nominal.frequency_ratio))
    study = book.from_starts(build, asked.excitation.highest_m, at, STARTS, SEED)
    yield study


def _starts(asked: Specification, cube: xr.Dataset, bound: float) -> Starts | None:
    """Sum up what starts lead to, where the displacement is what is measured."""
    if asked.measure.variable != "amplitude_ratio" or "amplitude_ratio_worst" not in cube:
        return None
    worst_of = cube["amplitude_ratio_worst"].values.ravel() * asked.excitation.highest_m
    if not np.isfinite(worst_of).any():
        return None
    place = int(np.nanargmax(worst_of))
    return Starts(
        count=STARTS,
        frequencies=worst_of.size,
        several=int((cube["attractors"].values > 1).sum()),
        worst=float(worst_of[place]),
        frequency_ratio=float(cube["frequency_ratio"].values[place]),
        beyond=int((worst_of > bound).sum()),
    )


def _require(search: Search) -> None:
    """Refuse a budget that ends before the first look does."""
    first = search.book.lacking(search.first_look())
    if first <= search.book.budget / 2:
        return
    found = f"{search.book.budget:,} points"
    told = (
        f"{{field}} allows {found}; the first look at {len(search.lattice.first()):,} dampers takes {first:,}, and as many "
        "are kept for what follows."
    )
    advice = "give more minutes, choose fewer quantities, or give one base amplitude in place of a range"
    raise StudyFaults([Fault("budget_minutes", found, f"at least {2 * first:,} points", advice, told)])


def without(asked: Specification, parts: tuple[str, ...]) -> Specification:
    """Give the specification of a damper without some of its parts."""
    gone = {name: Choice(0.0, 0.0) if name != "clearance_m" else Choice(1.0, 1.0) for name in parts}
    kept = {name: each for name, each in asked.tolerances.items() if name not in parts}
    return replace(asked, choices={**asked.choices, **gone}, tolerances=kept)


def _alternative(asked: Specification, book: Book, effort: Effort) -> Step[Alternative]:
    search = Search(asked, book, effort, told=False)
    best = yield from search.run()
    return Alternative(search.lattice.build(best), search.robust[best])


def _front(search: Search) -> Step[tuple[tuple[float, Score], ...]]:
    """Know the best candidate of every mass that was looked at closely, and keep those that no lighter one reaches."""
    place = search.lattice.names.index("particle_mass_kg")
    found: list[tuple[float, Score]] = []
    for mass in sorted({each[place] for each in search.lattice.first()}):
        same = [each for each in search.pool if each[place] == mass]
        while True:
            build = search.lattice.build(
                min(same, key=lambda each: (*search.score(search.lattice.build(each)).rank, each))
            )
            if search.close(build):
                break
            yield from search.known([build], CLOSEST)
        found.append((build.particle_mass_kg, search.score(build)))
    kept: list[tuple[float, Score]] = []
    for weight, each in found:
        if all(each.rank < other.rank for _, other in kept):
            kept.append((weight, each))
    return tuple(kept)


def _margins(search: Search, build: Build, stated: Score) -> Generator[list[Wanted], None, dict[str, Margin]]:
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
    yield from search.known((each for row in moved.values() for _, each in row), CLOSE)
    found: dict[str, Margin] = {}
    for name in names:
        ends: list[float] = []
        fails: list[float | None] = []
        for sign in (-1, 1):
            end, failed = getattr(build, name), None
            for value, each in moved[name, sign]:
                judged = search.score(each)
                if judged.violation > stated.violation or (judged.value > bound and not _limited(asked)):
                    failed = value
                    break
                end = value
            ends.append(end)
            fails.append(failed)
        found[name] = Margin(ends[0], ends[1], fails[0], fails[1])
    return found


def _limited(asked: Specification) -> bool:
    """Whether a limit is on what is measured."""
    return any(LIMITED[name][0] == asked.measure.variable for name in asked.limits)


def _drawn(search: Search, build: Build) -> Step[list[Build]]:
    """Draw builds within the tolerances, and know them at every frequency at which the drawn damper is known."""
    asked, book = search.asked, search.book
    names = [name for name in (*CHOSEN, *OF_STRUCTURE) if name in asked.tolerances]
    shares = np.random.default_rng(SEED).uniform(-1.0, 1.0, (asked.builds, len(names)))
    every = [build.moved(asked, dict(zip(names, row, strict=True))) for row in shares.tolist()]
    wanted = [list(_beside(search, build, each)) for each in every]
    room = FOR_BUILDS * book.left
    count, cost = 0, 0
    for one in wanted:
        cost += sum(len(each.frequencies) for each in one)
        if cost > room:
            break
        count += 1
    if count == 0:
        raise BudgetSpent
    yield [each for one in wanted[:count] for each in one]
    drawn = every[:count]
    likely = sorted(drawn, key=lambda each: search.score(each).most)[-WORST:]
    yield from _within(search.known(likely, CLOSE + 1), [], "")
    return drawn


def _beside(search: Search, nominal: Build, build: Build) -> Iterable[Wanted]:
    asked = search.asked
    low, high = build.own(asked.excitation.low), build.own(asked.excitation.high)
    for amplitude in search.amplitudes:
        mass = build.place(asked.structure, amplitude)[2]
        sampled = search.survey.sample(mass, build.natural_frequency_hz, True)
        curve = search.book.curve(nominal, amplitude)
        near = [r for r in curve.r.tolist() if low <= r <= high]
        yield Wanted(build, amplitude, tuple(sorted({*sampled, *near})))


def _counted(asked: Specification, scores: list[Score], bound: float) -> Builds:
    passed = sum(each.violation == 0.0 if asked.limits else each.value <= bound for each in scores)
    low, high = clopper_pearson(passed, len(scores), asked.confidence)
    return Builds(len(scores), passed, low, high, None if asked.limits else bound)
