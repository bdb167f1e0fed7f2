"""Estimates the parameters of a prototype from a time history by least squares over successively longer beginnings.

Because of impacts, chi-square over a whole history has countless minima. Chi-square over the first few periods has few
minima. So parameters are first fitted to a short beginning of the history. The search over each longer beginning starts
from the best parameter sets of the previous beginning.
"""

import numpy as np

from damperlab.studies.faults import Fault, StudyFaults
from damperlab.studies.fit.history.fitted import FittedHistory
from damperlab.studies.fit.history.question import HistoryQuestion
from damperlab.studies.portable import log1p
from damperlab.worker.fit.archive import Progress
from damperlab.worker.fit.history.beginning import Beginning
from damperlab.worker.fit.history.march import scenes_of
from damperlab.worker.fit.history.spread import Spread, spread_at
from damperlab.worker.fit.history.stated import stated
from damperlab.worker.fit.history.trials import Place, Trials
from damperlab.worker.warm import warm

START = {1: 96, 2: 400, 3: 1200, 4: 2000, 5: 3000, 6: 4000}
"""Number of parameter sets that coarsely fill the ranges, for each number of parameters."""
PERIODS, GROWTH = 2.0, 1.25
"""Number of periods of the structure in the shortest beginning, and length ratio of successive beginnings."""
LEAST_ROWS = 12
"""Smallest number of samples per estimated parameter in the shortest beginning."""
LOOKED_BACK = 6
"""Number of earlier beginnings whose uncertainty is used to draw parameter sets."""
BEGUN, KEPT, DRAWN, TRIED = 24, 10, 240, 8
"""Numbers of parameter sets: kept after the first beginning, kept after later ones, drawn, and refined after a draw."""
ROUNDS, GAIN = 4, 0.1
"""Largest number of rounds of the final search, and gain in chi-square below which the search ends."""
AS_GOOD = 25.0
"""Difference in chi-square from the best set up to which a parameter set is kept."""
SAME = 1e-4
"""Difference, as a fraction of the ranges, up to which parameter sets are treated as equal."""
NEAR = 0.1
"""Residual that counts as 1 in the coarse search, as a fraction of the largest displacement."""


def fit_history(question: HistoryQuestion, progress: Progress | None = None) -> FittedHistory:
    """Estimate the parameters of a prototype from a time history.

    Parameters
    ----------
    question : HistoryQuestion
        Result of `damperlab.studies.fit.history.asking.make_history_question`.
    progress : callable, optional
        Function called with the number of computed histories.

    Returns
    -------
    FittedHistory
        Estimates, which are bitwise equal for equal questions.

    Raises
    ------
    StudyFaults
        If the fitted parameters do not predict the response over any beginning of the history.
    """
    for scene in scenes_of(question):
        warm(scene)
    trials = Trials(question, progress)
    places = _begin(trials, beginnings(question)[0])
    held: list[Beginning] = []
    for rows in beginnings(question):
        places = _sorted([trials.descend(each.shares, rows) for each in places])
        if held and not held[-1].scatters_like(places[0], rows, trials):
            drawn = _drawn(trials, [each.spread for each in held], rows)
            places = _sorted([*places, *_descended(trials, drawn, rows)])
        places = _kept(trials, places, rows, KEPT if held else BEGUN)
        if all(each.agrees(places[0], rows, trials) for each in held) and _follows(trials, places[0], rows):
            spread = spread_at(trials, places[0], rows, held[-1].spread if held else None)
            if spread is not None:
                held.append(Beginning(rows, places, spread))
    while held:
        last = held.pop()
        settled = _settled(trials, last, [each.spread for each in held])
        if settled is not None:
            return stated(trials, settled)
    raise StudyFaults([_unpredictable(question)])


def _settled(trials: Trials, held: Beginning, before: list[Spread]) -> Beginning | None:
    """Search around the best parameter set until no better set is found.

    A better set may exist nearby, because impacts create many minima.
    """
    tried: list[Place] = []
    for _ in range(ROUNDS):
        more = _drawn(trials, [*before, held.spread], held.rows)
        tried += more
        places = _kept(trials, _sorted([*held.places, *_descended(trials, more, held.rows)]), held.rows, KEPT)
        spread = spread_at(trials, places[0], held.rows)
        if spread is None:
            return None
        gained = held.best.squares - places[0].squares
        held = Beginning(held.rows, places, spread, tuple(tried))
        if gained <= GAIN * trials.variance(held.best.squares, held.rows):
            break
    return held


def beginnings(question: HistoryQuestion) -> list[int]:
    """Return the number of samples in each beginning. The last beginning is the whole history."""
    whole = question.measured.rows
    periods = PERIODS / (question.frequency_hz * question.measured.step_s)
    rows = max(periods, LEAST_ROWS * len(question.free))
    found = []
    while rows < whole / np.sqrt(GROWTH):
        found.append(int(np.ceil(rows)))
        rows *= GROWTH
    return [*found, whole]


def _begin(trials: Trials, rows: int) -> list[Place]:
    """Spread parameter sets over the ranges, and return the best sets.

    The best sets are those that best fit the first `rows` samples, and those that best fit the whole history.
    """
    # imported here, because the import is slow
    from scipy.stats.qmc import Halton

    count = len(trials.question.free)
    # the first point of the sequence, a corner of the ranges, is left out
    spread = Halton(count, scramble=False).random(START[count] + 1)[1:]
    measured = trials.question.measured
    near = NEAR * measured.largest_m / trials.unit
    off = np.stack([trials.residual(one, measured.rows) for one in spread]) / near
    off = np.where(np.isfinite(off), off, 100.0)
    chosen: list[int] = []
    for reach in (rows, measured.rows):
        score = log1p(off[:, :reach] ** 2).sum(axis=1)
        chosen += [int(one) for one in np.argsort(score, kind="stable")[:BEGUN]]
    return [trials.place(spread[one], rows) for one in dict.fromkeys(chosen)]


def _kept(trials: Trials, places: list[Place], rows: int, most: int) -> list[Place]:
    """Remove duplicates and sets that chi-square rejects, but keep at least the two best sets."""
    unit = trials.variance(places[0].squares, rows)
    kept: list[Place] = []
    for each in places:
        apart = all(np.abs(each.shares - other.shares).max() > SAME for other in kept)
        if apart and (each.squares - places[0].squares <= AS_GOOD * unit or len(kept) < 2):
            kept.append(each)
    return kept[:most]


def _drawn(trials: Trials, spreads: list[Spread], rows: int) -> list[Place]:
    """Draw parameter sets from the last `LOOKED_BACK` of the given uncertainties."""
    generator = np.random.default_rng([trials.question.seed, rows])
    of = spreads[-LOOKED_BACK:]
    draws = np.concatenate([each.draw(DRAWN // len(of), generator) for each in of])
    return [trials.place(np.clip(one, 0.0, 1.0), rows) for one in draws]


def _descended(trials: Trials, places: list[Place], rows: int) -> list[Place]:
    """Refine the best `TRIED` parameter sets."""
    return [trials.descend(each.shares, rows) for each in _sorted(places)[:TRIED]]


def _sorted(places: list[Place]) -> list[Place]:
    return sorted(places, key=lambda each: each.squares)


def _follows(trials: Trials, place: Place, rows: int) -> bool:
    """Return whether a parameter set explains more than half of the mean square of the measured motion."""
    moved = trials.question.measured.displacement_m[:rows] / trials.unit[:rows]
    return place.squares < 0.5 * float((moved**2).sum())


def _unpredictable(question: HistoryQuestion) -> Fault:
    rows = beginnings(question)[0]
    least = (rows - 1) * question.measured.step_s
    told = (
        f"No parameters within their ranges describe even the first {least:.3g} s of the history "
        "predictably. Either the known values do not describe this prototype, or the ranges do not contain its "
        "parameters, or the response diverges before the data determine them."
    )
    allowed = f"a response that the parameters determine for at least {least:.3g} s"
    advice = (
        "check units, the start of the motion and the known values; widen the ranges; measure with less "
        "noise or at a higher sampling rate; or fit steady amplitudes over frequency, which chaos does not "
        "prevent"
    )
    return Fault(
        "measured", f"{question.measured.name}: no stretch that can be predicted", allowed, advice, told
    )
