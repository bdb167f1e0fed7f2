"""A mass under a force that friction holds for good in the end, beside a particle that goes on ever more slowly."""

from math import inf

import numpy as np
import pytest
from tests.worker.designs_drawn import with_contact
from tests.worker.forms import both, in_form, night
from tests.worker.plain_march import marched, metered

from damperlab.studies.variables import ResponseClass, Status
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.scene import make_scene
from damperlab.worker.solver.state import Dwell, State
from damperlab.worker.steady.ensemble import attractors, drawn_starts
from damperlab.worker.steady.locked_by_friction import slowing_limit
from damperlab.worker.steady.response.standard_errors import Estimate
from damperlab.worker.steady.settle import Settings, settle
from damperlab.worker.steady.stopping_rules import next_estimate

SETTINGS = Settings(4000, 0.02, 1e-9)
FORCED = True
HALVES = 16_000
"""Of the march that tells where a mass ends: twice as long as the longest run of `SETTINGS`."""


def end_of(
    damping: float, r: float, friction: float, particle: Particle, start: State, halves: int = HALVES
) -> tuple[State, float]:
    """State after half cycles without measuring and two more, and the largest |u| of those two."""
    structure = damping, r, friction, particle
    last = metered(*structure, marched(*structure, start, halves, FORCED), 2, FORCED)
    return last.end, float(last.peaks.max())


def allowed(amplitude: float) -> float:
    """Error within which a locked response counts as known."""
    return SETTINGS.tolerance * max(amplitude, 0.01)


@pytest.mark.parametrize(
    ("model", "points"), [("instant", 2), *(night(model, 25) for model in ("instant", "dwell", "compliant"))]
)
def test_a_mass_ends_as_near_to_its_limit_as_is_said(model: str, points: int) -> None:
    """By a march from the same start, twice as long as any run; what still creeps then goes on to the edge."""
    random = np.random.default_rng(5)
    told = 0
    for _ in range(points):
        damping, r = random.uniform(0.002, 0.3), float(np.exp(random.uniform(np.log(0.3), np.log(3.0))))
        friction = float(random.choice([1.0, 1.002, 1.02, 1.2, 1.5, 3.0]))
        particle = Particle(
            10.0 ** random.uniform(-1.5, 1.0),
            float(random.choice([0.1, 0.3, 0.6, 0.9])),
            float(random.choice([0.02, 0.1, 0.3])),
        )
        particle = with_contact(particle, model, 0.3)
        coordinates = (damping, r, friction, *particle[:3])
        for start in drawn_starts(3, 7, coordinates, damping, r, friction, particle, FORCED):
            response, _ = settle(damping, r, friction, particle, SETTINGS, start, FORCED)
            if response.response_class != ResponseClass.LOCKED:
                continue
            known = response.status == Status.CONVERGED
            assert known == (response.amplitude_error <= allowed(response.amplitude_ratio))
            told += known
            assert (response.period, response.impacts_per_cycle) == (1, 0.0)
            _, peak = end_of(damping, r, friction, particle, start)
            ends = min(peak, max(response.amplitude_ratio, friction - 1.0))
            # by a mean that was known: four of its standard errors
            most = 4.0 * response.amplitude_error + 1e-12
            assert abs(ends - response.amplitude_ratio) <= most, (coordinates, start)
    assert told >= 0.9 * 3 * points


def test_all_starts_lead_to_one_response() -> None:
    """The particle slows down for ever: no run comes to where it rests."""
    r, friction, particle = 0.98, 2.0, Particle(0.5, 0.3, 0.1)
    starts = drawn_starts(12, 0, (0.09, r, friction, *particle[:3]), 0.09, r, friction, particle, FORCED)
    found = [settle(0.09, r, friction, particle, SETTINGS, start, FORCED)[0] for start in starts]
    assert {response.status for response in found} == {Status.CONVERGED}
    assert len(attractors(found)) == 1


@pytest.mark.night
@pytest.mark.parametrize("speed", [0.3, 0.1, 0.03, 0.01])
def test_walls_that_push_less_than_friction_holds_do_not_move_the_mass(speed: float) -> None:
    """Up to the speed at which the wall pushes with the margin of 0.4, 0.46 here: one outcome, known at once."""
    r, particle = 1.0, with_contact(Particle(5.0, 0.9, 0.3), "compliant", 1.0)
    start = State(0.1, 0.0, 0.0, 1.0, 5.0, speed, 0.0, 0, 0, Dwell(0.0, 0.0))
    response, _ = settle(0.05, r, 1.5, particle, SETTINGS, start, FORCED)
    assert (response.response_class, response.status) == (ResponseClass.LOCKED, Status.CONVERGED)
    assert (response.amplitude_ratio, response.amplitude_error) == (0.1, 0.0)
    assert response.cycles <= 32, "a look or two"
    end, _ = end_of(0.05, r, 1.5, particle, start, 8000)
    assert end.v == 0.1
    assert abs(end.p_rate) < speed, "walls have been struck"


def test_a_mean_that_is_known_ends_the_run_before_the_bound_does() -> None:
    """Impacts with e = 0.97 may move the mass far in all, and hardly have when its mean is known."""
    r, particle = 1.1, Particle(2.0, 0.97, 0.3)
    coordinates = (0.1, 1.1, 1.3, *particle[:3])
    ended = 0
    for start in drawn_starts(12, 1, coordinates, 0.1, r, 1.3, particle, FORCED):
        response, end = settle(0.1, r, 1.3, particle, SETTINGS, start, FORCED)
        assert (response.response_class, response.period) == (ResponseClass.LOCKED, 1)
        scene = make_scene(0.1, r, 1.3, particle, True, FORCED)
        _, way_left = slowing_limit(end, 1.3, particle, scene)
        if response.status == Status.CONVERGED and allowed(response.amplitude_ratio) < way_left < inf:
            ended += 1
            _, peak = end_of(0.1, r, 1.3, particle, start)
            assert abs(peak - response.amplitude_ratio) <= 4.0 * response.amplitude_error
    assert ended > 0


def test_a_run_that_stops_before_the_way_left_is_small_says_so() -> None:
    """A mass of γ_F = 1 ends at zero; with e = 0.9 the particle still has speed enough to move it when the run has to stop."""
    r, particle = 1.46, Particle(2.6, 0.9, 0.3)
    start = State(0.005, 0.0, 0.0, 1.0, 1.0, 0.01, 0.0, 0, 0, None)
    response, end = settle(0.19, r, 1.0, particle, SETTINGS, start, FORCED)
    assert response.status == Status.MAX_CYCLES
    assert response.response_class == ResponseClass.LOCKED
    assert response.amplitude_ratio == 0.0
    assert allowed(0.0) < response.amplitude_error < 0.02
    assert end.p_rate != 0.0, "who goes on from there goes on with the particle"


@both
def test_a_mean_of_zero_is_looked_at_again_soon(form: str) -> None:
    """That of a mass held at zero, whose error has nothing to be compared with."""
    of_zero = Estimate(first=0, last=800, mean=0.0, error=0.0, correlation=0.0, stationary=True)
    assert in_form(next_estimate, form)(of_zero, SETTINGS) == 840, "a twentieth later, the soonest there is"


@pytest.mark.parametrize(
    ("why", "friction", "particle", "change"),
    [
        ("friction holds it nowhere for good", 0.9, Particle(2.0, 0.5, 0.1), {}),
        ("the particle is not slowed", 1.5, Particle(2.0, 1.0, 0.1), {}),
        ("it slips", 1.5, Particle(2.0, 0.5, 0.1), {"slip": 1.0, "w": 0.1}),
        ("it is far from where friction holds it", 1.5, Particle(2.0, 0.5, 0.1), {"v": 0.6}),
        ("the particle throws it farther than it creeps", 1.5, Particle(2.0, 0.5, 0.1), {"p_rate": 3.0}),
    ],
)
def test_no_limit_is_told_of_a_mass_that_may_yet_move_far(
    why: str, friction: float, particle: Particle, change: dict[str, float]
) -> None:
    scene = make_scene(0.05, 1.1, friction, particle, True, FORCED)
    at_ease = State(0.2, 0.0, 0.0, 1.0, 1.0, 0.001, 0.0, 0, 0, None)
    _, way_left = slowing_limit(at_ease._replace(**change), friction, particle, scene)
    assert way_left == inf, why


def test_the_limit_is_where_the_mass_is_or_the_edge() -> None:
    particle = Particle(2.0, 0.5, 0.1)
    scene = make_scene(0.05, 1.1, 1.5, particle, True, FORCED)
    for v, ends in ((0.2, 0.2), (-0.5, -0.5), (0.505, 0.5), (-0.505, -0.5)):
        limit, way_left = slowing_limit(
            State(v, 0.0, 0.0, 1.0, 1.0, 0.001, 0.0, 0, 0, None), 1.5, particle, scene
        )
        assert limit.v == pytest.approx(ends, abs=1e-15)
        assert (limit.w, limit.p_rate) == (0.0, 0.0)
        assert 0.0 < way_left <= 0.01
    still = State(0.2, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0, 0, None)
    assert slowing_limit(still, 1.5, particle, scene)[1] == 0.0, "nothing moves any more"
