"""Compliant walls under a record, against a plain march, in the limit of the stiff wall, by the balance of energy."""

import numpy as np
import pytest
from tests.oracles.compliant_wall import Recorded, Scene
from tests.worker.ground.test_ground_response import MASS, PAPER, part

from damperlab.studies.choices import CompliantContact, InstantContact
from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.variables import Status
from damperlab.worker.ground.design import Damper, Structure, friction_of, particle_of, scale_of
from damperlab.worker.ground.response import ground_response

pytestmark = pytest.mark.night


def compliant(contact_time: float) -> CompliantContact:
    return CompliantContact(model="compliant", contact_time=contact_time)


# impacts alone; with friction; soft, overdamped and undamped walls; a particle that rests on its wall
# (none grows a difference by more than 10⁵)
DAMPERS = [
    ("loma-prieta-000", 2.0, Damper(0.0, MASS, 0.0225, 0.47, compliant(0.05))),
    ("el-centro-180", 0.0, Damper(0.41, MASS, 0.0075, 0.82, compliant(0.02))),
    ("el-centro-180", 0.0, Damper(0.0, MASS, 0.0075, 0.2, compliant(0.3))),
    ("northridge-090", 2.0, Damper(0.5, MASS, 0.004, 0.05, compliant(0.05))),
    ("san-fernando-164", 2.0, Damper(0.3, 0.4, 0.001, 1e-3, compliant(0.1))),
    ("loma-prieta-000", 2.0, Damper(0.41, MASS, 0.0225, 1.0, compliant(0.1))),
]


@pytest.mark.parametrize(("record_id", "start", "damper"), DAMPERS, ids=str)
def test_a_record_agrees_with_a_plain_march(record_id: str, start: float, damper: Damper) -> None:
    """The march rounds some 10⁴ steps, and impacts amplify; it scans at 1/40 of the fastest rate."""
    motion = part(record_id, start, 4.0)
    scale = scale_of(PAPER, motion, 1.0)
    particle = particle_of(damper, scale)
    scene = Scene(
        PAPER.damping_ratio,
        1.0,
        friction_of(damper, scale) or 0.0,
        particle.clearance_ratio,
        particle.mass_ratio,
        *particle.wall,
    )
    samples = (motion.acceleration_m_s2 / motion.peak_m_s2).tolist()
    march = Recorded(scene, samples, motion.step_s * PAPER.omega)
    march.run()
    found = ground_response(PAPER, damper, motion)
    time = found.duration_s * PAPER.omega
    assert march.impacts >= 4
    assert found.impacts == march.impacts
    ends = found.end_relative_displacement_m / scale.length_m
    assert ends == pytest.approx(march.u - march.start[0], abs=1e-8)
    peak = found.peak_relative_displacement_m / scale.length_m
    # between the parts of a scan a peak of curvature 1 rises by at most (1/80)²/2 of its size
    assert march.peak * (1 - 1e-9) <= peak <= march.peak * (1 + 1e-4)
    peak = found.peak_absolute_acceleration_m_s2 / scale.acceleration_m_s2
    assert march.acceleration_peak * (1 - 1e-9) <= peak <= march.acceleration_peak * (1 + 2e-4)
    rms = found.rms_relative_displacement_m / scale.length_m
    assert rms == pytest.approx((march.square / time) ** 0.5, rel=1e-8)
    rms = found.rms_absolute_acceleration_m_s2 / scale.acceleration_m_s2
    # Simpson's rule on parts of 1/40: (1/40)⁴/180 of the fourth derivative
    assert rms == pytest.approx((march.acceleration_square / time) ** 0.5, rel=1e-7)
    assert found.energy_residual < 1e-11


@pytest.mark.parametrize("contact_time", [1e-8, 1e-5, 1e-3, 0.05, 1.0])
@pytest.mark.parametrize("restitution", [1e-6, 1e-3, 0.2, 0.82, 1.0])
def test_extreme_walls_keep_the_balance(contact_time: float, restitution: float) -> None:
    motion = part("san-fernando-164", 2.0, 6.0)
    for friction, clearance in ((0.0, 0.0075), (0.41, 0.0005)):
        damper = Damper(friction, MASS, clearance, restitution, compliant(contact_time))
        found = ground_response(PAPER, damper, motion)
        assert found.status in (Status.CONVERGED, Status.TOO_MANY_EVENTS)
        if found.status == Status.CONVERGED:
            assert found.energy_residual < 1e-9


@pytest.mark.parametrize(
    ("samples", "damper"),
    [
        (
            np.r_[np.full(30, 0.5), 0.6, np.full(49, 0.5)],
            Damper(2.889, MASS, 1.216e-4, 0.65, compliant(0.18)),
        ),
        (np.r_[0.0, np.full(9, 0.5), 1.0, np.full(5, 0.5)], Damper(16.0, MASS, 4e-5, 0.8, compliant(0.02))),
    ],
    ids=["a pulse within a contact", "a short record"],
)
def test_a_mass_that_is_held_accelerates_with_its_base_through_a_contact(
    samples: np.ndarray, damper: Damper
) -> None:
    """Friction holds it all the time, so its largest acceleration is that of the record, to rounding."""
    motion = GroundMotion("pulse", 0.02, samples)
    found = ground_response(Structure(), damper, motion)
    assert found.stick_fraction == pytest.approx(1.0, abs=1e-12)
    assert found.impacts >= 1
    assert found.peak_absolute_acceleration_m_s2 == pytest.approx(motion.peak_m_s2, rel=1e-14)


def test_a_rebound_that_rounding_would_drown_is_none() -> None:
    motion = part("el-centro-180", 0.0, 1.0)
    particle = particle_of(Damper(0.0, MASS, 0.01, 1e-15, InstantContact()), scale_of(PAPER, motion, 1.0))
    assert particle.restitution == 0.0
