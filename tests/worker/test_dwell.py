"""The contact model `dwell`: against a general-purpose integrator, in its limit, by its energy balance."""

from dataclasses import replace
from math import pi

import pytest
from tests.oracles.dwelling import Scene, end_state

from damperlab.studies.definition import parse_study
from damperlab.studies.plan import Block
from damperlab.studies.presets import CONTACT_TIMES
from damperlab.studies.variables import Status
from damperlab.worker.block import solve_block
from damperlab.worker.point import Design
from damperlab.worker.simulate import simulate
from damperlab.worker.solver.particle import Particle


def design_of(scene: Scene) -> Design:
    particle = Particle(scene.clearance_ratio, scene.restitution, scene.mass_ratio, scene.contact_time)
    return Design(scene.damping_ratio, scene.frequency_ratio, scene.friction_ratio, particle)


SCENES = [
    pytest.param(Scene(0.02, 1.0, 0.0, 5.0, 0.47, 0.1, 0.3), marks=pytest.mark.night),
    # of contact longer than a half cycle
    pytest.param(Scene(0.02, 0.8, 0.0, 1.5, 0.8, 0.4, 7.0), marks=pytest.mark.night),
    Scene(0.05, 1.0, 0.4, 2.0, 0.6, 0.2, 0.5),
    Scene(0.05, 0.6, 0.25, 0.4, 0.7, 0.2, 1.1),  # turns and stops while the particle is held
]


@pytest.mark.parametrize("scene", SCENES, ids=str)
def test_end_state_agrees_with_a_general_integrator(scene: Scene) -> None:
    """Its tolerance is 1e-12 a step of hundreds; every impact amplifies by at most a few."""
    cycles = 6
    expected, impacts = end_state(scene, cycles)
    found = simulate(design_of(scene), cycles)
    assert impacts >= 3
    assert found.events["impacts"] == impacts
    assert list(found.state.values()) == pytest.approx(expected, rel=0.0, abs=1e-8)
    assert found.metrics["energy_residual"] <= 1e-12


def test_fixed_steps_refuse_a_contact_time() -> None:
    with pytest.raises(ValueError, match="contact_time"):
        simulate(Design(0.02, 1.0, 0.4, Particle(2.0, 0.6, 0.2, 0.5)), 2, method="rk4")


def test_held_particle_keeps_its_wall_whatever_the_force() -> None:
    """A contact longer than the run: after the first impact the particle never leaves the wall, which pulls it too."""
    short = simulate(Design(0.02, 1.0, 0.0, Particle(0.5, 0.47, 0.1, 1e3)), 12, history=12)
    assert short.events == {"impacts": 1, "turns": 0, "attachments": 0}
    u, p, time = (short.history[name] for name in ("u", "p", "time"))
    struck = int(short.history["impact"].nonzero()[0][0])
    after = slice(struck + 1, None)
    assert abs(abs(u[after] - p[after]) - 0.5).max() <= 1e-12
    assert time[-1] - time[struck] > 10.0 * 2.0 * pi


def _difference(scene: Scene, cycles: int) -> float:
    """Largest difference of the end state from that of the instantaneous law."""
    design = design_of(scene)
    assert design.particle is not None
    instant = replace(design, particle=design.particle._replace(contact_time=None))
    ends = (simulate(one, cycles).state.values() for one in (design, instant))
    return max(abs((a or 0.0) - (b or 0.0)) for a, b in zip(*ends, strict=True))


@pytest.mark.parametrize("friction", [pytest.param(0.0, marks=pytest.mark.night), 0.4])
def test_short_contacts_tend_to_the_instantaneous_law_with_order_one(friction: float) -> None:
    """The bodies move joined for a time T an impact, at a speed that is wrong by order one: an error of order T."""
    errors = []
    for contact_time in (1e-4, 1e-5, 1e-6):
        scene = Scene(0.0038, 1.0, friction, 5.0, 0.47, 0.1, contact_time)
        errors.append(_difference(scene, 6))
    assert errors[0] < 0.1
    assert errors[0] / errors[1] == pytest.approx(10.0, rel=0.05)
    assert errors[1] / errors[2] == pytest.approx(10.0, rel=0.05)


@pytest.mark.parametrize("contact_time", [1e-9, *(one.contact_time for one in CONTACT_TIMES.values())])
@pytest.mark.parametrize(
    "particle",
    [(10.0, 0.47), (0.3, 0.47), (0.5, 0.0), (2.0, 1.0)],
    ids=["impacts", "chatter", "plastic", "elastic"],
)
@pytest.mark.parametrize("friction", [pytest.param(0.0, marks=pytest.mark.night), 0.8])
def test_energy_balances(friction: float, particle: tuple[float, float], contact_time: float) -> None:
    clearance, restitution = particle
    design = Design(0.0038, 0.9, friction, Particle(clearance, restitution, 0.1, contact_time))
    found = simulate(design, 40).metrics
    assert found["status"] == Status.MAX_CYCLES
    assert found["energy_residual"] <= 1e-12


@pytest.mark.night
def test_study_with_contact_time_by_name() -> None:
    """The presets are the paper's times over 1/ω_n at 2.5 Hz, and a block answers as the point alone does."""
    document = {
        "damping_ratio": 0.02,
        "axes": {
            "clearance_ratio": 2.0,
            "friction_ratio": [0.0, 0.4],
            "restitution": 0.47,
            "frequency_ratio": 1.0,
        },
        "contact": {"model": "dwell", "contact_time": "paper_soft_real"},
    }
    study = parse_study(document)
    assert study.document()["contact"]["contact_time"] == pytest.approx(5.0 * pi * 0.02055, rel=1e-15)
    found = solve_block(study, Block(0, (0,) * 6, study.shape))
    for i, friction in enumerate((0.0, 0.4)):
        particle = Particle(2.0, 0.47, 0.1, CONTACT_TIMES["paper_soft_real"].contact_time)
        alone = simulate(Design(0.02, 1.0, friction, particle)).metrics
        assert found["amplitude_ratio"].flat[i] == alone["amplitude_ratio"]
        assert found["energy_residual"].flat[i] <= 1e-12
        assert found["status"].flat[i] in (Status.CONVERGED, Status.MAX_CYCLES)


@pytest.mark.parametrize("restitution", [0.0, 0.6])
def test_a_particle_without_mass_is_thrown_back_by_a_mass_that_is_held(restitution: float) -> None:
    """It moves as one of next to no mass, whose push a held mass does not feel."""
    found, other = (
        simulate(Design(0.02, 0.5, 0.3, Particle(0.5, restitution, beta, 0.5)), 6) for beta in (0.0, 1e-13)
    )
    assert found.events["impacts"] == other.events["impacts"] > 6
    assert list(found.state.values()) == pytest.approx(list(other.state.values()), abs=1e-9)
