"""Comparison of steady responses from the solver with plain integrations, for random points and extreme cases.

An answer is a response found by the solver. Class, period, amplitude and impacts of each answer are compared with an
integration from the same start. A periodic answer must also have a stable Floquet multiplier. If the answer differs
from the integration, a second integration starts from the final state of the solver. If the second integration agrees,
the verdict is `several responses`: rounding decides which response is reached, or the transient is longer than the
first integration.
"""

from collections import Counter
from collections.abc import Iterable, Iterator
from math import exp, log
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.variables import ResponseClass, Status
from damperlab.worker.accuracy.extremes import Extreme
from damperlab.worker.accuracy.march import march_halves
from damperlab.worker.physics.compliant_wall import wall_constants
from damperlab.worker.solver.events import ARRIVED
from damperlab.worker.solver.particle import Particle, Wall
from damperlab.worker.solver.state import State
from damperlab.worker.steady.response.measures import Response
from damperlab.worker.steady.response.standard_errors import mean_and_error
from damperlab.worker.steady.section.recurrence import LONGEST
from damperlab.worker.steady.settle import Settings, settle
from damperlab.worker.steady.start import at_rest

SETTINGS = Settings(4000, 0.02, 1e-9)
"""Criteria for a steady response, equal to the defaults of a study."""
MODELS = ("instant", "instant", "instant", "dwell", "instant", "instant", "instant", "compliant")
"""Contact models of successive random points; the sequence repeats after the last model."""
SIGMA = 4.0
"""Largest allowed difference, in stated errors. A normally distributed error exceeds this limit in 1 of 16,000 cases.
"""
HALF_WIDTH = 1.96
"""Half width of a 95 % interval, as a multiple of the stated error."""

_LONGEST_REPEAT = 128  # longest period that is searched, in half cycles
_SAME = 1e-7  # largest relative difference of the peaks of a periodic motion
TRANSIENT = "a transient longer than the run"
"""Verdict on an irregular answer if the integration becomes periodic only after the end of the solver's run."""
WARNED = "a transient that the answer warns of"
"""Verdict instead of `TRANSIENT` if the status of the answer reports a stable orbit nearby."""
_REMEMBERED = 1024  # a period is searched in this number of half cycles, at the end of an integration
_EXACT = 1e-6  # allowed relative difference of amplitudes on the same orbit, due to a remaining transient

Halves = NDArray[np.float64]


class Point(NamedTuple):
    """One design point, as the first arguments of `settle`."""

    damping_ratio: float
    frequency_ratio: float
    friction: float | None
    particle: Particle | None

    def rest(self, forced: bool = False) -> State:
        """Return the state at rest."""
        start: State = at_rest(self.frequency_ratio, self.friction, self.particle, forced)
        return start


class Truth(NamedTuple):
    """Result of a plain integration.

    Attributes
    ----------
    period_halves : int
        Number of half cycles after which the peaks repeat; 0 if the peaks do not repeat.
    amplitude, error : float
        Mean peak of |u| over all windows of one cycle, and the uncertainty of this mean.
    impacts, impacts_error : float
        Mean number of impacts per cycle, and the uncertainty of this mean.
    """

    period_halves: int
    amplitude: float
    error: float
    impacts: float
    impacts_error: float

    @property
    def period(self) -> int:
        """Period in excitation cycles; 0 if the peaks do not repeat."""
        return self.period_halves if self.period_halves % 2 == 1 else self.period_halves // 2


class Compared(NamedTuple):
    """An answer, the result of the integration, and the verdict.

    Attributes
    ----------
    verdict : str
        "agrees", or a description of the difference.
    deviation : float
        Difference of the mean amplitudes in standard errors if neither response is periodic; otherwise NaN.
    """

    point: Point
    response: Response
    truth: Truth
    verdict: str
    deviation: float


def points(seed: int, models: tuple[str, ...] = MODELS) -> Iterator[Point]:
    """Yield random design points without end. The contact models repeat in the order of `models`.

    The model "friction" means friction without a particle.
    """
    random = np.random.default_rng(seed)
    turn = 0
    while True:
        place = random.random(8).tolist()
        restitution = 0.95 * place[0]
        mass = 0.01 * 50.0 ** place[1]
        model = models[turn % len(models)]
        turn += 1
        contact_time = 0.01 * 50.0 ** place[7]
        wall = None
        if model == "compliant":
            restitution = max(restitution, 0.05)
            wall = Wall(*wall_constants(restitution, contact_time, mass))
        particle = Particle(
            exp(log(0.3) + log(50.0) * place[2]),
            restitution,
            mass,
            contact_time if model == "dwell" else None,
            wall,
        )
        friction = place[3] if place[6] < 0.8 or model == "friction" else None
        yield Point(
            0.002 * 50.0 ** place[4],
            0.6 + 0.8 * place[5],
            friction,
            particle if model != "friction" else None,
        )


def truth_of(halves: Halves) -> Truth:
    """Evaluate the recorded half cycles of an integration.

    The last `_REMEMBERED` half cycles are searched for a period. If there is no period, the means are over all half
    cycles.
    """
    windows = np.maximum(halves[:-1, 0], halves[1:, 0])
    period_halves = _repeat(halves[-_REMEMBERED:])
    if period_halves > 0:
        whole = _REMEMBERED // (2 * period_halves) * 2 * period_halves
        amplitude = float(windows[-whole:].mean())
        impacts = 2.0 * float(halves[-whole:, 2].mean())
        return Truth(period_halves, amplitude, _EXACT * max(1.0, amplitude), impacts, 1e-9)
    cycles = windows[: windows.size // 2 * 2].reshape(-1, 2).mean(axis=1)
    amplitude, error = mean_and_error(cycles, 0, cycles.size)
    hits = halves[: halves.shape[0] // 2 * 2, 2].reshape(-1, 2).sum(axis=1)
    impacts, impacts_error = mean_and_error(hits, 0, hits.size)
    return Truth(0, float(amplitude), float(error), float(impacts), float(impacts_error))


def _repeat(halves: Halves) -> int:
    scale = _SAME * max(1.0, float(halves[:, 0].max()))
    for period_halves in range(1, min(_LONGEST_REPEAT, halves.shape[0] // 2) + 1):
        apart = np.abs(halves[period_halves:, :2] - halves[:-period_halves, :2]).max()
        if apart <= scale and (halves[period_halves:, 2] == halves[:-period_halves, 2]).all():
            return period_halves
    return 0


def judged(response: Response, truth: Truth, cycles: int) -> tuple[str, float]:
    """Return the verdict on an answer, and the difference of the mean amplitudes in standard errors.

    `cycles` is the length of the integration in half cycles.
    """
    steady = response.period > 0
    if steady and truth.period_halves > 0:
        allowed = truth.error + SIGMA * response.amplitude_error
        if response.response_class == ResponseClass.LOCKED:
            # the integration approaches the locked state only as 1/N after N half cycles, and the answer is the limit
            allowed += 4.0 / cycles
        if abs(response.amplitude_ratio - truth.amplitude) > allowed:
            return "another orbit", np.nan
        if response.response_class == ResponseClass.LOCKED:
            return "agrees", np.nan
        # the period of the peaks may be half the period of the states
        other_impacts = abs(response.impacts_per_cycle - truth.impacts) > 1e-6
        if other_impacts and abs(response.amplitude_ratio - truth.amplitude) <= 1e-9 * truth.amplitude:
            # the solver ends a chatter when its remainder is negligible, so the numbers of impacts may differ by one
            return "agrees except for one impact of a chatter", np.nan
        if truth.period not in (response.period, 0.5 * response.period):
            return "another period", np.nan
        if other_impacts:
            return "other impacts", np.nan
        if (
            not response.floquet_multiplier < 1.0 + 1e-6
            and response.floquet_multiplier == response.floquet_multiplier
        ):
            return "an orbit that repels", np.nan
        return "agrees", np.nan
    if steady:
        slow = response.floquet_multiplier > 0.99
        # the integration has not settled; if the transient decays slowly, the answer may still be correct
        unknown = SIGMA * truth.error + response.amplitude_error
        if slow and abs(response.amplitude_ratio - truth.amplitude) <= unknown:
            return "agrees", np.nan
        return "periodic, but the integration is not", np.nan
    if 0 < truth.period_halves <= LONGEST:
        return "not periodic, but the integration is", np.nan
    error = float(np.hypot(response.amplitude_error, truth.error))
    deviation = (response.amplitude_ratio - truth.amplitude) / error if error > 0.0 else 0.0
    if abs(deviation) > SIGMA:
        return "mean off by more than its error", deviation
    error = float(np.hypot(response.impacts_error, truth.impacts_error))
    if abs(response.impacts_per_cycle - truth.impacts) > SIGMA * error:
        return "impacts off by more than their error", deviation
    return "agrees", deviation


def compared(point: Point, cycles: int, forced: bool = False) -> Compared | None:
    """Compare the answer for a point with the second half of an integration over 2 · `cycles` half cycles from rest.

    The result is None if the solver or the integration failed. `forced` means that a force on the structure replaces the
    shaken base.
    """
    response, end = settle(*point, SETTINGS, point.rest(forced), forced)
    return _held(point, response, end, cycles, forced)


def _held(point: Point, response: Response, end: State, cycles: int, forced: bool = False) -> Compared | None:
    """Compare an answer as `compared` does; `end` is the final state of the solver."""
    if response.status > Status.MAX_CYCLES:
        return None
    halves = np.empty((cycles, 3))
    _, outcome = march_halves(*point, point.rest(forced), cycles, halves, forced)
    if outcome != ARRIVED:
        return None
    truth = truth_of(halves)
    verdict, deviation = judged(response, truth, 2 * cycles)
    if verdict != "agrees":
        _, outcome = march_halves(*point, end, 0, halves, forced)
        verdict_there, there = (
            judged(response, truth_of(halves), cycles) if outcome == ARRIVED else ("", np.nan)
        )
        if verdict_there == "agrees":
            verdict, deviation = f"several responses ({verdict})", there
        elif verdict == "not periodic, but the integration is":
            # the solver cannot find an orbit that the motion reaches only after the end of the solver's run
            halves = np.empty((_REMEMBERED, 3))
            before = max(0, 2 * int(response.cycles) - _REMEMBERED)
            _, outcome = march_halves(*point, point.rest(forced), before, halves, forced)
            if outcome == ARRIVED and _repeat(halves) == 0:
                verdict = TRANSIENT if response.status == Status.CONVERGED else WARNED
    return Compared(point, response, truth, verdict, deviation)


def every(found: Iterable[Point], cycles: int, forced: bool = False) -> Iterator[Compared]:
    """Yield the comparison for each point. Points at which the solver or the integration failed are omitted."""
    for point in found:
        one = compared(point, cycles, forced)
        if one is not None:
            yield one


def table(answers: list[Compared]) -> dict[str, Any]:
    """Return the number of answers by class and by verdict, and the share of intervals that contain the mean."""
    verdicts = Counter(one.verdict for one in answers)
    classes = Counter(ResponseClass(int(one.response.response_class)).name.lower() for one in answers)
    means = [one.deviation for one in answers if one.deviation == one.deviation]
    figures: dict[str, Any] = {"answers compared": len(answers)}
    figures |= {f"class {name}": number for name, number in sorted(classes.items())}
    figures |= {f"verdict: {name}": number for name, number in sorted(verdicts.items())}
    if means:
        figures["means compared"] = len(means)
        figures["95 % interval contains the mean, %"] = 100.0 * float(np.mean(np.abs(means) <= HALF_WIDTH))
        figures["largest deviation, in errors"] = float(np.abs(means).max())
    return figures


def extreme_answers(cases: Iterable[Extreme], cycles: int) -> list[dict[str, Any]]:
    """Compare the answers for extreme cases with integrations, and return JSON-able rows.

    Cases without friction and particle have a closed form and are omitted. The verdict "not compared" means that the
    solver or the integration failed.
    """
    rows = []
    for case in cases:
        design = case.design
        friction = design.friction_ratio if design.friction_ratio > 0.0 else None
        if friction is None and design.particle is None:
            continue
        point = Point(design.damping_ratio, design.frequency_ratio, friction, design.particle)
        response, end = settle(*point, SETTINGS, point.rest())
        one = _held(point, response, end, cycles)
        rows.append(
            {
                "name": case.name,
                "response_class": ResponseClass(int(response.response_class)).name.lower(),
                "period": int(response.period),
                "amplitude_ratio": _number(response.amplitude_ratio),
                "amplitude_error": _number(response.amplitude_error),
                "cycles": int(response.cycles),
                "status": Status(int(response.status)).name.lower(),
                "verdict": "not compared" if one is None else one.verdict,
            }
        )
    return rows


def _number(value: float) -> float | None:
    return float(value) if value == value else None
