"""Contacts that take time, `dwell` and `compliant`: against marches of others, in their limit, by their balances."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from tests.oracles import compliant_wall, dwelling
from tests.worker.designs_drawn import with_contact
from tests.worker.forms import night
from tests.worker.plain_python import plainly

from damperlab.studies.definition import parse_study
from damperlab.studies.plan import Block
from damperlab.studies.presets import CONTACT_TIMES
from damperlab.studies.variables import Status
from damperlab.worker.block import solve_block
from damperlab.worker.physics.compliant_wall import contact_time_of_stiffness
from damperlab.worker.point import Design, Simulation, simulate_ready
from damperlab.worker.simulate import simulate
from damperlab.worker.solver.particle import Particle

MODELS = ("dwell", "compliant")


# of the second the contact is longer than a half cycle; of the last the mass turns and stops while the particle is held
DWELLS = [
    dwelling.Scene(0.02, 1.0, 0.0, 5.0, 0.47, 0.1, 0.3),
    dwelling.Scene(0.02, 0.8, 0.0, 1.5, 0.8, 0.4, 7.0),
    dwelling.Scene(0.05, 1.0, 0.4, 2.0, 0.6, 0.2, 0.5),
    dwelling.Scene(0.05, 0.6, 0.25, 0.4, 0.7, 0.2, 1.1),
]


def dwelling_design(scene: dwelling.Scene) -> Design:
    particle = Particle(scene.clearance_ratio, scene.restitution, scene.mass_ratio, scene.contact_time)
    return Design(scene.damping_ratio, scene.frequency_ratio, scene.friction_ratio, particle, scene.forced)


def assert_dwells(found: Simulation, scene: dwelling.Scene) -> None:
    """Assert that six cycles end where a plain march ends.

    Both round at 1e-16 of a state of ten, thousands of times, and impacts amplify.
    """
    expected, march = dwelling.end_state(scene, 6)
    assert march.impacts >= 3
    assert found.events["impacts"] == march.impacts
    assert list(found.state.values()) == pytest.approx(expected, rel=0.0, abs=1e-9)
    assert found.metrics["energy_residual"] <= 1e-12


@pytest.mark.night
@pytest.mark.parametrize("forced", [False, True])
@pytest.mark.parametrize("scene", DWELLS, ids=str)
def test_a_contact_of_given_time_agrees_with_a_plain_march(scene: dwelling.Scene, forced: bool) -> None:
    scene = replace(scene, forced=forced)
    assert_dwells(simulate(dwelling_design(scene), 6), scene)


# ζ, r, γ_F, d/Z, e, β, K/k, cycles: impacts alone; with friction; chatter, rest on the wall and stick; turns and stops in
# contact; without loss; overdamped; so much that its rates are far apart, both fast
SHAKEN = [
    (0.0038, 1.0, 0.0, 2.0, 0.47, 0.1, 1.0, 4),
    (0.0038, 1.0, 0.0, 2.0, 0.47, 0.1, 1e2, 4),
    (0.0038, 1.0, 0.0, 2.0, 0.47, 0.1, 1e8, 4),
    (0.0038, 1.0, 0.4, 2.0, 0.47, 0.1, 10.0, 4),
    (0.0038, 1.0, 0.4, 2.0, 0.47, 0.1, 1e6, 4),
    (0.0038, 0.9, 0.8, 0.3, 0.1, 0.1, 1e1, 2),
    (0.0038, 0.9, 0.8, 0.3, 0.1, 0.1, 1e3, 2),
    (0.05, 0.6, 0.25, 0.4, 0.7, 0.2, 1e2, 3),
    (0.05, 0.6, 0.25, 0.4, 0.7, 0.2, 1e4, 3),
    (0.02, 1.0, 0.0, 2.0, 1.0, 0.1, 1e4, 3),
    (0.02, 1.0, 0.3, 0.5, 1e-3, 0.3, 1e1, 3),
    (0.05, 2.5, 0.3, 0.2, 0.05, 2.0, 30.0, 4),
    (0.02, 1.0, 0.0, 1.0, 1e-2, 0.1, 2e3, 2),
    (0.02, 0.9, 0.4, 0.5, 1e-2, 0.1, 1e4, 2),
    (0.02, 1.0, 0.3, 0.5, 1e-3, 0.3, 1e3, 2),
]
FORCED = [
    (0.0038, 1.0, 0.0, 2.0, 0.47, 0.1, 1e2, 4),
    (0.0038, 1.0, 0.0, 2.0, 0.47, 0.1, 1e8, 4),
    (0.0038, 1.0, 0.4, 2.0, 0.47, 0.1, 10.0, 4),
    (0.0038, 0.9, 0.8, 0.3, 0.1, 0.1, 1e3, 3),
    (0.05, 0.6, 0.25, 0.4, 0.7, 0.2, 1e2, 3),
    (0.02, 1.0, 0.3, 0.5, 1e-3, 0.3, 1e3, 2),
    (0.02, 0.5, 0.0, 0.05, 0.1, 0.3, 1e3, 1),
]


def compliant_design(scene: tuple[float, ...], forced: bool) -> Design:
    zeta, r, gamma, clearance, restitution, mass, stiffness, _ = scene
    contact_time = contact_time_of_stiffness(restitution, stiffness, mass)
    particle = with_contact(Particle(clearance, restitution, mass), "compliant", contact_time)
    return Design(zeta, r, gamma, particle, forced)


def assert_yields(found: Simulation, scene: tuple[float, ...], forced: bool) -> None:
    """Assert that a march ends where a plain one ends.

    Both round at 1e-16 of a state of ten, thousands of times, and impacts amplify.
    """
    particle = compliant_design(scene, forced).particle
    plain = compliant_wall.Scene(*scene[:4], particle.mass_ratio, *particle.wall, forced=forced)
    expected, march = compliant_wall.end_state(plain, int(scene[-1]))
    assert march.impacts >= 3
    assert (found.events["impacts"], found.events["turns"]) == (march.impacts, march.turns)
    assert list(found.state.values()) == pytest.approx(expected, rel=0.0, abs=1e-9)
    assert found.metrics["energy_residual"] <= 1e-12
    if forced:
        same = pytest.approx(found.metrics["amplitude_ratio"], rel=1e-12)
        assert found.metrics["relative_amplitude_ratio"] == same


@pytest.mark.night
@pytest.mark.parametrize(
    ("scene", "forced"), [*((one, False) for one in SHAKEN), *((one, True) for one in FORCED)], ids=str
)
def test_compliant_walls_agree_with_a_plain_march(scene: tuple[float, ...], forced: bool) -> None:
    assert_yields(simulate(compliant_design(scene, forced), int(scene[-1])), scene, forced)


def test_contacts_that_take_time_agree_with_other_integrators_in_plain_python() -> None:
    """Held through turns; walls with friction, with chatter, overdamped, and a turn and a stop in contact under a force."""
    walls = [(SHAKEN[place], False) for place in (3, 6, 11)] + [(FORCED[4], True)]
    designs = [
        *((dwelling_design(scene), 6) for scene in DWELLS[2:]),
        *((compliant_design(*wall), int(wall[0][-1])) for wall in walls),
    ]
    found = plainly(simulate_ready, designs)
    for one, scene in zip(found, DWELLS[2:], strict=False):
        assert_dwells(one, scene)
    for one, wall in zip(found[2:], walls, strict=True):
        assert_yields(one, *wall)


@pytest.mark.parametrize(
    ("friction", "stiffness", "form"),
    [(0.8, 10.0, "plain"), *(night(f, k, "jitted") for f in (0.0, 0.8) for k in (10.0, 1e4))],
)
def test_the_history_in_compliant_walls_is_the_motion(friction: float, stiffness: float, form: str) -> None:
    """Its samples keep momentum in contact, move as their velocities say, and show no force that pulls."""
    contact_time = contact_time_of_stiffness(0.3, stiffness, 0.5)
    particle = with_contact(Particle(0.3, 0.3, 0.5), "compliant", contact_time)
    design = Design(0.0038, 0.9, friction, particle)
    found = simulate(design, 6, 6) if form == "jitted" else plainly(simulate_ready, [(design, 6, 6)])[0]
    time, u, p, v = (found.history[name] for name in ("time", "u", "p", "v"))
    same = np.diff(time) <= 1e-12
    assert same.sum() > 20
    for name in ("u", "u_rate", "v", "v_rate", "p", "p_rate"):
        assert np.abs(np.diff(found.history[name])[same]).max() <= 1e-10, name  # nothing jumps
    assert found.metrics["amplitude_ratio_max"] >= np.abs(u).max() - 1e-12
    beyond = np.abs(u - p) - 0.3
    assert beyond.max() > 1e-5
    assert u[-1] == pytest.approx(found.state["u"], abs=1e-11)
    assert p[-1] == pytest.approx(found.state["p"], abs=1e-11)
    assert np.isfinite(v).all()


@pytest.mark.night
@pytest.mark.parametrize("model", MODELS)
def test_a_study_with_a_contact_time_by_name_answers_as_the_point_alone(model: str) -> None:
    """The presets are the paper's times over 1/ω_n at 2.5 Hz; a particle without mass needs no wall."""
    axes = {
        "clearance_ratio": 2.0,
        "friction_ratio": [0.0, 0.4],
        "restitution": 0.47,
        "mass_ratio": [0.0, 0.1],
        "frequency_ratio": 1.0,
    }
    contact = {"model": model, "contact_time": "paper_soft_real"}
    study = parse_study({"damping_ratio": 0.02, "axes": axes, "contact": contact})
    assert study.document()["contact"]["contact_time"] == pytest.approx(5.0 * pi * 0.02055, rel=1e-15)
    found = solve_block(study, Block.whole(study.shape))
    assert np.isfinite(found["amplitude_ratio"]).all()
    particle = with_contact(Particle(2.0, 0.47, 0.1), model, CONTACT_TIMES["paper_soft_real"].contact_time)
    for friction in (0.0, 0.4):
        alone = simulate(Design(0.02, 1.0, friction, particle)).metrics
        assert alone["amplitude_ratio"] in found["amplitude_ratio"]
        assert alone["energy_residual"] in found["energy_residual"]
    assert found["energy_residual"].max() <= 1e-11
    assert set(found["status"].flat) <= {Status.CONVERGED, Status.MAX_CYCLES}


@pytest.mark.parametrize("model", MODELS)
def test_fixed_steps_refuse_a_contact_that_takes_time(model: str) -> None:
    with pytest.raises(ValueError, match=r"contact_time|wall"):
        simulate(Design(0.02, 1.0, 0.4, with_contact(Particle(2.0, 0.6, 0.2), model, 0.5)), 2, method="rk4")
