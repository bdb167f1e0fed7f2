"""Designs by the acceleration of the structure: brute force point by point, equations of motion, and what studies are asked."""

import json
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.studies.design.test_design import pursued

from damperlab.service.design_report import design_report
from damperlab.service.figures.design import draw_amplitudes
from damperlab.studies.design.absorber import tuned_beside
from damperlab.studies.design.answer import answer_document
from damperlab.studies.design.book import Book
from damperlab.studies.design.found import Found
from damperlab.studies.specification.reading import parse_specification
from damperlab.worker.solver.particle import Particle
from damperlab.worker.steady.settle import Settings, settle
from damperlab.worker.steady.start import at_rest

MASS, NATURAL, ZETA = 40.0, 8.0, 0.03
LOW, HIGH, BASE = 7.0, 9.5, 0.001
OMEGA = 2.0 * np.pi * NATURAL
FLOOR: dict[str, Any] = {
    "name": "floor",
    "structure": {"mass_kg": MASS, "natural_frequency_hz": NATURAL, "damping_ratio": ZETA},
    "excitation": {"base_amplitude_m": BASE, "frequency_hz": {"start": LOW, "stop": HIGH}},
    "choose": {"clearance_m": {"start": 0.002, "stop": 0.012}},
    "friction_force_n": 20.0,
    "particle_mass_kg": 4.0,
    "restitution": 0.5,
    "measure": "worst_acceleration",
    "limits": {"rms_acceleration_m_per_s2": 40.0},
    "builds": 0,
}


def accelerations(clearance_m: float, hertz: float) -> tuple[float, float]:
    """Largest and rms acceleration [m/s²] of a damper by the solver alone, from metres and newtons."""
    friction, particle = 20.0 / (MASS * OMEGA**2 * BASE), Particle(clearance_m / BASE, 0.5, 0.1)
    r = hertz / NATURAL
    settings = Settings(4000, 0.02, 1e-9, True, True)
    response, _ = settle(ZETA, r, friction, particle, settings, at_rest(r, friction, particle))
    unit = BASE * OMEGA**2
    return unit * response.acceleration_ratio, unit * response.acceleration_ratio_rms / np.sqrt(2.0)


@pytest.fixture(scope="module")
def floor() -> tuple[Found, dict[str, xr.Dataset]]:
    return pursued(FLOOR)


@pytest.mark.night
def test_the_stated_worst_case_is_that_of_brute_force(floor) -> None:
    """Responses that do not repeat are known to 2 %, one standard error; 51 frequencies may miss the top of a peak."""
    found, _ = floor
    every = [accelerations(found.build.clearance_m, hertz) for hertz in np.linspace(LOW, HIGH, 51)]
    worst = max(peak for peak, _ in every)
    assert worst <= 1.02 * found.stated.most
    assert worst >= 0.95 * found.stated.value
    assert max(rms for _, rms in every) == pytest.approx(
        found.stated.reached["rms_acceleration_m_per_s2"], rel=0.05
    )
    # it is not the displacement times the square of the frequency
    assert found.asked.unit == "m/s²"


@pytest.mark.night
def test_no_clearance_of_a_grid_is_better(floor) -> None:
    found, _ = floor
    hertz = np.linspace(LOW, HIGH, 21)
    for clearance in np.geomspace(0.002, 0.012, 6):
        assert max(accelerations(clearance, at)[0] for at in hertz) >= 0.95 * found.compared.value


@pytest.mark.night
def test_studies_are_asked_for_the_acceleration_where_it_is_judged(floor) -> None:
    _, cubes = floor
    for cube in cubes.values():
        assert {"acceleration_ratio", "acceleration_ratio_rms"} <= set(
            json.loads(cube.attrs["study"])["metrics"]
        )
    plain = {key: value for key, value in FLOOR.items() if key not in ("measure", "limits")}
    asked = (
        parse_specification(plain),
        parse_specification(plain | {"limits": {"acceleration_m_per_s2": 9.0}}),
    )
    assert [sum("acceleration" in name for name in Book(one, 10).variables) for one in asked] == [0, 1]


@pytest.mark.night
def test_the_answer_is_in_metres_per_second_squared(floor) -> None:
    found, _ = floor
    document = answer_document(found)
    json.dumps(document, allow_nan=False)
    assert (document["worst"]["measure"], document["worst"]["units"]) == ("worst_acceleration", "m/s²")
    # as a limit in ratios is: over the base amplitude and the square of the natural frequency
    assert document["worst"]["ratio"] * BASE * OMEGA**2 == pytest.approx(found.stated.value, rel=1e-12)
    assert "acceleration of the structure" in " ".join(document["words"])
    assert draw_amplitudes(found).axes[0].get_ylabel() == "Response over base amplitude times $ω_n^2$"
    assert "m/s²" in design_report(found)


@pytest.mark.parametrize(
    "motion",
    [
        {"base_amplitude_m": BASE},
        pytest.param({"base_velocity_m_per_s": 0.05}, marks=pytest.mark.night),
        pytest.param({"base_acceleration_m_per_s2": 2.5}, marks=pytest.mark.night),
        pytest.param({"force_n": 40.0}, marks=pytest.mark.night),
    ],
    ids=lambda motion: next(iter(motion)),
)
@pytest.mark.parametrize(
    ("measure", "judge"),
    [
        ("worst_acceleration", np.max),
        pytest.param(
            "worst_rms_acceleration", lambda peaks: peaks.max() / np.sqrt(2.0), marks=pytest.mark.night
        ),
        pytest.param(
            "rms_acceleration",
            lambda peaks: np.sqrt(np.trapezoid(peaks**2) / (peaks.size - 1) / 2.0),
            marks=pytest.mark.night,
        ),
    ],
)
def test_the_tuned_mass_damper_accelerates_as_its_equations_of_motion_say(
    motion: dict[str, float], measure: str, judge: Callable[[np.ndarray], float]
) -> None:
    """Both in kilograms and newtons, at the ends of the mass's tolerance and 81 natural frequencies within theirs."""
    document = FLOOR | {"measure": measure, "limits": {}}
    document |= {
        "excitation": {**motion, "frequency_hz": {"start": LOW, "stop": HIGH}},
        "tolerances": {"mass_kg": "3%", "natural_frequency_hz": "2%"},
    }
    beside = tuned_beside(parse_specification(document), 0.1)
    assert beside is not None
    own, small = OMEGA * beside.absorber.tuning, beside.absorber.mass_ratio * MASS

    def peak(mass: float, speed: float) -> float:
        s = 2j * np.pi * np.linspace(LOW, HIGH, 4001)
        link = small * (own**2 + 2.0 * beside.absorber.damping_ratio * own * s)
        through = mass * (2.0 * ZETA * speed * s + speed**2)
        key, size = next(iter(motion.items()))
        order = {"base_amplitude_m": 0, "base_velocity_m_per_s": 1, "base_acceleration_m_per_s2": 2}
        force = size if key == "force_n" else through * size / s ** order[key]
        dynamic = mass * s**2 + through + link - link**2 / (small * s**2 + link)
        return float(judge(np.abs(s**2 * force / dynamic)))

    truth = [peak(a * MASS, b * OMEGA) for a in (1.0, 0.97, 1.03) for b in np.linspace(0.98, 1.02, 81)]
    assert beside.nominal == pytest.approx(peak(MASS, OMEGA), rel=1e-5)
    assert (1.0 - 1e-5) * max(truth) <= beside.value <= (1.0 + 1e-4) * max(truth)


def test_in_ratios_it_is_over_the_base_amplitude_times_the_square_of_the_natural_frequency() -> None:
    ratios = {
        "structure": {"damping_ratio": ZETA},
        "excitation": {"frequency_ratio": {"start": LOW / NATURAL, "stop": HIGH / NATURAL}},
        "choose": {"friction_ratio": {"start": 0.1, "stop": 0.5}},
        "mass_ratio": 0.0,
        "clearance_ratio": 1.0,
        "restitution": 0.5,
        "measure": "worst_acceleration",
        "builds": 0,
    }
    found, _ = pursued(ratios)
    friction = found.build.friction_force_n
    assert found.stated.value == pytest.approx(
        max(
            settle(
                ZETA, r, friction, None, Settings(4000, 0.02, 1e-9, True, True), at_rest(r, friction, None)
            )[0].acceleration_ratio
            for r in np.linspace(LOW / NATURAL, HIGH / NATURAL, 101)
        ),
        rel=0.01,
    )
    assert "times the base amplitude times ω_n²" in " ".join(answer_document(found)["words"])
