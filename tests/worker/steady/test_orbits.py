"""Periodic responses found by Newton against plain marching, an oracle, and finite differences."""

from itertools import islice

import numpy as np
import pytest
from tests.oracles.impact_pair import two_impacts_per_cycle
from tests.worker.designs_drawn import Point, drawn_points
from tests.worker.plain_march import plain_end, plain_means

from damperlab.studies.variables import ResponseClass
from damperlab.worker.solver.events import ARRIVED, BUDGET, TURN
from damperlab.worker.solver.integrate import half_cycle
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.scene import make_scene
from damperlab.worker.solver.state import State
from damperlab.worker.solver.transition_log import AFTER, BEFORE, EVENT, RIDING, WIDTH, empty_transitions
from damperlab.worker.steady.orbits.newton import march_with_jacobian
from damperlab.worker.steady.response.measures import Response
from damperlab.worker.steady.section.coordinates import coordinates, state_at

PLAIN_CYCLES = 4000
DRAWN = 60
EXACT = 1e-8


def periodic_points(seed: int, count: int) -> list[tuple[Point, Response, State]]:
    """Held-out points at the paper's damping whose response repeats and is not locked."""
    found = []
    for point in islice(drawn_points(seed, damping=(0.0038,)), count):
        response, end = point.solve()
        if response.period > 0 and response.response_class != ResponseClass.LOCKED:
            found.append((point, response, end))
    return found


@pytest.fixture(scope="module")
def held_out() -> list[tuple[Point, Response, State]]:
    return periodic_points(77, DRAWN)


def test_orbits_are_what_plain_marching_comes_to_with_a_fifth_of_its_cycles(
    held_out: list[tuple[Point, Response, State]],
) -> None:
    plain_cycles = found_cycles = compared = 0
    for point, response, _ in held_out:
        if response.floquet_multiplier ** (PLAIN_CYCLES / response.period) > 1e-12:
            continue  # plain marching has not come there yet
        off = np.abs(plain_means(point, response.period, PLAIN_CYCLES) - response.amplitude_ratio)
        assert off[-1] <= EXACT, (point, response)
        beyond = np.flatnonzero(off > EXACT)
        plain_cycles += response.period * (2 + int(beyond[-1]) if beyond.size else 1)
        found_cycles += response.cycles
        compared += 1
    assert compared >= DRAWN // 2
    assert plain_cycles >= 5 * found_cycles


def finite_difference_multiplier(point: Point, response: Response, end: State) -> float:
    """Largest eigenvalue modulus of the map over one period, by central differences of plain marches."""
    size = 4 if response.impacts_per_cycle > 0 else 2
    here, there = np.zeros(4), np.zeros(4)
    coordinates(end, point.particle, here)
    map_ = np.zeros((size, size))
    for j in range(size):
        step = 1e-6 * max(1.0, abs(here[j]))
        for sign in (1.0, -1.0):
            moved = here.copy()
            moved[j] += sign * step
            start, possible = state_at(moved, end, point.particle)
            assert possible
            coordinates(plain_end(point, start, response.period), point.particle, there)
            map_[:, j] += sign * there[:size] / (2.0 * step)
    return float(np.abs(np.linalg.eigvals(map_)).max())


def test_multipliers_are_those_of_finite_differences(held_out: list[tuple[Point, Response, State]]) -> None:
    compared = 0
    for point, response, end in held_out:
        moves_freely = end.slip != 0.0 if point.friction is not None else True
        if not moves_freely or end.riding > 0.0:
            continue  # a held mass cannot be moved aside
        truth = finite_difference_multiplier(point, response, end)
        assert response.floquet_multiplier == pytest.approx(truth, rel=0.0, abs=1e-5), (point, response)
        compared += 1
    assert compared >= DRAWN // 3


def test_multipliers_are_those_of_the_two_impact_motion() -> None:
    random = np.random.default_rng(5)
    compared = 0
    while compared < 12:
        r, clearance, restitution = random.uniform((0.85, 4.0, 0.3), (1.1, 14.0, 0.9)).tolist()
        mass, zeta = float(random.uniform(0.05, 0.3)), float(random.choice((0.0038, 0.02)))
        motions = two_impacts_per_cycle(zeta, r, clearance, restitution, mass)
        point = Point(zeta, r, None, Particle(clearance, restitution, mass))
        found, _ = point.solve()
        if found.response_class != ResponseClass.SYMMETRIC or found.impacts_per_cycle != 2.0:
            continue
        truth = min(motions, key=lambda motion: abs(motion.amplitude_ratio - found.amplitude_ratio))
        assert found.amplitude_ratio == pytest.approx(truth.amplitude_ratio, rel=0.0, abs=EXACT)
        assert found.floquet_multiplier == pytest.approx(truth.floquet_multiplier, rel=0.0, abs=1e-5)
        compared += 1


def test_jacobian_where_the_mass_turns_and_lets_go_of_the_particle_that_rode_on_it() -> None:
    """Of half a cycle, by central differences: step 1e-6, so its square; a held mass has no w to vary."""
    point = Point(0.02, 0.8, 0.5, Particle(1.0, 0.1, 1.0))
    scene = make_scene(*point, True)
    particle = scene.particle
    scene.counts[BUDGET] = 100_000
    state = point.rest()
    log = empty_transitions(1000)
    for _ in range(40):
        log.cursor[0] = 0
        state, outcome = half_cycle(state, scene, None, log)
        assert outcome == ARRIVED
    log = empty_transitions(1000)
    jacobian = np.zeros((4, 4))
    march_with_jacobian(state, 1, scene, log, jacobian)
    rows = log.rows.reshape(-1, WIDTH)[: log.cursor[0]]
    let_go = (rows[:, BEFORE + RIDING] > 0.0) & (rows[:, AFTER + RIDING] == 0.0)
    assert (let_go & (rows[:, EVENT] == TURN)).any()
    here, there = np.zeros(4), np.zeros(4)
    coordinates(state, particle, here)
    for j in (0, 2, 3):
        truth = np.zeros(4)
        for sign in (1.0, -1.0):
            moved = here.copy()
            moved[j] += sign * 1e-6
            start, possible = state_at(moved, state, particle)
            assert possible
            log.cursor[0] = 0
            end, _ = half_cycle(start, scene, None, log)
            coordinates(end, particle, there)
            truth += sign * there / 2e-6
        assert jacobian[:, j] == pytest.approx(truth, rel=0.0, abs=1e-6)
