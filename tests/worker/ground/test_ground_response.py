"""Responses to records against independent methods: closed form, SciPy's exponential, bracketing on a dense scan."""

import numpy as np
import pytest
from tests.oracles.rubbing_particle import UnderRecord
from tests.oracles.shaken_ground import Shaken, linear_end
from tests.worker.forms import night
from tests.worker.plain_python import plainly

from damperlab.studies.cavity import Cavity
from damperlab.studies.choices import CompliantContact, InstantContact
from damperlab.studies.ground.builtin import builtin_record
from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.tmd.tunings import den_hartog, exact_hinf
from damperlab.worker.ground.absorber import absorber_history, absorber_response
from damperlab.worker.ground.design import Damper, Structure
from damperlab.worker.ground.response import HISTORY_COLUMNS, ground_history, ground_response

PAPER = Structure()
MASS = 0.1605
NEXT_TO_NOTHING = 1e-12
"""A friction force [N] that changes no digit that is looked at: it calls the kernels of a structure that rubs."""
RUBBING_UNDER_RECORDS = [
    (0, 0.04, 0.0, 1.5, 0.8, 0.015, "jitted"),
    (1, 0.012, 0.0, NEXT_TO_NOTHING, 0.78, 0.015, "jitted"),
    (30, 0.04, 8.0, 1.5, 0.86, 0.017, "plain"),
    night(2, 0.16, 0.0, NEXT_TO_NOTHING, 0.73, 0.013, "jitted"),
    night(30, 0.04, 8.0, 1.5, 0.86, 0.017, "jitted"),
    night(7, 0.05, 3.0, 0.0, 0.8, 0.012, "jitted"),
    night(12, 0.1, 0.0, 0.5, 0.64, 0.01, "jitted"),
]
"""Seed of a record, friction and tilt, damper: none of them chatters. In plain Python, or compiled."""


def part(record_id: str, start_s: float, length_s: float) -> GroundMotion:
    """A stretch of a built-in record."""
    whole = builtin_record(record_id)
    first, count = round(start_s / whole.step_s), round(length_s / whole.step_s)
    return GroundMotion("part", whole.step_s, whole.acceleration_m_s2[first : first + count + 1])


@pytest.mark.parametrize(
    ("record_id", "frequency", "zeta"),
    [("loma-prieta-000", 2.5, 0.0038), ("el-centro-180", 0.3, 0.05), ("northridge-090", 7.0, 0.0)],
)
def test_the_structure_alone_is_exact(record_id: str, frequency: float, zeta: float) -> None:
    motion = part(record_id, 0.0, 16.0)
    structure = Structure(3.0, frequency, zeta)
    truth = linear_end(structure.omega, zeta, motion.acceleration_m_s2, motion.step_s)
    for found in (ground_response(structure, Damper(), motion), absorber_response(structure, None, motion)):
        # the exponential of 3200 steps in doubles: 1e-12 of the peak, an end state is a difference of its size
        assert found.end_relative_displacement_m == pytest.approx(truth["x"], abs=1e-10 * truth["peak"])
        assert found.peak_relative_displacement_m == pytest.approx(truth["peak"], rel=1e-10)
        assert found.peak_absolute_acceleration_m_s2 == pytest.approx(truth["peak_acceleration"], rel=1e-10)
        assert found.energy_residual < 1e-11
        assert found.status == 0


@pytest.mark.parametrize(
    ("absorber", "record_id"),
    [(exact_hinf(0.05), "loma-prieta-090"), (den_hartog(0.1).detuned(0.5, -0.5), "el-centro-270")],
)
def test_a_tuned_mass_damper_is_exact(absorber, record_id: str) -> None:
    motion = part(record_id, 0.0, 12.0)
    truth = linear_end(
        PAPER.omega,
        PAPER.damping_ratio,
        motion.acceleration_m_s2,
        motion.step_s,
        (absorber.mass_ratio, absorber.tuning * PAPER.omega, absorber.damping_ratio),
    )
    found = absorber_response(PAPER, absorber, motion)
    assert found.end_relative_displacement_m == pytest.approx(truth["x"], abs=1e-10 * truth["peak"])
    assert found.peak_relative_displacement_m == pytest.approx(truth["peak"], rel=1e-10)
    assert found.peak_absolute_acceleration_m_s2 == pytest.approx(truth["peak_acceleration"], rel=1e-10)
    assert found.energy_residual < 1e-12


def test_rms_is_the_integral() -> None:
    """Of the closed form, sampled 64 times an interval: Simpson's rule is then exact to 1e-11."""
    motion = part("loma-prieta-000", 2.0, 6.0)
    found = absorber_response(PAPER, den_hartog(0.1), motion)
    fine = GroundMotion(
        "fine",
        motion.step_s / 64,
        np.interp(
            np.arange(64 * (motion.acceleration_m_s2.size - 1) + 1) / 64,
            np.arange(motion.acceleration_m_s2.size),
            motion.acceleration_m_s2,
        ),
    )
    history = absorber_history(PAPER, den_hartog(0.1), fine)
    for name, rms in (
        ("relative_displacement_m", found.rms_relative_displacement_m),
        ("absolute_acceleration_m_s2", found.rms_absolute_acceleration_m_s2),
    ):
        squares = history[name] ** 2
        weights = np.full(squares.size, 2.0)
        weights[1::2], weights[0], weights[-1] = 4.0, 1.0, 1.0
        mean = float(weights @ squares) * fine.step_s / 3 / found.duration_s
        assert rms == pytest.approx(np.sqrt(mean), rel=1e-9)


@pytest.mark.parametrize(
    ("record_id", "start", "friction"),
    [("loma-prieta-000", 2.0, 0.41), ("el-centro-180", 0.0, 2.0), ("northridge-090", 0.0, 0.1)],
)
def test_friction_alone(record_id: str, start: float, friction: float) -> None:
    motion = part(record_id, start, 10.0)
    run = Shaken(PAPER.omega, PAPER.damping_ratio, friction / PAPER.mass_kg, None)
    truth = run.run(motion.acceleration_m_s2, motion.step_s)
    found = ground_response(PAPER, Damper(friction_force_n=friction), motion)
    scale = max(truth.peak_relative_displacement, 1e-6)
    assert found.end_relative_displacement_m == pytest.approx(truth.relative_displacement, abs=1e-9 * scale)
    assert found.peak_relative_displacement_m == pytest.approx(
        truth.peak_relative_displacement, rel=1e-9, abs=1e-18
    )
    assert found.stick_fraction == pytest.approx(truth.stuck / found.duration_s, abs=1e-8)
    assert found.energy_residual < 1e-9


@pytest.mark.parametrize(
    ("record_id", "start", "damper"),
    [
        ("loma-prieta-000", 2.0, Damper(0.0, MASS, 0.0225)),
        ("el-centro-180", 0.0, Damper(0.0, MASS, 0.0075)),
        ("northridge-090", 0.0, Damper(0.0, 0.3, 0.0004, 0.82)),
        ("loma-prieta-000", 2.0, Damper(0.41, MASS, 0.0225)),
        ("el-centro-180", 0.0, Damper(0.61, MASS, 0.0075)),
        ("san-fernando-164", 2.0, Damper(1.5, 0.4, 0.01, 0.0)),
    ],
    ids=str,
)
def test_a_particle_with_and_without_friction(record_id: str, start: float, damper: Damper) -> None:
    motion = part(record_id, start, 4.0)
    particle = (damper.clearance_m, damper.restitution, damper.particle_mass_kg / PAPER.mass_kg)
    run = Shaken(PAPER.omega, PAPER.damping_ratio, damper.friction_force_n / PAPER.mass_kg, particle)
    truth = run.run(motion.acceleration_m_s2, motion.step_s)
    found = ground_response(PAPER, damper, motion)
    assert truth.impacts > 4
    scale = truth.peak_relative_displacement
    assert found.end_relative_displacement_m == pytest.approx(truth.relative_displacement, abs=1e-6 * scale)
    assert found.peak_relative_displacement_m == pytest.approx(truth.peak_relative_displacement, rel=1e-8)
    assert found.impact_speed_max_m_s == pytest.approx(truth.impact_speed_max, rel=1e-7)
    assert found.energy_residual < 1e-9


def test_a_record_scaled_with_clearance_and_force_is_the_same_run() -> None:
    motion = builtin_record("el-centro-180")
    one = ground_response(PAPER, Damper(0.41, MASS, 0.0075), motion)
    two = ground_response(PAPER, Damper(2.0 * 0.41, MASS, 2.0 * 0.0075), motion, 2.0)
    assert two.impacts == one.impacts
    for name, value in one.values().items():
        # 2 in lengths, speeds and accelerations, so 4 in energies; counts, shares and times stay
        factor = (
            4.0 if name.endswith("_j") else 2.0 if name.endswith(("t_m", "_m_s", "_y_m", "_m_s2")) else 1.0
        )
        if name != "energy_residual":
            assert two.values()[name] == pytest.approx(factor * value, rel=1e-12, abs=1e-18), name


SOFT = CompliantContact(model="compliant", contact_time=0.02)


def test_free_vibration_after_the_record_decays_as_it_must() -> None:
    """One period later a free damped oscillator is e^(−ζω T_d) of itself."""
    motion = part("el-centro-180", 0.0, 5.0)
    structure = Structure(1.0, 2.5, 0.02)
    damped = structure.omega * np.sqrt(1 - 0.02**2)
    ends = [ground_response(structure, Damper(), motion, tail_s=tail).values() for tail in (0.0, 0.5)]
    x, v = ends[0]["end_relative_displacement_m"], ends[0]["end_relative_velocity_m_s"]
    t = ends[1]["duration_s"] - ends[0]["duration_s"]
    b = (v + 0.02 * structure.omega * x) / damped
    truth = np.exp(-0.02 * structure.omega * t) * (x * np.cos(damped * t) + b * np.sin(damped * t))
    assert ends[1]["end_relative_displacement_m"] == pytest.approx(truth, abs=1e-12)
    assert t == pytest.approx(0.5, abs=motion.step_s)


def test_friction_that_holds_moves_nothing() -> None:
    motion = builtin_record("northridge-090")
    found = ground_response(PAPER, Damper(friction_force_n=1.01 * PAPER.mass_kg * motion.peak_m_s2), motion)
    assert found.peak_relative_displacement_m == 0.0
    assert found.stick_fraction == pytest.approx(1.0, rel=1e-12)
    assert found.peak_absolute_acceleration_m_s2 == pytest.approx(motion.peak_m_s2, rel=1e-14)


@pytest.mark.parametrize("contact", [InstantContact(), pytest.param(SOFT, marks=pytest.mark.night)], ids=str)
def test_the_history_lies_on_the_response(
    contact: InstantContact | CompliantContact, monkeypatch: pytest.MonkeyPatch
) -> None:
    motion = part("el-centro-180", 0.0, 8.0)
    damper = Damper(0.41, MASS, 0.0075, contact=contact)
    response, history = ground_history(PAPER, damper, motion)
    assert tuple(history) == HISTORY_COLUMNS
    assert response == ground_response(PAPER, damper, motion)
    assert np.all(np.diff(history["time_s"]) >= 0)
    assert np.abs(history["relative_displacement_m"]).max() <= response.peak_relative_displacement_m
    assert np.abs(history["relative_displacement_m"]).max() >= 0.999 * response.peak_relative_displacement_m
    at_samples = np.interp(
        history["time_s"], motion.step_s * np.arange(motion.acceleration_m_s2.size), motion.acceleration_m_s2
    )
    assert history["base_acceleration_m_s2"] == pytest.approx(at_samples, abs=1e-9)
    gap = history["absolute_displacement_m"] - history["particle_displacement_m"]
    presses_into_its_wall = np.abs(gap).max() > damper.clearance_m * (1 + 1e-9)
    assert presses_into_its_wall == (contact == SOFT)
    # it is whole whatever room there was at first
    monkeypatch.setattr("damperlab.worker.ground.response._LOGGED_PER_WINDOW", 0)
    again, whole = ground_history(PAPER, damper, motion)
    assert again == response
    for name, values in history.items():
        assert values.tobytes() == whole[name].tobytes(), name


@pytest.mark.parametrize(
    ("seed", "coefficient", "tilt_deg", "force_n", "restitution", "clearance_m", "form"),
    RUBBING_UNDER_RECORDS,
)
def test_a_particle_that_rubs_or_falls_moves_as_another_integrator_says(
    seed: int,
    coefficient: float,
    tilt_deg: float,
    force_n: float,
    restitution: float,
    clearance_m: float,
    form: str,
) -> None:
    structure = Structure(2.0, 1.5, 0.02)
    noise = np.convolve(np.random.default_rng(seed).normal(size=150), np.ones(5) / 5, "same")
    noise[0] = 0.0
    motion = GroundMotion("noise", 0.02, 3.0 * noise / np.abs(noise).max())
    damper = Damper(force_n, 0.3, clearance_m, restitution, cavity=Cavity(coefficient, tilt_deg))
    asked = structure, damper, motion
    found = ground_response(*asked) if form == "jitted" else plainly(ground_response, [asked])[0]
    length, omega = motion.peak_m_s2 / structure.omega**2, structure.omega
    rubs, falls = damper.cavity.ratios({"natural_frequency_hz": 1.5, "base_amplitude_m": length})
    gamma = force_n / (structure.stiffness_n_per_m * length)
    truth = UnderRecord(
        0.02, 1.0, gamma, clearance_m / length, restitution, 0.15, rubs, falls,
        motion.acceleration_m_s2 / motion.peak_m_s2, motion.step_s * omega,
    )  # fmt: skip
    (u, u_rate, p, _), impacts = truth.run()
    s, s_rate, _ = truth.base(149 * truth.step)
    assert found.impacts == impacts
    assert found.end_relative_displacement_m / length == pytest.approx(u - s, abs=1e-11)
    assert found.end_relative_velocity_m_s / (length * omega) == pytest.approx(u_rate - s_rate, abs=1e-11)
    assert found.energy_residual < 1e-13
    assert found.loss_particle_j > 0.0
    if force_n <= NEXT_TO_NOTHING:
        without = Damper(0.0, 0.3, clearance_m, restitution, cavity=damper.cavity)
        _, history = ground_history(structure, without, motion)
        assert history["particle_displacement_m"][-1] / length == pytest.approx(p, abs=1e-11)


def test_a_carried_particle_is_dead_mass() -> None:
    motion = part("el-centro-180", 0.0, 8.0)
    stuck = Damper(0.4, MASS, 0.005, 0.5, cavity=Cavity(100.0))
    heavy = Structure(PAPER.mass_kg + MASS, 2.5 * np.sqrt(1.605 / 1.7655), 0.0038 * np.sqrt(1.605 / 1.7655))
    found = ground_response(PAPER, stuck, motion)
    dead = ground_response(heavy, Damper(0.4), motion)
    assert found.loss_particle_j == 0.0
    for name in ("peak_relative_displacement_m", "rms_absolute_acceleration_m_s2", "loss_friction_j"):
        assert getattr(found, name) == pytest.approx(getattr(dead, name), rel=1e-9)


def test_the_pull_of_a_sliding_particle_is_in_the_acceleration_that_is_shown() -> None:
    """The pull is 0.49 m/s², more than three times what the steps may be off."""
    motion = part("el-centro-180", 0.0, 8.0)
    found, history = ground_history(PAPER, Damper(0.0, MASS, 0.02, 0.5, cavity=Cavity(0.5)), motion)
    time, rate = history["time_s"], history["relative_velocity_m_s"]
    fine = np.flatnonzero((np.diff(time) > 1e-4) & (rate[1:] * rate[:-1] > 0.0))
    base = history["base_acceleration_m_s2"]
    slope = np.diff(rate)[fine] / np.diff(time)[fine] + (base[fine] + base[fine + 1]) / 2
    shown = (
        history["absolute_acceleration_m_s2"][fine] + history["absolute_acceleration_m_s2"][fine + 1]
    ) / 2
    # impacts jump: most steps have none
    assert np.quantile(np.abs(slope - shown), 0.8) < 0.05 * found.rms_absolute_acceleration_m_s2
