"""A race: designs that may be the best are computed ever longer, the others no more, until the best is known.

Each round halves the tolerance of those that are left, and so takes four times their cycles, as in successive halving:
K. Jamieson, A. Talwalkar, Non-stochastic best arm identification and hyperparameter optimization, AISTATS 2016. What
rules a design out, and when it ends, is selection with an indifference zone under simultaneous intervals: S.-H. Kim,
B. L. Nelson, A fully sequential procedure for indifference-zone selection in simulation, ACM Trans. Model. Comput.
Simul. 11 (2001) 251; the intervals are Bonferroni's, see `contenders`.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import xarray as xr

from damperlab.studies.answers.contenders import LOOKS, contend
from damperlab.studies.answers.design_question import DESIGN, FREQUENCY, DesignQuestion
from damperlab.studies.answers.faults import NONE_QUALIFIES, QueryFault
from damperlab.studies.answers.follow_up import (
    Refinement,
    cover,
    follow_up,
    found_of,
    say_spent,
    spent_on,
    tolerance_of,
)
from damperlab.studies.answers.limits import check
from damperlab.studies.answers.merged import merged_designs
from damperlab.studies.answers.selection import require_stored
from damperlab.studies.choices import TOLERANCE
from damperlab.studies.definition import Study
from damperlab.studies.faults import Fault, counted
from damperlab.studies.questions import MOST_DESIGNS, Judging, Race

START = 0.02
"""Tolerance of the first round, where the study's is larger."""
CYCLES = 2.0
"""Cycles of a chaotic response times its squared relative error, with a margin: 0.6² were measured on Figure 11."""
MOST_CYCLES = 1_000_000


def race_designs(
    study: Study,
    cubes: Mapping[str, xr.Dataset],
    race: Race = Race(),
    judging: Judging = Judging(),
) -> Refinement:
    """Make the studies that compute longer what may still be the best.

    Parameters
    ----------
    study : Study
        The study whose best design is wanted.
    cubes : mapping of Dataset
        Its cube first, then those of the follow-ups that are done, by id.
    race : Race
        When the race ends: confidence of all limits at once; the share by which no design may be better than the best; the
        cycles that all rounds may take, if every response should need them all.
    judging : Judging
        As in `optimal_designs`.

    Returns
    -------
    Refinement
        `said` has `confidence`, `indifference`, `as_good` (further designs that may be the best) and
        `chance_of_another`.

    Raises
    ------
    QueryFault
        If an argument is not allowed, or no design qualifies.
    """
    check(race)
    confidence, indifference = race.confidence, race.indifference
    parent = next(iter(cubes.values()))
    require_stored(parent, "race", "amplitude_error", otherwise="")
    ranked = merged_designs(cubes, judging, MOST_DESIGNS, confidence)
    if ranked.sizes["rank"] == 0:
        advice = "wait for the study, resume it, or loosen what is asked"
        raise QueryFault(
            Fault("race", "no design that qualifies", "a study with a best design", advice, NONE_QUALIFIES)
        )
    low, high = ranked["lowest"].values, ranked["highest"].values
    left = np.flatnonzero(contend(low, high))
    best = float(ranked["value"].values[0])
    spent = spent_on(cubes)
    said = {
        "confidence": confidence,
        "indifference": indifference,
        "as_good": int(left.size - 1),
        **{name: ranked.attrs[name] for name in ("chance_of_another",) if name in ranked.attrs},
    }
    answer = Refinement((), False, found_of(ranked), spent=spent, said=said)
    chance = said.get("chance_of_another")
    others = (
        f"{counted(left.size - 1, 'further design')} may be as good"
        + (f", and the best is another with a probability of {chance:.2g}" if chance is not None else "")
        if left.size > 1
        else "no other design may be as good"
    )
    # the best may be worse than another by at most this much
    regret = float(high[0] - low[left].min()) if np.isfinite(high[0]) else np.inf
    if left.size == 1 or regret <= indifference * best:
        note = (
            f"With {confidence:.0%} confidence, errors taken as normal, no design that was judged is better than the best by "
            f"more than {indifference:.2g} of its value; {others}. {say_spent(spent)}"
        )
        return replace(answer, known=True, note=note)
    # halved, whether or not the last tolerance was met
    share = ranked["error"].values[left] / ranked["value"].values[left]
    tolerance = min(START, float(np.nanmax(share, initial=0.0)) / 2 or START)
    cycles = int(min(MOST_CYCLES, max(study.steady.max_cycles, CYCLES / tolerance**2)))
    frequencies = DesignQuestion.ask(parent, judging).frequencies
    designs = np.stack([ranked[name].values[left] for name in DESIGN], axis=1)
    grids = cover(designs)
    points = frequencies.size * sum(int(np.prod([axis.size for axis in axes])) for axes in grids)
    rounds = len({tolerance_of(cube, study.steady.tolerance) for cube in cubes.values()})
    stopped = ""
    if tolerance < TOLERANCE.lowest or CYCLES / tolerance**2 > 4 * MOST_CYCLES:
        stopped = "their responses need more cycles than a point may take"
    elif spent.get("cycles", 0.0) - _parent_cycles(parent) + points * cycles > race.budget:
        stopped = f"the budget of {race.budget:,.0f} cycles does not reach for the next round"
    elif rounds >= LOOKS:
        stopped = f"{LOOKS} rounds are done"
    if stopped:
        worse = "how much better one of them may be is unknown: a response of the best ended at `max_cycles`"
        if np.isfinite(regret):
            worse = (
                f"with {confidence:.0%} confidence, errors taken as normal, the best shown is at most {regret / best:.2g} of "
                "its value worse than the best there is among them"
            )
        note = f"Not decided: {stopped}. {others[0].upper()}{others[1:]}; {worse}. {say_spent(spent)}"
        return replace(answer, note=note)
    steady = {"tolerance": tolerance, "max_cycles": cycles}
    studies = tuple(
        follow_up(
            study,
            {name: axis.tolist() for name, axis in zip(DESIGN, axes, strict=True)}
            | {FREQUENCY: frequencies.tolist()},
            "raced",
            steady,
        )
        for axes in grids
    )
    points = sum(each.points for each in studies)
    note = f"{others[0].upper()}{others[1:]}: {counted(points, 'point')} to a tolerance of {tolerance:.2g}. {say_spent(spent)}"
    return replace(answer, studies=studies, points=points, note=note)


def _parent_cycles(parent: xr.Dataset) -> float:
    return float(np.maximum(parent["cycles"].values, 0).sum(dtype=np.int64)) if "cycles" in parent else 0.0
