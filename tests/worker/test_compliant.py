"""The contact model `compliant`: its calibration, against a plain march, in its limit, by its balances."""

from dataclasses import replace
from math import inf, pi

import numpy as np
import pytest
from tests.oracles.compliant_wall import Scene, end_state

from damperlab.studies.definition import parse_study
from damperlab.studies.faults import StudyFaults
from damperlab.studies.plan import Block
from damperlab.studies.variables import Status
from damperlab.worker.block import solve_block
from damperlab.worker.physics.compliant_wall import (
    contact_time_of_stiffness,
    wall_constants,
)
from damperlab.worker.point import Design
from damperlab.worker.simulate import simulate
from damperlab.worker.solver.particle import Particle, Wall


def particle_of(
    clearance: float,
    restitution: float,
    mass: float,
    contact_time: float | None = None,
    stiffness: float = inf,
) -> Particle:
    """A particle between compliant walls of a contact time, or else of a stiffness over k."""
    if contact_time is None:
        contact_time = contact_time_of_stiffness(restitution, stiffness, mass)
    return Particle(
        clearance, restitution, mass, None, Wall(*wall_constants(restitution, contact_time, mass))
    )


# ζ, r, γ_F, d/Z, e, β, K/k, cycles: impacts alone; with friction; chatter, rest on the wall and stick; turns and stops in
# contact; without loss; overdamped; so much that its rates are far apart, both fast
SCENES = [
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


@pytest.mark.parametrize(
    "scene",
    [one if one[2] > 0.0 else pytest.param(one, marks=pytest.mark.night) for one in SCENES],
    ids=str,
)
def test_end_state_agrees_with_a_plain_march(scene: tuple[float, ...]) -> None:
    """Both round at 1e-16 of a state of ten, thousands of times, and impacts amplify."""
    zeta, r, gamma, clearance, restitution, mass, stiffness, cycles = scene
    particle = particle_of(clearance, restitution, mass, stiffness=stiffness)
    assert particle.wall is not None
    plain = Scene(zeta, r, gamma, clearance, mass, *particle.wall)
    expected, march = end_state(plain, int(cycles))
    found = simulate(Design(zeta, r, gamma, particle), int(cycles))
    assert march.impacts >= 3
    assert (found.events["impacts"], found.events["turns"]) == (march.impacts, march.turns)
    assert list(found.state.values()) == pytest.approx(expected, rel=0.0, abs=1e-9)
    assert found.metrics["energy_residual"] <= 1e-12


def _difference(design: Design, cycles: int) -> float:
    """Largest difference of the end state from that of the instantaneous law."""
    assert design.particle is not None
    instant = replace(design, particle=design.particle._replace(wall=None))
    ends = (simulate(one, cycles).state.values() for one in (design, instant))
    return max(abs((a or 0.0) - (b or 0.0)) for a, b in zip(*ends, strict=True))


@pytest.mark.parametrize(
    ("friction", "clearance", "restitution", "cycles"),
    [pytest.param(0.0, 2.0, 0.47, 10, marks=pytest.mark.night), (0.4, 5.0, 0.47, 6), (0.8, 0.3, 0.1, 4)],
    ids=["chatter and rest", "friction", "stick and rest"],
)
def test_stiff_walls_tend_to_the_instantaneous_law_with_order_one(
    friction: float, clearance: float, restitution: float, cycles: int
) -> None:
    """Of the contact time, so of stiffness^−½."""
    r = 0.9 if friction == 0.8 else 1.0
    errors = [
        _difference(Design(0.0038, r, friction, particle_of(clearance, restitution, 0.1, time)), cycles)
        for time in (1e-5, 1e-6, 1e-7)
    ]
    assert errors[0] < 1e-3
    assert errors[0] / errors[1] == pytest.approx(10.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(10.0, rel=0.1)


@pytest.mark.parametrize("stiffness", [1.0, 1e2, 1e6, 1e12])
@pytest.mark.parametrize("friction", [pytest.param(0.0, marks=pytest.mark.night), 0.8])
@pytest.mark.parametrize(("clearance", "restitution"), [(10.0, 0.47), (0.3, 0.47), (0.5, 0.01), (2.0, 1.0)])
def test_energy_balances(friction: float, clearance: float, restitution: float, stiffness: float) -> None:
    design = Design(0.0038, 0.9, friction, particle_of(clearance, restitution, 0.1, stiffness=stiffness))
    found = simulate(design, 20).metrics
    assert found["status"] == Status.MAX_CYCLES
    assert found["energy_residual"] <= 1e-11


@pytest.mark.parametrize("stiffness", [10.0, 1e4])
@pytest.mark.parametrize("friction", [pytest.param(0.0, marks=pytest.mark.night), 0.8])
def test_history_is_the_motion(friction: float, stiffness: float) -> None:
    """Its samples keep momentum in contact, move as their velocities say, and show no force that pulls."""
    design = Design(0.0038, 0.9, friction, particle_of(0.3, 0.3, 0.5, stiffness=stiffness))
    assert design.particle is not None
    found = simulate(design, 6, history=6)
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
def test_steady_response_in_a_study_is_that_of_the_point_alone() -> None:
    document = {
        "damping_ratio": 0.02,
        "axes": {
            "clearance_ratio": 2.0,
            "friction_ratio": [0.0, 0.4],
            "restitution": 0.47,
            "frequency_ratio": 1.0,
        },
        "contact": {"model": "compliant", "contact_time": "paper_soft_real"},
    }
    study = parse_study(document)
    found = solve_block(study, Block(0, (0,) * 6, study.shape))
    for i, friction in enumerate((0.0, 0.4)):
        particle = particle_of(2.0, 0.47, 0.1, 5.0 * pi * 0.02055)
        alone = simulate(Design(0.02, 1.0, friction, particle)).metrics
        assert found["amplitude_ratio"].flat[i] == alone["amplitude_ratio"]
        assert found["energy_residual"].flat[i] <= 1e-11
        assert found["status"].flat[i] in (Status.CONVERGED, Status.MAX_CYCLES)


@pytest.mark.night
def test_particle_without_mass_needs_no_wall() -> None:
    document = {
        "axes": {
            "clearance_ratio": 2.0,
            "friction_ratio": 0.4,
            "mass_ratio": [0.0, 0.1],
            "frequency_ratio": 0.9,
        },
        "contact": {"model": "compliant", "contact_time": 0.1},
        "steady": {"max_cycles": 50},
    }
    study = parse_study(document)
    found = solve_block(study, Block(0, (0,) * 6, study.shape))
    assert np.isfinite(found["amplitude_ratio"]).all()


def test_a_wall_without_restitution_is_refused() -> None:
    document = {
        "axes": {
            "clearance_ratio": 2.0,
            "friction_ratio": 0.4,
            "restitution": [0.0, 0.5],
            "frequency_ratio": 1.0,
        },
        "contact": {"model": "compliant", "contact_time": 0.1},
    }
    with pytest.raises(StudyFaults) as caught:
        parse_study(document)
    (fault,) = caught.value.faults
    assert fault.field == "axes.restitution"
    assert "dwell" in fault.advice


def test_fixed_steps_refuse_a_compliant_wall() -> None:
    with pytest.raises(ValueError, match="wall"):
        simulate(Design(0.02, 1.0, 0.0, particle_of(2.0, 0.5, 0.1, 0.1)), 2, method="rk4")
