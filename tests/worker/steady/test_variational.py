"""Jacobians of half a cycle: central differences of plain runs, Liouville's formula, the matrix exponential.

A difference of runs is a derivative only where both runs pass the same events in the same order: elsewhere the map has a
kink. Its error falls as the square of the step, so two steps, h and h/2, tell it: the extrapolated difference is off by less
than a third of what the two differ by, and by the rounding of the ends over the step.
"""

from functools import lru_cache
from itertools import islice
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.worker.designs_drawn import drawn_points, with_contact
from tests.worker.forms import night
from tests.worker.plain_python import plainly

from damperlab.worker.accuracy.steady_answers import Point
from damperlab.worker.solver.events import (
    ARRIVED,
    BUDGET,
    FAR_WALL,
    NEAR_WALL,
    NOTHING,
)
from damperlab.worker.solver.integrate import half_cycle
from damperlab.worker.solver.scene import Scene, make_scene
from damperlab.worker.solver.state import State
from damperlab.worker.solver.transition_log import Transitions, empty_transitions, transition_at
from damperlab.worker.steady.section.coordinates import coordinates, state_at
from damperlab.worker.steady.stability.variational import propagate
from damperlab.worker.steady.start import at_rest

MODELS = ("instant", "dwell", "compliant")
POINTS = 60
FORCED = 20
WARM_UP = 30
LOOKED_AT = 4
STEP = 1e-5
EPSILON = 2.0**-52

Matrix = NDArray[np.float64]


def events(log: Transitions) -> list[tuple[int, bool, bool, bool, bool]]:
    """Kind of each event with what stuck and what was in contact before and after."""
    logged = [transition_at(log.rows, i) for i in range(log.cursor[0])]
    return [
        (
            int(one.event),
            one.before.slip == 0.0,
            one.after.slip == 0.0,
            one.before.riding > 0.0,
            one.after.riding > 0.0,
        )
        for one in logged
        if one.event != NOTHING
    ]


class Half(NamedTuple):
    """One half cycle: its Jacobian, and the same by differences, with the bound on what the two may differ by."""

    point: Point
    events: list[tuple[int, bool, bool, bool, bool]]
    jacobian: Matrix
    differences: Matrix
    allowed: Matrix


def run_half(state: State, scene: Scene, log: Transitions) -> tuple[Matrix, State]:
    """Section coordinates after one half cycle."""
    log.cursor[0] = 0
    end, outcome = half_cycle(state, scene, None, log)
    assert outcome == ARRIVED
    there = np.zeros(4)
    coordinates(end, scene.particle, there)
    return there, end


def free_coordinates(state: State, point: Point) -> list[int]:
    """Coordinates that can be moved aside in the regime of a state."""
    free = [0]
    if point.friction is None or state.slip != 0.0:
        free.append(1)
    wall_moves = point.particle.wall is not None
    if state.riding == 0.0 or wall_moves or (state.dwell is not None and state.dwell.speed > 0.0):
        free += [2, 3]
    return free


def compared(state: State, point: Point, scene: Scene) -> Half | None:
    """The half cycle from a state on; None where runs beside it pass other events."""
    log, beside = empty_transitions(4096), empty_transitions(4096)
    end, _ = run_half(state, scene, log)
    seen = events(log)
    jacobian = np.eye(4)
    propagate(log, scene, jacobian)
    here = np.zeros(4)
    coordinates(state, point.particle, here)
    differences, allowed = jacobian.copy(), np.zeros((4, 4))
    for j in free_coordinates(state, point):
        unit = abs(here[j]) if state.riding > 0.0 and j == 2 else max(1.0, abs(here[j]))
        slopes = []
        for step in (STEP * unit, 0.5 * STEP * unit):
            ends = []
            for sign in (1.0, -1.0):
                moved = here.copy()
                moved[j] += sign * step
                start, possible = state_at(moved, state, point.particle)
                if not possible:
                    return None
                there, _ = run_half(start, scene, beside)
                if events(beside) != seen:
                    return None
                ends.append(there)
            slopes.append((ends[0] - ends[1]) / (2.0 * step))
        differences[:, j] = slopes[1] + (slopes[1] - slopes[0]) / 3.0
        rounding = 64.0 * EPSILON * (1.0 + np.abs(end[:2]).max() + np.abs(here).max()) / (STEP * unit)
        allowed[:, j] = np.abs(slopes[1] - slopes[0]) + rounding * (1.0 + np.abs(jacobian).max())
    return Half(point, seen, jacobian, differences, allowed)


BY_DAY = [("instant", has_friction, False) for has_friction in (True, False)]


def halves(model: str, has_friction: bool, forced: bool) -> list[Half]:
    """Half cycles of drawn points, some time after the start from rest; of fewer points under a force."""
    times = np.geomspace(0.003, 0.3, 5)
    found = []
    log = empty_transitions(4096)
    drawn = (p for p in drawn_points(4711) if (p.friction is not None) == has_friction)
    for i, point in enumerate(islice(drawn, FORCED if forced else POINTS)):
        point = point._replace(particle=with_contact(point.particle, model, float(times[i % 5])))
        scene = make_scene(*point, None, forced)
        scene.counts[BUDGET] = 300_000
        state = at_rest(point.frequency_ratio, point.friction, point.particle, forced)
        for half in range(WARM_UP + LOOKED_AT):
            if half >= WARM_UP:
                one = compared(state, point, scene)
                if one is not None:
                    found.append(one)
            _, state = run_half(state, scene, log)
    return found


@lru_cache
def looked_at(model: str, has_friction: bool, forced: bool) -> list[Half]:
    """By day in plain Python: compiling what differentiates takes longer."""
    asked = (model, has_friction, forced)
    found: list[Half] = plainly(halves, [asked])[0] if asked in BY_DAY else halves(*asked)
    return found


@pytest.mark.parametrize("has_friction", [True, False], ids=["friction", "no friction"])
@pytest.mark.parametrize(
    ("model", "forced"),
    [
        ("instant", False),
        *(night(model, False) for model in MODELS[1:]),
        *(night(model, True) for model in MODELS),
    ],
)
def test_jacobians_are_central_differences(model: str, has_friction: bool, forced: bool) -> None:
    for half in looked_at(model, has_friction, forced):
        off = np.abs(half.jacobian - half.differences) - half.allowed
        assert off.max() <= 0.0, half
    assert len(looked_at(model, has_friction, forced)) >= (FORCED if forced else POINTS) * LOOKED_AT // 2


def test_volume_contracts_by_damping_and_impacts_alone() -> None:
    """Liouville: without friction and without riding, det J = e^(2 N) exp(−2ζπ/r) with N impacts.

    Of 24 products of four entries, each with a relative error of some 100 roundings.
    """
    compared = 0
    for half in looked_at("instant", False, False):
        if any(before or after for *_, before, after in half.events):
            continue  # rides: the volume is lost
        impacts = sum(kind in (NEAR_WALL, FAR_WALL) for kind, *_ in half.events)
        zeta, r = half.point.damping_ratio, half.point.frequency_ratio
        truth = half.point.particle.restitution ** (2 * impacts) * np.exp(-2.0 * zeta * np.pi / r)
        allowed = 24.0 * 400.0 * EPSILON * max(1.0, np.abs(half.jacobian).max()) ** 4
        assert np.linalg.det(half.jacobian) == pytest.approx(truth, rel=0.0, abs=allowed)
        compared += impacts > 0
    assert compared >= POINTS
