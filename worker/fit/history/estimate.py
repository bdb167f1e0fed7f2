"""Estimates the parameters of a prototype from a time history, by least squares over a growing beginning.

Late parts of a history depend on the parameters in a rugged way because of impacts, so a sum of squares over all of it
has countless minima. A beginning of a few periods has few minima. Each longer one is searched from the best parameter
sets of the previous one.
"""

from collections.abc import Callable

import numpy as np

from damperlab.studies.faults import Fault, StudyFaults
from damperlab.studies.fit.history.fitted import FittedHistory
from damperlab.studies.fit.history.question import HistoryQuestion
from damperlab.studies.portable import log1p
from damperlab.worker.fit.history.beginning import Beginning
from damperlab.worker.fit.history.march import scenes_of
from damperlab.worker.fit.history.spread import Spread, spread_at
from damperlab.worker.fit.history.stated import stated
from damperlab.worker.fit.history.trials import Place, Trials
from damperlab.worker.warm import warm

START = {1: 96, 2: 400, 3: 1200, 4: 2000, 5: 3000, 6: 4000}
"""Number of parameter sets that fill the ranges, by the number of parameters."""
PERIODS, GROWTH = 2.0, 1.25
"""Periods of the structure in the shortest beginning, and the growth factor."""
LEAST_ROWS = 12
"""Samples for each parameter in the shortest beginning."""
LOOKED_BACK = 6
"""Number of earlier beginnings whose spreads are used to draw parameter sets."""
BEGUN, KEPT, DRAWN, TRIED = 24, 10, 240, 8
"""Numbers of parameter sets: refined from the first beginning, kept from one beginning to the next, drawn around the
best at the end, and refined from these.
"""
ROUNDS, GAIN = 4, 0.1
"""Rounds around the best, and the gain in chi-square below which they end."""
AS_GOOD = 25.0
"""Difference of chi-square up to which a parameter set is kept."""
SAME = 1e-4
"""Largest difference of parameter sets that count as equal, as fractions of the ranges."""
NEAR = 0.1
"""Scale of a coarse residual, as a share of the largest displacement."""


def fit_history(question: HistoryQuestion, progress: Callable[[int], None] | None = None) -> FittedHistory:
    """Estimate the parameters of a prototype from a time history.

    Parameters
    ----------
    question : HistoryQuestion
        Of `damperlab.studies.fit.history.asking.make_history_question`.
    progress : callable, optional
        Called with the number of computed histories.

    Returns
    -------
    FittedHistory
        The same for the same question, bit for bit.

    Raises
    ------
    StudyFaults
        If no beginning of the history, however short, is predictable with parameters that describe it.
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
    """Search around the best until no better parameter set is found, because stops and impacts of the structure make
    minima close together.
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
    """Give the numbers of rows of the beginnings; the last one has all rows."""
    whole = question.measured.rows
    periods = PERIODS / (question.frequency_hz * question.measured.step_s)
    rows = max(periods, LEAST_ROWS * len(question.free))
    found = []
    while rows < whole / np.sqrt(GROWTH):
        found.append(int(np.ceil(rows)))
        rows *= GROWTH
    return [*found, whole]


def _begin(trials: Trials, rows: int) -> list[Place]:
    """Fill the ranges, and choose the places that are nearest over the first beginning and over all of it."""
    # imported here: a service that fits nothing starts sooner
    from scipy.stats.qmc import Halton

    count = len(trials.question.free)
    # without the corner of the ranges with which the sequence begins
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
    """Drop equal parameter sets and those that chi-square excludes, but keep the second best."""
    unit = trials.variance(places[0].squares, rows)
    kept: list[Place] = []
    for each in places:
        apart = all(np.abs(each.shares - other.shares).max() > SAME for other in kept)
        if apart and (each.squares - places[0].squares <= AS_GOOD * unit or len(kept) < 2):
            kept.append(each)
    return kept[:most]


def _drawn(trials: Trials, spreads: list[Spread], rows: int) -> list[Place]:
    """Draw parameter sets within the uncertainty of shorter beginnings."""
    generator = np.random.default_rng([trials.question.seed, rows])
    of = spreads[-LOOKED_BACK:]
    draws = np.concatenate([each.draw(DRAWN // len(of), generator) for each in of])
    return [trials.place(np.clip(one, 0.0, 1.0), rows) for one in draws]


def _descended(trials: Trials, places: list[Place], rows: int) -> list[Place]:
    """Refine the best of some parameter sets."""
    return [trials.descend(each.shares, rows) for each in _sorted(places)[:TRIED]]


def _sorted(places: list[Place]) -> list[Place]:
    return sorted(places, key=lambda each: each.squares)


def _follows(trials: Trials, place: Place, rows: int) -> bool:
    """Whether the parameters explain more than half of the motion; otherwise other parameters would do as well."""
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
