"""A particle that rubs on its cavity, or falls in it: states beside another integrator, closed forms, multipliers of orbits."""

import numpy as np
import pytest
from tests.oracles.rubbing_particle import RubbingParticle
from tests.worker.forms import night
from tests.worker.plain_python import plainly

from damperlab.studies.variables import ResponseClass, Status
from damperlab.worker.point import Design, Simulation, simulate_ready
from damperlab.worker.solver.events import BUDGET
from damperlab.worker.solver.integrate import half_cycle
from damperlab.worker.solver.observe.meter import METERS, Meter
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.scene import make_scene
from damperlab.worker.solver.segment_log import empty_log
from damperlab.worker.solver.sliding import direction_of
from damperlab.worker.steady.section.coordinates import coordinates, state_at
from damperlab.worker.steady.settle import Settings, settle
from damperlab.worker.steady.start import at_rest

CYCLES = 3
PEAKS = Settings(4000, 0.02, 1e-9, None)
"""Of a steady response without its energies, whose kernels others need too."""

NEXT_TO_NOTHING = 1e-12
"""A friction ratio that changes no digit that is looked at: with it the kernels of a structure that rubs are used here too."""
# ζ, r, γ_F, d/Z, e, β, κ: walls, sliding; never a wall; carried and torn loose; walls that keep the particle
POINTS = (
    (0.019, 1.244, 0.0, 1.328, 0.486, 0.361, 0.182),
    (0.008, 0.707, 0.222, 1.943, 0.7, 0.134, 0.236),
    (0.011, 1.36, 0.669, 2.215, 0.439, 0.336, 0.172),
    (0.030, 1.365, 0.489, 0.587, 0.8, 0.031, 1.468),
    (0.002, 1.188, 0.335, 0.462, 0.0, 0.189, 1.004),
)


# with G at the end: a cavity a little tilted, one whose walls keep the particle, one that does not rub, one that stands
FALLING = (
    (0.055, 0.901, 0.0, 3.864, 0.9, 0.348, 0.754, 0.108),
    (0.007, 1.039, 0.133, 4.322, 0.0, 0.32, 0.094, 0.702),
    (0.013, 1.346, 0.145, 3.424, 0.8, 0.323, 0.0, 0.119),
    (0.002, 1.374, 0.166, 2.508, 0.0, 0.319, 0.041, 1.311),
)


def design_of(
    zeta: float,
    r: float,
    gamma: float,
    clearance: float,
    e: float,
    mass: float,
    friction: float,
    gravity: float = 0.0,
) -> Design:
    particle = Particle(clearance, e, mass, friction=friction, gravity=gravity if gravity > 0.0 else None)
    return Design(zeta, r, gamma, particle)


def assert_marches(found: Simulation, point: tuple[float, ...]) -> None:
    """Assert that a march ends where another integrator ends."""
    state, _ = RubbingParticle(*point).march(CYCLES)
    assert list(found.state.values()) == pytest.approx(state, rel=0, abs=1e-9)
    assert found.metrics["energy_residual"] < 1e-12


@pytest.mark.parametrize(
    "point", [*(one if one[2] > 0.0 else night(one) for one in POINTS), *map(night, FALLING)]
)
def test_a_march_ends_where_another_integrator_does(point: tuple[float, ...]) -> None:
    assert_marches(simulate_ready(design_of(*point), CYCLES), point)


def test_a_particle_that_falls_ends_where_another_integrator_does_in_plain_python() -> None:
    """One that stands lifts off where its floor falls faster: the structure is held on its base, which shakes it with r²."""
    standing = [design_of(0.01, 1.3, 100.0, 3.0, 0.5, 1e-3, 0.0, weight * 1.3**2) for weight in (1.01, 0.99)]
    asked = [*((design_of(*point), CYCLES) for point in FALLING), *((one, 5) for one in standing)]
    *found, held, lifted = plainly(simulate_ready, asked)
    for one, point in zip(found, FALLING, strict=True):
        assert_marches(one, point)
    assert held.events["impacts"] == 0 < lifted.events["impacts"]


@pytest.mark.parametrize(("friction", "gravity"), [(100.0, 0.0), night(0.0, 500.0)])
def test_a_particle_that_rubs_or_weighs_enough_is_dead_mass(friction: float, gravity: float) -> None:
    zeta, r, mass = 0.05, 0.8, 0.2
    design = design_of(zeta, r, NEXT_TO_NOTHING, 2.0, 0.5, mass, friction, gravity)
    found = simulate_ready(design, settings=PEAKS, followed=False).metrics
    loss = 2j * zeta * r
    assert found["amplitude_ratio"] == pytest.approx(
        abs((1 + loss) / (1 - (1 + mass) * r**2 + loss)), rel=1e-9
    )
    assert found["response_class"] == ResponseClass.CARRIED
    assert simulate_ready(design, CYCLES).metrics.get("dissipation_particle", 0.0) == 0.0


def test_a_light_particle_slides_as_on_a_floor_that_shakes() -> None:
    # far above κ it slides to and fro and turns where its velocity is that of the floor: p'' = ±κ for half a cycle each
    zeta, r, friction = 0.2, 1.0, 0.05
    light = simulate_ready(design_of(zeta, r, NEXT_TO_NOTHING, 50.0, 0.5, 1e-9, friction), 100, history=1)
    p_rate = light.history["p_rate"]
    floor = np.abs(light.history["u_rate"]).max()
    assert floor > 20 * friction
    assert np.ptp(p_rate) == pytest.approx(friction * np.pi / r, rel=2e-3)


@pytest.mark.parametrize(
    ("least", "falls"), [(NEXT_TO_NOTHING, False), night(NEXT_TO_NOTHING, True), night(0.0, True)]
)
def test_every_extreme_scene_has_a_status_and_balances_its_energy(least: float, falls: bool) -> None:
    rng = np.random.default_rng(42)
    for i in range(300):
        r = 10 ** rng.uniform(-1, 0.7)
        gamma = (least, r**2, rng.uniform(0, 1.2))[i % 3]
        friction = (r**2, 10 ** rng.uniform(-8, 2))[i % 2]
        restitution = (0.0, 1.0, rng.uniform(0, 1), rng.uniform(0, 1))[i % 4]
        gravity = (0.0, 0.0, falls * 10 ** rng.uniform(-2, 2))[i % 3]
        particle = 10 ** rng.uniform(-3, 1.5), restitution, 10 ** rng.uniform(-6, 1), friction, gravity
        found = simulate_ready(design_of(10 ** rng.uniform(-4, -0.5), r, gamma, *particle), 10).metrics
        assert found["status"] == Status.MAX_CYCLES, (i, particle)
        assert found["energy_residual"] < 1e-9, (i, particle)


# impacts on both walls with carried phases; one in a cavity that is tilted
@pytest.mark.parametrize(
    "point",
    [
        (0.0038, 1.0, 0.4, 5.0, 0.47, 0.1, 3.0),
        night((0.074, 1.018, 0.551, 3.909, 0.458, 0.258, 0.964, 0.278)),
    ],
)
def test_the_multiplier_of_an_orbit_is_that_of_differences(point: tuple[float, ...]) -> None:
    zeta, r, gamma = point[:3]
    particle = design_of(*point).particle
    response, end = settle(zeta, r, gamma, particle, PEAKS, at_rest(r, gamma, particle))
    assert (response.status, response.period) == (Status.CONVERGED, 1)
    scene = make_scene(zeta, r, gamma, particle, True)
    meter, log = Meter(np.zeros(METERS)), empty_log(1000)
    here = np.empty(4)
    coordinates(end, particle, here)

    def a_cycle_later(at: np.ndarray) -> np.ndarray:
        state, possible = state_at(at, end, particle)
        assert possible
        for _ in range(2):
            scene.counts[:] = 0
            scene.counts[BUDGET] = 10_000
            log.cursor[0] = 0
            state, _ = half_cycle(state, scene, meter, log)
        found = np.empty(4)
        coordinates(state, particle, found)
        return found

    assert response.impacts_per_cycle > 0
    free = [0, 1, 2, 3] if direction_of(end.slide) != 0.0 else [0, 1, 3]
    step = 1e-6
    jacobian = np.empty((len(free), len(free)))
    for column, name in enumerate(free):
        moved = np.eye(4)[name] * step
        change = a_cycle_later(here + moved) - a_cycle_later(here - moved)
        jacobian[:, column] = change[free] / (2 * step)
    largest = np.abs(np.linalg.eigvals(jacobian)).max()
    assert response.floquet_multiplier == pytest.approx(largest, rel=1e-4)


def test_friction_of_the_particle_has_a_share_of_what_is_dissipated() -> None:
    found = simulate_ready(design_of(0.0038, 1.0, 0.4, 5.0, 0.47, 0.1, 1.0), 60).metrics
    shares = [found[f"dissipation_{name}"] for name in ("viscous", "friction", "impact", "particle")]
    assert sum(shares) == pytest.approx(1.0, abs=1e-12)
    assert min(shares) > 0.01
