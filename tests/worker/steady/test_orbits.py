"""Periodic and chaotic responses of every contact model against plain and independent marches, and finite differences."""

from functools import lru_cache
from itertools import islice

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray
from tests.oracles.impact_pair import two_impacts_per_cycle
from tests.worker.designs_drawn import drawn_points, solved, with_contact
from tests.worker.forms import both, in_form, night
from tests.worker.plain_march import plain_end, plain_means

from damperlab.studies.variables import ResponseClass
from damperlab.worker.accuracy.steady_answers import Point
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.state import State
from damperlab.worker.steady.response.measures import Response
from damperlab.worker.steady.section.coordinates import coordinates, state_at
from damperlab.worker.steady.stability.multipliers import spectral_radius

LASTING = ("dwell", "compliant")
MODELS = ["instant", *map(night, LASTING)]
DRAWN = 24
PLAIN_CYCLES = 4000
EXACT = 1e-8
SLOW = 0.96  # a period: 25 cycles or more for a factor of e


def of_model(point: Point, model: str, contact_time: float) -> Point:
    return point._replace(particle=with_contact(point.particle, model, contact_time))


@lru_cache
def periodic(model: str) -> list[tuple[Point, Response, State]]:
    """Points at the paper's damping whose response repeats and is not locked."""
    found = []
    contact_times = np.geomspace(0.003, 0.3, 5)
    for i, point in enumerate(islice(drawn_points(77, damping=(0.0038,)), DRAWN)):
        point = of_model(point, model, float(contact_times[i % 5]))
        response, end = solved(point)
        if response.period > 0 and response.response_class != ResponseClass.LOCKED:
            found.append((point, response, end))
    return found


@pytest.mark.parametrize("model", MODELS)
def test_orbits_are_what_plain_marching_comes_to_with_a_fifth_of_its_cycles(model: str) -> None:
    """A fifth where the way there is slow: a run that wanders in chaos first has to wander in either case."""
    compared, saved = 0, []
    for point, response, _ in periodic(model):
        if response.floquet_multiplier ** (PLAIN_CYCLES / response.period) > 1e-12:
            continue  # plain marching has not come there yet
        off = np.abs(plain_means(point, response.period, PLAIN_CYCLES) - response.amplitude_ratio)
        assert off[-1] <= EXACT, (point, response)
        beyond = np.flatnonzero(off > EXACT)
        if response.floquet_multiplier > SLOW:
            saved.append(response.period * (2 + int(beyond[-1]) if beyond.size else 1) / response.cycles)
        compared += 1
    assert compared >= DRAWN // 2
    assert len(saved) >= DRAWN // 8
    assert np.median(saved) >= 5.0


@pytest.mark.parametrize("model", MODELS)
def test_multipliers_are_those_of_finite_differences(model: str) -> None:
    """Of plain marches, contacts under way at the section included: there depth or time left are what is varied.

    A mass that is held cannot be moved aside, nor can a particle that rides on it.
    """
    compared = in_contact = 0
    for point, response, end in periodic(model):
        held = point.friction is not None and end.slip == 0.0
        rides = model == "instant" and end.riding > 0.0
        if held or rides or response.impacts_per_cycle == 0.0:
            continue
        here, there, map_ = np.zeros(4), np.zeros(4), np.zeros((4, 4))
        coordinates(end, point.particle, here)
        possible = True
        for j in range(4):
            step = 1e-7 * (abs(here[j]) if end.riding > 0.0 and j == 2 else max(1.0, abs(here[j])))
            for sign in (1.0, -1.0):
                moved = here.copy()
                moved[j] += sign * step
                start, one_possible = state_at(moved, end, point.particle)
                possible = possible and one_possible
                after = plain_end(point, start, response.period)
                coordinates(after, point.particle, there)
                map_[:, j] += sign * there / (2.0 * step)
        if not possible:
            continue
        truth = np.abs(np.linalg.eigvals(map_)).max()
        assert response.floquet_multiplier == pytest.approx(truth, rel=0.0, abs=1e-5), (point, response)
        compared += 1
        in_contact += end.riding > 0.0
    assert compared >= DRAWN // 4
    assert in_contact >= 1 or model == "instant"


def test_multipliers_are_those_of_the_two_impact_motion() -> None:
    random = np.random.default_rng(5)
    compared = 0
    while compared < 12:
        r, clearance, restitution = random.uniform((0.85, 4.0, 0.3), (1.1, 14.0, 0.9)).tolist()
        mass, zeta = float(random.uniform(0.05, 0.3)), float(random.choice((0.0038, 0.02)))
        motions = two_impacts_per_cycle(zeta, r, clearance, restitution, mass)
        point = Point(zeta, r, None, Particle(clearance, restitution, mass))
        found, _ = solved(point)
        if found.response_class != ResponseClass.SYMMETRIC or found.impacts_per_cycle != 2.0:
            continue
        truth = min(motions, key=lambda motion: abs(motion.amplitude_ratio - found.amplitude_ratio))
        assert found.amplitude_ratio == pytest.approx(truth.amplitude_ratio, rel=0.0, abs=EXACT)
        assert found.floquet_multiplier == pytest.approx(truth.floquet_multiplier, rel=0.0, abs=1e-5)
        compared += 1


@both
@given(matrix=arrays(np.float64, (4, 4), elements=st.floats(-1e6, 1e6, allow_subnormal=False)))
def test_the_spectral_radius_is_the_largest_eigenvalue_of_the_leading_block(
    form: str, matrix: NDArray[np.float64]
) -> None:
    given_matrix = matrix.copy()
    found = in_form(spectral_radius, form)(matrix, 3)
    np.testing.assert_array_equal(matrix, given_matrix)
    # squaring goes wrong where eigenvalues are defective by the square root of rounding and more, as any method does
    scale = np.abs(matrix[:3, :3]).max()
    assert abs(found - np.abs(np.linalg.eigvals(matrix[:3, :3])).max()) <= 1e-4 * scale
