"""A particle that rubs on its cavity: states beside another integrator, closed forms, and what its orbits say of themselves."""

import numpy as np
import pytest
from tests.oracles.rubbing_particle import RubbingParticle

from damperlab.studies.variables import ResponseClass, Status
from damperlab.worker.point import Design, simulate_ready
from damperlab.worker.solver.excitation.excitation import phase_at
from damperlab.worker.solver.integrate import half_cycle
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.scene import make_scene
from damperlab.worker.solver.sliding import direction_of
from damperlab.worker.steady.section.coordinates import coordinates, state_at
from damperlab.worker.steady.settle import Settings, settle
from damperlab.worker.steady.start import at_rest

CYCLES = 5
# ζ, r, γ_F, d/Z, e, β, κ: sliding with impacts; never a wall; carried and torn loose; walls that keep the particle; held structure
POINTS = (
    (0.019, 1.244, 0.0, 1.328, 0.486, 0.361, 0.182),
    (0.008, 0.707, 0.222, 1.943, 0.7, 0.134, 0.236),
    (0.011, 1.36, 0.669, 2.215, 0.439, 0.336, 0.172),
    (0.003, 1.215, 0.599, 0.845, 0.76, 0.091, 0.15),
    (0.030, 1.365, 0.489, 0.587, 0.8, 0.031, 1.468),
    (0.002, 1.188, 0.335, 0.462, 0.0, 0.189, 1.004),
    (0.012, 0.822, 0.682, 3.338, 0.193, 0.261, 0.791),
)


def design_of(zeta: float, r: float, gamma: float, *particle: float) -> Design:
    clearance, restitution, mass, friction = particle
    return Design(zeta, r, gamma, Particle(clearance, restitution, mass, friction=friction))


@pytest.mark.parametrize("point", POINTS)
def test_a_march_ends_where_another_integrator_does(point: tuple[float, ...]) -> None:
    found = simulate_ready(design_of(*point), CYCLES)
    state, _ = RubbingParticle(*point).march(CYCLES)
    assert list(found.state.values()) == pytest.approx(state, rel=0, abs=1e-9)
    assert found.metrics["energy_residual"] < 1e-12


@pytest.mark.parametrize("r", [0.8, 1.0, 1.2])
def test_a_particle_with_enough_friction_is_dead_mass(r: float) -> None:
    zeta, mass = 0.05, 0.2
    found = simulate_ready(design_of(zeta, r, 0.0, 2.0, 0.5, mass, 100.0)).metrics
    loss = 2j * zeta * r
    assert found["amplitude_ratio"] == pytest.approx(abs((1 + loss) / (1 - (1 + mass) * r**2 + loss)), rel=1e-9)
    assert found["response_class"] == ResponseClass.CARRIED
    assert found["dissipation_particle"] == 0.0


def test_a_light_particle_slides_as_on_a_floor_that_shakes() -> None:
    # far above κ it slides to and fro and turns where its velocity is that of the floor: p'' = ±κ for half a cycle each
    zeta, r, friction = 0.2, 1.0, 0.05
    light = simulate_ready(design_of(zeta, r, 0.0, 50.0, 0.5, 1e-9, friction), history=1)
    p_rate = light.history["p_rate"]
    floor = np.abs(light.history["u_rate"]).max()
    assert floor > 20 * friction
    assert np.ptp(p_rate) == pytest.approx(friction * np.pi / r, rel=2e-3)


def test_every_extreme_scene_has_a_status_and_balances_its_energy() -> None:
    rng = np.random.default_rng(42)
    for i in range(300):
        r = 10 ** rng.uniform(-1, 0.7)
        gamma = (0.0, r**2, rng.uniform(0, 1.2))[i % 3]
        friction = (r**2, 10 ** rng.uniform(-8, 2))[i % 2]
        restitution = (0.0, 1.0, rng.uniform(0, 1), rng.uniform(0, 1))[i % 4]
        particle = 10 ** rng.uniform(-3, 1.5), restitution, 10 ** rng.uniform(-6, 1), friction
        found = simulate_ready(design_of(10 ** rng.uniform(-4, -0.5), r, gamma, *particle), 10).metrics
        assert found["status"] == Status.MAX_CYCLES, (i, particle)
        assert found["energy_residual"] < 1e-9, (i, particle)


# one impact pair a cycle with carried phases, and a particle that never meets a wall
@pytest.mark.parametrize(
    "point", [(0.0038, 1.0, 0.4, 5.0, 0.47, 0.1, 3.0), (0.02, 0.95, 0.3, 40.0, 0.5, 0.2, 0.3)]
)
def test_the_multiplier_of_an_orbit_is_that_of_differences(point: tuple[float, ...]) -> None:
    zeta, r, gamma, *rest = point
    particle = design_of(*point).particle
    response, end = settle(zeta, r, gamma, particle, Settings(4000, 0.02, 1e-9), at_rest(r, gamma, particle))
    assert response.status == Status.CONVERGED and response.period == 1
    scene = make_scene(zeta, r, gamma, particle, None)
    scene.counts[-1] = 0
    here = np.empty(4)
    coordinates(end, particle, here)

    def a_cycle_later(at: np.ndarray) -> np.ndarray:
        state, possible = state_at(at, end, particle)
        assert possible
        for _ in range(2):
            scene.counts[:] = 0
            scene.counts[5] = 10_000
            state, _ = half_cycle(state, scene, None, None)
        found = np.empty(4)
        coordinates(state, particle, found)
        return found

    free = [0, 1, 2] if direction_of(end.slide) != 0.0 else [0, 1]
    if response.impacts_per_cycle > 0:
        free.append(3)
    step = 1e-6
    jacobian = np.empty((len(free), len(free)))
    for column, name in enumerate(free):
        moved = np.eye(4)[name] * step
        change = a_cycle_later(here + moved) - a_cycle_later(here - moved)
        jacobian[:, column] = change[free] / (2 * step)
    largest = np.abs(np.linalg.eigvals(jacobian)).max()
    assert response.floquet_multiplier == pytest.approx(largest, rel=1e-4)
    assert phase_at(scene.base, 0).position == 0.0


def test_friction_of_the_particle_has_a_share_of_what_is_dissipated() -> None:
    found = simulate_ready(design_of(0.0038, 1.0, 0.4, 5.0, 0.47, 0.1, 1.0)).metrics
    shares = [found[f"dissipation_{name}"] for name in ("viscous", "friction", "impact", "particle")]
    assert sum(shares) == pytest.approx(1.0, abs=1e-12)
    assert min(shares) > 0.01
    without = simulate_ready(Design(0.0038, 1.0, 0.4, Particle(5.0, 0.47, 0.1))).metrics
    assert "dissipation_particle" not in without
