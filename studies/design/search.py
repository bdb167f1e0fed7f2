"""The search: scipy's optimisers request dampers, and each damper is computed only as accurately as necessary.

First, dampers all over the ranges are computed coarsely. Simplices then start from the best of these dampers,
and go downhill on accurate values. The coarse value of a damper is a lower bound of its accurate value. So
finally, every damper with a coarse value below the value of the best damper is computed accurately, too.

The search is a generator: it yields the points that it needs next, and continues when these points are in the book.
The requests depend only on the specification and on the values in the book.

The value of a damper is the worst case of the nominal build and of the builds at the corners of the
tolerances. Every maximum over the frequency is bracketed equally finely. A worst case can only grow as more
frequencies are computed, so a damper is refined only while it may be near the best. The recommended damper is
refined most.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from damperlab.studies.design.book import Book, BudgetSpent, Wanted
from damperlab.studies.design.build import Build
from damperlab.studies.design.curve import halved
from damperlab.studies.design.frequencies import SHOWN, Survey, between, brackets, onsets
from damperlab.studies.design.optimisers import SIZES, Effort, best_apart, descended, spread
from damperlab.studies.design.score import Score, score, worst
from damperlab.studies.design.space import Candidate, Space, amplitudes_of, corners_of
from damperlab.studies.design.steps import Step
from damperlab.studies.faults import counted
from damperlab.studies.specification.excitation import ONCE, Amplitude, Case, Under
from damperlab.studies.specification.specification import Specification

Asks = Step[None]

FEW = 3
"""Number of amplitudes of each excitation under which candidates are judged."""
CLOSE = 1
"""Accuracy level of a build that was computed at every frequency of the survey."""
CLOSEST = 3
"""Accuracy level at which dampers are compared. After two more rounds of brackets, the frequency of each maximum is
known to a 64th of the survey's steps.
"""
BETWEEN, SURE = 4, 6
"""Accuracy levels of the recommended damper. At level `BETWEEN` every interval near the largest response is divided.
Two rounds of brackets follow, up to level `SURE`.
"""
ONSETS = 2
"""Number of times that the intervals in which impacts set in are divided. After the divisions, the intervals
have a 64th of the width of the survey's steps.
"""
NEAR = 0.95
"""After the first round of brackets, a maximum is bracketed only if it reaches this share of the largest value. A build
is computed further only if its worst case reaches this share of the largest worst case. Builds that exceed a limit are
always computed further, and so are all builds if the rms is judged.
"""
MARGIN = 0.05
"""A damper is refined only if its value (see `Search.value`) exceeds the best value by at most this margin."""
LIKELY = 6
"""Largest number of dampers computed accurately in a step before the simplices start or after they end."""
WORST, EXCEEDING = 1e4, 1e3
"""Value (see `Search.value`) of a damper with an unbounded response, and smallest value of a damper that exceeds
a limit."""
LEAST = 1e-300


@dataclass
class Search:
    """One search for the best damper of a specification.

    Parameters
    ----------
    asked : Specification
        The specification of the damper.
    book : Book
        The book of known points, which other searches share.
    effort : Effort
        Limits on the number of dampers that the search examines.
    told : bool
        Whether this search writes its activity and its best damper into the book, for display.
    """

    asked: Specification
    book: Book
    effort: Effort = field(default_factory=Effort)
    told: bool = True
    stopped: str = ""
    glances: dict[Candidate, float] = field(default_factory=dict)
    """A lower bound of the value, for each candidate that was computed coarsely."""
    values: dict[Candidate, float] = field(default_factory=dict)
    """The value of each candidate that was selected for an accurate computation. For a candidate far from the
    best, the computation was stopped early, and the value is only a lower bound."""
    robust: dict[Candidate, Score] = field(default_factory=dict)
    """The worst case within the tolerances, for each candidate that was near the best."""

    def __post_init__(self) -> None:
        """Choose the frequencies, the amplitudes and the corners of the tolerances."""
        self.space = Space(self.asked)
        self.surveys = {each: Survey.of(self.asked, each) for each in self.asked.excitations}
        self.amplitudes = amplitudes_of(self.asked, FEW)
        self.corners = corners_of(self.asked)
        self.room = self.book.left
        """Number of points that this search may still request."""
        self._level: dict[Build, int] = {}

    def run(self, most: int | None = None) -> Step[Candidate]:
        """Search for the best candidate within the budget, and return this candidate.

        Parameters
        ----------
        most : int, optional
            Largest number of points that the search requests; by default all points that the book has left.

        Raises
        ------
        BudgetSpent
            If `most` points do not cover the coarse computation of the first candidates.
        """
        most = self.book.left if most is None else most
        reserve = self.effort.reserve * most
        self.room = most - math.ceil(reserve)
        try:
            yield from self._search()
        except BudgetSpent:
            self.stopped = "budget"
        self.room += math.ceil(reserve) - math.ceil(self.effort.left * reserve)
        if not self.robust:
            if not self.glances:
                raise BudgetSpent
            # no candidate was judged with its tolerances; take the best candidate of the coarse computation
            (best,) = best_apart(self.glances, 1)
            self.robust[best] = self.judged(best)
        try:
            yield from self.assured()
        except BudgetSpent:
            self.stopped = "budget"
        return self.best()

    @property
    def ended(self) -> str:
        """The reason why the search ended; see `ended` of `Found`."""
        if self.stopped:
            return self.stopped
        if not self.space.names:
            return "nothing"
        return "lists" if self.space.every() else "converged"

    def first(self) -> list[Candidate]:
        """Return the candidates that are computed first."""
        return next(spread(self.space, {}, self.effort))

    def first_look(self) -> list[Wanted]:
        """Return the points for the coarse computation of the first candidates."""
        builds = map(self.space.build, self.first())
        return [one for build in builds for one in self._samples_of(build, 0, self.amplitudes)]

    @property
    def examined(self) -> dict[Candidate, float]:
        """The value, or a lower bound of the value, of every candidate that was computed."""
        return self.glances | self.values

    def _search(self) -> Asks:
        """Examine candidates until none of them can be better than the best one."""
        for candidates in spread(self.space, self.glances, self.effort):
            self._tell_of(candidates)
            yield from self._glance(candidates)
        yield from self._look(best_apart(self.glances, LIKELY))
        sizes = SIZES[: self.effort.sizes]
        for size in sizes:
            yield from self._descend(size)
        while open_ones := self._undecided():
            yield from self._look(open_ones, 0.0)
            yield from self._descend(sizes[-1])

    def _glance(self, candidates: list[Candidate]) -> Asks:
        """Compute candidates coarsely, and also their corners if a candidate may be near the best."""
        yield from self.known(map(self.space.build, candidates), 0)
        while candidates:
            self.glances |= {each: self.value(each) for each in candidates}
            bar = min(self.glances.values()) + MARGIN
            near = [each for each, value in self.glances.items() if value <= bar]
            candidates = [each for each in near if not all(map(self.looked_at, self.with_corners(each)))]
            yield from self.known((build for each in candidates for build in self.with_corners(each)), 0)
        if self.told:
            self.book.ahead = self.space.build(*best_apart(self.glances, 1))

    def _descend(self, size: float) -> Asks:
        """Go downhill with simplices of the given size, from the best candidates in `values`."""
        starts = best_apart(self.values, self.effort.starts if size == SIZES[0] else 1)
        for candidates in descended(self.space, self.values, starts, size):
            self._tell_of(candidates)
            yield from self._look(candidates, first=None if size == SIZES[0] else CLOSE)

    def _undecided(self) -> list[Candidate]:
        """Return the candidates that are most likely to be better than the best candidate.

        For each returned candidate, only a lower bound of the value is known, and this bound is less than the best
        value. At most `LIKELY` candidates are returned, the smallest bounds first. So these candidates are computed
        even if the budget then ends the search.
        """
        least = self.worth(self.robust[self.best()])
        found = (each for each in self.examined.items() if each[0] not in self.robust and each[1] < least)
        return [each for each, _ in sorted(found, key=lambda each: each[::-1])[:LIKELY]]

    def _look(self, candidates: list[Candidate], margin: float = MARGIN, first: int | None = None) -> Asks:
        """Compute the values of candidates, at more frequencies for the candidates that may be near the best.

        A candidate is computed further only while its value exceeds the least value by at most `margin`. The nominal
        builds are compared first. If `first` is given, the corners are computed together with the nominal builds,
        up to the accuracy level `first`.
        """
        nominal = dict.fromkeys(map(self.space.build, candidates), 0)
        if first is None:
            yield from self._asked_at(nominal)
        if not self.robust and len(candidates) > 1:  # there is no best damper yet for comparison
            candidates = sorted(candidates, key=lambda each: (self.value(each), each))
            yield from self._look(candidates[:1])
            candidates = candidates[1:]
        left = candidates
        for level in range(first or 0, CLOSEST + 1):
            if level != first:
                bar = min((self.worth(each) for each in self.robust.values()), default=math.inf) + margin
                left = [each for each in left if self.value(each) <= bar]
            deciding = {build: level for each in left for build in self._deciding(each, level)}
            yield from self._asked_at(nominal | deciding)
        for each in left:
            self.robust[each] = self.judged(each)
        self.values |= {each: self.value(each) for each in candidates}
        if self.told and self.robust:
            self.book.ahead = self.space.build(self.best())

    def _deciding(self, candidate: Candidate, level: int) -> list[Build]:
        """Return the builds of a candidate that must be computed at an accuracy level.

        Up to the level `CLOSE`, all corners are computed. At higher levels, only the builds that may be the
        worst case are computed.
        """
        nominal, *corners = self.with_corners(candidate)
        if level <= CLOSE:
            return corners or [nominal]
        known = {each: self.score(each) for each in (nominal, *corners) if self._level.get(each, -1) >= CLOSE}
        highest = max(each.value for each in known.values())
        mean, share = self.asked.measure.mean, SHOWN if level <= CLOSE + 1 else NEAR
        return [
            build
            for build, one in known.items()
            if mean or one.value >= share * highest or one.violation > 0.0
        ]

    def assured(self) -> Asks:
        """Refine the best candidate up to level `SURE`.

        Other candidates that may then be better are computed accurately. A new best candidate is refined too.
        """
        self._tell("the best damper at more frequencies")
        refined: set[Candidate] = set()
        while (best := self.best()) not in refined or (left := self._undecided()):
            if best in refined:
                yield from self._look(left, 0.0)
                continue
            yield from self.known(self.with_corners(best), CLOSE)
            yield from self._onsets(best)
            for level in range(CLOSE + 1, SURE + 1):
                yield from self.known(self._deciding(best, level), level)
                self.robust[best] = self.judged(best)
            refined.add(best)
            if self.told:
                self.book.ahead = self.space.build(self.best())

    def _onsets(self, candidate: Candidate) -> Asks:
        """Compute all builds of a candidate more finely where impacts set in, even builds with a small response."""
        bands = [each for each in self.amplitudes if not isinstance(each, Case)]
        for _ in range(ONSETS):
            curves = {(b, a): self.book.curve(b, a) for b in self.with_corners(candidate) for a in bands}
            yield from self._asked(
                [Wanted(*at, onsets(each.r, each["impacts_per_cycle"])) for at, each in curves.items()]
            )

    def best(self) -> Candidate:
        """Return the best of the candidates that were judged with their tolerances."""
        return min(self.robust, key=lambda each: (self.worth(self.robust[each]), each))

    def score(self, build: Build) -> Score:
        """Return the score of a build from its known results."""
        return score(self.book, build, self.amplitudes)

    def judged(self, candidate: Candidate) -> Score:
        """Return the known worst case of a candidate, over the nominal build and the corners."""
        return worst(map(self._known_of, filter(self.looked_at, self.with_corners(candidate))))

    def _known_of(self, build: Build) -> Score:
        """Return the score of a build from its known results.

        The peaks of a build with a small response are not bracketed. The error of such a build omits the possible rise
        of the response between computed frequencies.
        """
        one = self.score(build)
        close = self._level[build] >= CLOSEST or self.asked.measure.mean
        return one if close else replace(one, error=min(one.noise, one.error))

    def value(self, candidate: Candidate) -> float:
        """Return the known value of a candidate as one number; smaller is better."""
        return self.worth(self.judged(candidate))

    def worth(self, judged: Score) -> float:
        """Return the logarithm of the response with its noise added; at least `EXCEEDING` if a limit is exceeded.

        The result is rounded to nine decimals, on which all processors agree.
        """
        if not math.isfinite(judged.value) or not math.isfinite(judged.violation):
            return WORST
        if judged.violation > 0.0:
            return EXCEEDING + round(math.log1p(judged.violation), 9)
        return round(math.log(max(judged.value + judged.noise, LEAST)), 9)

    def looked_at(self, build: Build) -> bool:
        """Whether a build was computed under every amplitude, at least coarsely."""
        return build in self._level

    def with_corners(self, candidate: Candidate) -> list[Build]:
        """Return the nominal build of a candidate, and the builds at the corners of its tolerances."""
        nominal = self.space.build(candidate)
        return [nominal, *(nominal.moved(self.asked, corner) for corner in self.corners)]

    def known(self, builds: Iterable[Build], level: int, amplitudes: Iterable[Under] = ()) -> Asks:
        """Compute builds up to an accuracy level: 0 for a coarse computation, `CLOSE` for every frequency of the
        survey, at most `SURE`.
        """
        every = list(dict.fromkeys(builds))
        for stage in range(min(level, CLOSE), level + 1):  # the survey includes the coarse computation
            if amplitudes:
                yield from self._asked(
                    [one for build in every for one in self._samples_of(build, stage, amplitudes)]
                )
            else:
                yield from self._asked_at(dict.fromkeys(every, stage))

    def _asked_at(self, levels: Mapping[Build, int]) -> Asks:
        """Compute each build at an accuracy level, all in one round. The build is known at the level before."""
        behind = {build: level for build, level in levels.items() if self._level.get(build, -1) < level}
        if behind:
            every = (self._samples_of(build, level, self.amplitudes) for build, level in behind.items())
            yield from self._asked([one for each in every for one in each])
            self._level |= behind

    def _asked(self, wanted: list[Wanted]) -> Asks:
        """Yield the wanted points, or raise `BudgetSpent` if this search may not request so many points."""
        if self.book.lacking(wanted) > self.room:
            raise BudgetSpent
        self.room -= yield wanted

    def _tell_of(self, candidates: list[Candidate]) -> None:
        here = counted(len(self.examined.keys() | set(candidates)), "damper")
        self._tell(f"{here} looked at" if self.glances else f"a first look at {here}")

    def _tell(self, stage: str) -> None:
        if self.told:
            self.book.stage = stage

    def _samples_of(self, build: Build, stage: int, amplitudes: Iterable[Under]) -> Iterable[Wanted]:
        for amplitude in amplitudes:
            frequencies: tuple[float, ...]
            if isinstance(amplitude, Case):
                frequencies = ONCE
            elif stage <= CLOSE:
                frequencies = self.sample(build, amplitude, stage == CLOSE)
            else:
                curve = self.book.curve(build, amplitude)
                if stage == BETWEEN:
                    frequencies = between(curve.r, curve.measured)
                else:
                    frequencies = brackets(curve.r, curve.measured, SHOWN if stage == CLOSE + 1 else NEAR)
                if curve.measure.mean:
                    frequencies = tuple(sorted({*frequencies, *halved(curve.r, curve.measured)}))
            yield Wanted(build, amplitude, frequencies)

    def sample(self, build: Build, amplitude: Amplitude, fine: bool) -> tuple[float, ...]:
        """Return the frequencies at which a build is computed, relative to its own natural frequency.

        A coarse sample can only underestimate the largest response, but it may over- or underestimate the rms over the
        band. So the rms always uses all frequencies.
        """
        mass = build.place(self.asked.structure, amplitude.reference_m)[2]
        every = fine or self.asked.measure.mean
        return self.surveys[amplitude.excitation].sample(mass, build.frequency_off, every)
