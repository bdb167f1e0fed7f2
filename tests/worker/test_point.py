"""One design point: its steady state, with and without a cycle marched on, and from many starts; and random points."""

from typing import Literal

import pytest
from tests.benchmarks.sweep import sweep

from damperlab.studies.variables import ResponseClass, Status
from damperlab.worker.attractors import find_attractors
from damperlab.worker.point import Design
from damperlab.worker.simulate import scenes_of, simulate
from damperlab.worker.solver.particle import Particle
from damperlab.worker.steady.settle import Settings

PARTICLE = Particle(5.0, 0.47, 0.1)
CLOSES = 1e-8
"""How well a periodic orbit returns to its start: Newton's own tolerance, of amplitudes of a few Z."""


@pytest.mark.parametrize(
    "design",
    [
        Design(0.05, 0.9),
        Design(0.05, 1.0, 0.5),
        Design(0.0038, 1.05, 0.0, PARTICLE),
        Design(0.05, 1.0, 0.3, PARTICLE),
    ],
    ids=["linear", "friction", "particle", "hybrid"],
)
def test_a_periodic_response_that_is_not_followed_is_where_a_cycle_more_brings_it(design: Design) -> None:
    there, back = simulate(design, followed=False), simulate(design)
    assert there.metrics["period"] == back.metrics["period"] == 1
    assert there.state == pytest.approx(back.state, abs=CLOSES)
    assert (there.cycles, there.events, there.history) == (0, {}, {})
    without = [name for name in there.metrics if name != "run_time"]
    assert [there.metrics[name] for name in without] == [back.metrics[name] for name in without]


def test_kernels_that_show_an_orbit_are_needed_only_where_one_is_shown() -> None:
    hybrid = Design(0.05, 1.0, 0.3, PARTICLE)
    assert [scene.purpose for scene in scenes_of(hybrid, followed=False)] == ["steady"]
    assert [scene.purpose for scene in scenes_of(hybrid)] == ["steady", "orbit"]
    # a particle without mass is carried along, and has no steady state of its own
    carried = Design(0.05, 1.0, 0.3, PARTICLE._replace(mass_ratio=0.0))
    assert [scene.purpose for scene in scenes_of(carried, followed=False)] == ["steady", "orbit"]


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_a_particle_without_mass_rests_where_it_began_if_no_wall_comes_to_it(friction: float) -> None:
    found = simulate(Design(0.05, 1.0, friction, Particle(12.0, 0.8, 0.0)), history=2)
    assert found.metrics["amplitude_ratio"] < 12.0
    assert found.events["impacts"] == 0
    assert abs(found.history["p"]).max() <= 1e-13


@pytest.mark.parametrize(("method", "off"), [("event", 5e-3), ("rk4", 2e-2)])
def test_the_amplitude_of_a_march_is_defined_as_that_of_the_steady_response(
    method: Literal["event", "rk4"], off: float
) -> None:
    """Of a motion of three cycles, windows that begin at phase 0 alone give another mean, 6 % lower."""
    design = Design(0.00336, 1.36127, 0.0, Particle(2.47801, 0.47595, 0.14233))
    steady = simulate(design, followed=False).metrics
    assert steady["period"] == 3
    march = simulate(design, cycles=6000, method=method, steps_per_cycle=3200).metrics
    for name in ("amplitude_ratio", "relative_amplitude_ratio"):
        assert march[name] == pytest.approx(steady[name], rel=off)


SETTINGS = Settings(4000, 0.02, 1e-9)


def test_two_stable_responses_of_one_point_are_both_met_and_shared_out() -> None:
    """γ_F 0.6, d/Z 2, r 1.1: a symmetric response at 1.675 and one at 2.095 that is not (solver comparison)."""
    found = find_attractors(Design(0.0038, 1.1, 0.6, Particle(2.0, 0.47, 0.1)), 32, 0, SETTINGS)
    amplitudes = sorted(one.response.amplitude_ratio for one in found.met)
    assert len(amplitudes) >= 2
    assert min(abs(a - 1.675) for a in amplitudes) < 1e-3
    assert sum(one.starts for one in found.met) == 32 - found.failed
    assert f"{len(found.met)} responses" in found.sentence


def test_a_point_with_one_response_says_so() -> None:
    found = find_attractors(Design(0.05, 0.8, 0.5, None), 16, 0, SETTINGS)
    assert len(found.met) == 1
    assert found.met[0].starts == 16
    assert found.met[0].from_rest
    assert not found.by_a_rounding
    assert found.sentence == "All 16 starts lead to one response."


def test_without_friction_and_particle_every_start_leads_to_the_closed_form() -> None:
    found = find_attractors(Design(0.05, 0.8), 8, 0, SETTINGS)
    assert [one.response.response_class for one in found.met] == [ResponseClass.LINEAR]


def test_under_a_force_nothing_is_next_to_a_structure_at_rest() -> None:
    found = find_attractors(Design(0.05, 0.8, 0.5, None, forced=True), 4, 0, SETTINGS)
    assert (found.met[0].starts, found.met[0].from_next_to_rest) == (4, False)


POINTS = 2000


@pytest.mark.night
def test_every_random_point_ends_with_a_status_and_finite_values() -> None:
    """A million of them are a benchmark, `python -m tests.benchmarks sweep`."""
    figures = sweep(POINTS, seed=20261121)
    assert figures["found"] == []
    assert sum(figures["status"].values()) == POINTS
    failed = [name for name in figures["status"] if Status[name] > Status.MAX_CYCLES]
    assert sum(figures["status"][name] for name in failed) < POINTS // 50
