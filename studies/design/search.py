"""The search: candidates looked at coarsely, the best of them ever more closely, and finally with their tolerances.

It is a generator: it yields what must be known next, and goes on when the book has it. What it yields depends on the
specification and on the values in the book alone.

Candidates are ranked by the worst case over what is known of them, which can only grow as more frequencies are known. So the
best few are looked at more closely until the best few are all known closely (a lazy evaluation of the best, as in branch and
bound); then the lattice is halved around them. The last step judges the best by the worst of their tolerances as
well; a candidate whose nominal worst case is already above another's worst needs no such judgement.
"""

import math
from collections.abc import Generator, Iterable
from dataclasses import dataclass, field
from math import inf, isinf

from damperlab.studies.design.band_mean import halved
from damperlab.studies.design.book import Book, BudgetSpent, Wanted
from damperlab.studies.design.build import Build
from damperlab.studies.design.corners import amplitudes_of, corners_of
from damperlab.studies.design.effort import Effort
from damperlab.studies.design.frequencies import Survey, brackets
from damperlab.studies.design.lattice import FIRST, Candidate, Lattice
from damperlab.studies.design.score import Score, score, worst
from damperlab.studies.faults import counted
from damperlab.studies.specification.excitation import Amplitude
from damperlab.studies.specification.records import ONCE, Case, Under
from damperlab.studies.specification.specification import Specification

Asks = Generator[list[Wanted], None, None]

FEW = 3
"""Amplitudes of each excitation under which candidates are judged."""
CLOSE = 1
"""How closely a candidate is known before the lattice is halved around it: every frequency of the survey."""
CLOSEST = 3
"""How closely one is known that may be recommended: two rounds of brackets around its maxima more."""
ENOUGH = 1 / 32
"""Step from which the lattice is no longer halved where the last halving gained less than the noise of the best one."""
NOISY = 0.01
"""Share of a value from which its error counts as noise: of a response that repeats it is far less."""


@dataclass
class Search:
    """One search for the best damper of a specification.

    Parameters
    ----------
    asked : Specification
        What is designed.
    book : Book
        What is known; shared with other searches.
    effort : Effort
        How much it takes.
    told : bool
        Whether the book's stage says what goes on.
    """

    asked: Specification
    book: Book
    effort: Effort = field(default_factory=Effort)
    told: bool = True
    stopped: str = ""
    step: float = 0.0
    pool: list[Candidate] = field(default_factory=list)
    robust: dict[Candidate, Score] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Lay out frequencies, amplitudes and corners."""
        self.lattice = Lattice(self.asked)
        self.surveys = {each: Survey.of(self.asked, each) for each in self.asked.excitations}
        self.amplitudes = amplitudes_of(self.asked, FEW)
        self.corners = corners_of(self.asked)
        self.cap = self.most = self.book.budget
        self._level: dict[Build, int] = {}

    def run(self, most: int | None = None) -> Generator[list[Wanted], None, Candidate]:
        """Search, and give the best of what the budget allowed.

        Parameters
        ----------
        most : int, optional
            Points of the book up to which it may take them; all of the budget unless given.

        Raises
        ------
        BudgetSpent
            If it did not allow the first look.
        """
        self.most = self.book.budget if most is None else most
        room = self.most - self.book.spent
        self.cap = self.most - math.ceil(self.effort.reserve * room)
        try:
            yield from self._explore()
        except BudgetSpent:
            self.stopped = "budget"
        self.cap = self.most
        if not self.pool:
            raise BudgetSpent
        if not self.robust:
            # nothing was judged with its tolerances: the best as drawn, with what is known of its corners
            (best,) = self._top(1)
            self.robust[best] = self.score(self.lattice.build(best))
        try:
            yield from self.polish()
        except BudgetSpent:
            self.stopped = "budget"
        return self.best()

    def _explore(self) -> Asks:
        """Look at the lattice, ever finer around the best, and judge the best with their tolerances."""
        self.step = FIRST.get(len(self.lattice.names), 0.5)
        first = self.lattice.first()
        self._tell(f"a first look at {counted(len(first), 'damper')}")
        yield from self.add(first)
        try:
            yield from self._halve()
        except BudgetSpent:
            self.stopped = "budget"
            # half of what it had left over goes into judging fewer, and all of it stands behind the first
            self.cap += (self.most - self.cap) // 2
        finalists = self._diverse()
        if self.corners:
            self._tell(
                f"the best {len(finalists)} with {counted(len(self.corners), 'corner')} of their tolerances"
            )
        yield from self.judge(finalists)
        for _ in range(self.effort.rounds if self.corners else 0):
            best = self.best()
            new = [
                each
                for each in self.lattice.around([best], max(self.step, 1 / 32))
                if each not in self.robust
            ]
            yield from self.add([each for each in new if each not in set(self.pool)])
            yield from self.judge(new)
            if self.best() == best:
                break

    def _halve(self) -> Asks:
        """Halve the lattice around the best until it is fine enough, or shows no more than noise."""
        yield from self.settle(CLOSE)
        while self.lattice.names and not self.lattice.fine(self.step):
            before = self._leader()
            finer = self.step / 2
            self._tell(
                f"around the best {self.effort.kept}, with steps of 1/{round(1 / finer)} of the ranges"
            )
            known = set(self.pool)
            around = self.lattice.around(self.leaders(), finer)
            yield from self.add([each for each in around if each not in known])
            yield from self.settle(CLOSE)
            self.step = finer
            after = self._leader()
            gained = before.violation > after.violation or before.value - after.value > after.error
            noisy = after.error > NOISY * after.value
            if finer <= self.effort.finest or (finer <= ENOUGH and noisy and not gained):
                return

    def polish(self) -> Asks:
        """Know as closely as can be every candidate whose worst case may be less than what the best is sure to keep."""
        while True:
            known = [each for each in self.robust if all(map(self.close, self.with_corners(each)))]
            bar = min((self.robust[each].sure for each in known), default=(inf, inf))
            behind = [each for each in self.robust if each not in known and self.robust[each].rank < bar]
            if not behind:
                return
            next_best = min(behind, key=lambda each: (*self.robust[each].rank, each))
            builds = self.with_corners(next_best)
            yield from self.known(builds, CLOSEST)
            self.robust[next_best] = worst(self.score(build) for build in builds)

    def _leader(self) -> Score:
        """Give the score of the best as drawn."""
        (best,) = self._top(1)
        return self.score(self.lattice.build(best))

    def best(self) -> Candidate:
        """Give the best of those judged with their tolerances."""
        return min(self.robust, key=lambda each: (*self.robust[each].sure, each))

    def score(self, build: Build) -> Score:
        """Judge a build by what is known."""
        return score(self.book, build, self.amplitudes)

    def close(self, build: Build) -> bool:
        """Whether a build is known as closely as one can be."""
        return self._level.get(build, -1) >= CLOSEST

    def looked_at(self, build: Build) -> bool:
        """Whether anything is known of a build under all amplitudes."""
        return build in self._level

    def first_look(self) -> list[Wanted]:
        """Give what the first look at the lattice takes."""
        return self._samples(self.lattice.first(), 0)

    def with_corners(self, candidate: Candidate) -> list[Build]:
        """Give a candidate's build and those at the corners of its tolerances."""
        nominal = self.lattice.build(candidate)
        return [nominal, *(nominal.moved(self.asked, corner) for corner in self.corners)]

    def known(self, builds: Iterable[Build], level: int, amplitudes: Iterable[Under] = ()) -> Asks:
        """Make builds known as closely as a level says: 0 coarsely, 1 the survey, each further one a round of brackets."""
        every = list(dict.fromkeys(builds))
        at = tuple(amplitudes) or self.amplitudes
        for stage in range(level + 1):
            behind = [build for build in every if amplitudes or self._level.get(build, -1) < stage]
            if stage == 0 and level > 0:
                continue  # the survey holds the coarse look
            if behind:
                wanted = [one for build in behind for one in self._samples_of(build, stage, at)]
                if self.book.spent + self.book.lacking(wanted) > self.cap:
                    raise BudgetSpent
                yield wanted
                if not amplitudes:
                    self._level.update(dict.fromkeys(behind, stage))

    def _tell(self, stage: str) -> None:
        if self.told:
            self.book.stage = stage

    def _lead(self) -> None:
        """Note the best so far, for whoever waits."""
        if self.told:
            self.book.ahead = self.lattice.build(self.best() if self.robust else self._top(1)[0])

    def add(self, candidates: list[Candidate]) -> Asks:
        """Look at candidates coarsely, as drawn, and take them into the pool."""
        yield from self.known((self.lattice.build(each) for each in candidates), 0)
        self.pool = sorted({*self.pool, *candidates})
        self._lead()

    def leaders(self) -> list[Candidate]:
        """Give the best few as drawn."""
        return self._top(self.effort.kept)

    def settle(self, level: int) -> Asks:
        """Look at the best few more closely until the best few are known closely."""
        while True:
            behind = [
                build
                for build in (self.lattice.build(each) for each in self.leaders())
                if self._level.get(build, -1) < level
            ]
            if not behind:
                return
            yield from self.known(behind, level)

    def judge(self, candidates: list[Candidate]) -> Asks:
        """Judge candidates with their tolerances, but for those that cannot be the best."""
        yield from self.known((self.lattice.build(each) for each in candidates), CLOSE)
        ranked = sorted(candidates, key=lambda each: (*self.score(self.lattice.build(each)).rank, each))
        for each in ranked:
            nominal = self.score(self.lattice.build(each))
            if self.robust and nominal.rank > self.robust[self.best()].sure:
                break
            builds = self.with_corners(each)
            yield from self.known(builds, CLOSE + 1)
            self.robust[each] = worst(self.score(build) for build in builds)
            self._lead()

    def _samples(self, candidates: Iterable[Candidate], stage: int) -> list[Wanted]:
        return [
            one
            for each in candidates
            for one in self._samples_of(self.lattice.build(each), stage, self.amplitudes)
        ]

    def _samples_of(self, build: Build, stage: int, amplitudes: Iterable[Under]) -> Iterable[Wanted]:
        for amplitude in amplitudes:
            frequencies: tuple[float, ...]
            if isinstance(amplitude, Case):
                frequencies = ONCE
            elif stage < 2:
                frequencies = self.sample(build, amplitude, stage == 1)
            else:
                curve = self.book.curve(build, amplitude)
                frequencies = brackets(curve.r, curve.measured)
                if curve.measure.mean:
                    frequencies = tuple(sorted({*frequencies, *halved(curve.r, curve.measured)}))
            yield Wanted(build, amplitude, frequencies)

    def sample(self, build: Build, amplitude: Amplitude, fine: bool) -> tuple[float, ...]:
        """Give the frequencies at which a build is looked at under an amplitude, over its own natural frequency.

        Between coarse ones the largest response may only be more, but the rms over the band may be more or less: that is
        judged by all of them at once.
        """
        mass = build.place(self.asked.structure, amplitude.reference_m)[2]
        every = fine or self.asked.measure.mean
        return self.surveys[amplitude.excitation].sample(mass, build.natural_frequency_hz, every)

    def _top(self, count: int) -> list[Candidate]:
        scores = {each: self.score(self.lattice.build(each)).rank for each in self.pool}
        return sorted(self.pool, key=lambda each: (*scores[each], each))[:count]

    def _diverse(self) -> list[Candidate]:
        """Choose finalists: the best, and further ones that are not the same damper within a step of the first lattice."""
        far = FIRST.get(len(self.lattice.names), 0.5) / 2
        ranked = self._top(len(self.pool))
        chosen = ranked[: (self.effort.finalists + 1) // 2]
        for each in ranked[len(chosen) :]:
            if isinf(self.score(self.lattice.build(each)).value) or len(chosen) == self.effort.finalists:
                break
            near = sum(self.lattice.apart(each, other) < far for other in chosen)
            if near < 2:
                chosen.append(each)
        return chosen
