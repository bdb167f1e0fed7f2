"""The state of a steady response, with and without a cycle marched on from it."""

from typing import Literal

import pytest

from damperlab.worker.point import Design
from damperlab.worker.simulate import scenes_of, simulate
from damperlab.worker.solver.particle import Particle

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


def test_the_state_of_a_linear_structure_is_its_closed_form() -> None:
    z, r = 0.05, 0.9
    found = simulate(Design(z, r), followed=False).state
    response = (1 + 2j * z * r) / (1 - r * r + 2j * z * r)  # of u, to a base sin(r tau)
    assert found["u"] == pytest.approx(response.imag, rel=1e-13)
    assert found["u_rate"] == pytest.approx(r * response.real, rel=1e-13)


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
