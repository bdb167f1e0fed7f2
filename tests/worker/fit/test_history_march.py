"""Displacements at the samples of a time history, against closed forms."""

from typing import Any

import numpy as np
import pytest

from damperlab.studies.fit.history.asking import make_history_question
from damperlab.studies.fit.history.history import History
from damperlab.studies.fit.history.question import RELEASE
from damperlab.studies.ground.motion import GroundMotion
from damperlab.worker.fit.history.march import displacement
from damperlab.worker.ground.design import Damper, Structure
from damperlab.worker.ground.response import ground_history

MASS, NATURAL, START = 1.6, 2.5, 0.02
OMEGA = 2.0 * np.pi * NATURAL


def moved(damping: float, force: float, step: float, rows: int, **more: Any) -> np.ndarray:
    structure = {
        "damping_ratio": damping,
        "physical": {"mass_kg": MASS, "natural_frequency_hz": NATURAL, "friction_force_n": force},
        "particle": False,
    } | more
    blank = History("made", step, np.full(rows, START))
    question = make_history_question(blank, structure, {"damping_n_s_per_m": (0.0, 1.0)})
    return displacement(question, {"damping_n_s_per_m": 2.0 * MASS * OMEGA * damping, RELEASE: START})


@pytest.mark.parametrize("step", [0.0045, 0.04])
def test_a_linear_structure_decays_as_its_closed_form(step: float) -> None:
    zeta, rows = 0.02, 200
    t = step * np.arange(rows)
    own = OMEGA * np.sqrt(1.0 - zeta**2)
    exact = START * np.exp(-zeta * OMEGA * t) * (np.cos(own * t) + zeta * OMEGA / own * np.sin(own * t))
    # rounding of some 200 windows
    assert np.abs(moved(zeta, 0.0, step, rows) - exact).max() < 1e-12 * START


def test_friction_takes_four_times_its_static_way_from_every_period_and_then_holds() -> None:
    force, samples = 0.2, 40
    lost = 4.0 * force / (MASS * OMEGA**2)
    found = moved(0.0, force, 1.0 / (NATURAL * samples), 20 * samples)
    periods = np.arange(int(START / lost))
    assert found[::samples][periods] == pytest.approx(START - lost * periods, abs=1e-12)
    assert np.ptp(found[-5 * samples :]) == 0.0


def test_under_a_base_motion_it_is_the_response_to_a_record() -> None:
    step, rows = 0.01, 600
    acceleration = (
        0.4 * np.sin(2 * np.pi * 2.4 * step * np.arange(rows)) * np.exp(-0.1 * step * np.arange(rows))
    )
    damper = Damper(0.03, 0.16, 0.004, 0.5)
    _, history = ground_history(
        Structure(MASS, NATURAL, 0.01), damper, GroundMotion("made", step, acceleration)
    )
    at = np.searchsorted(history["time_s"], step * np.arange(rows) - 1e-9)
    structure = {
        "damping_ratio": 0.01,
        "axes": {"restitution": 0.5, "mass_ratio": 0.1},
        "physical": {"mass_kg": MASS, "natural_frequency_hz": NATURAL, "friction_force_n": 0.03},
    }
    for relative, name in ((True, "relative_displacement_m"), (False, "absolute_displacement_m")):
        blank = History("made", step, 0.001 * np.arange(rows), relative, acceleration)
        question = make_history_question(blank, structure, {"clearance_m": None})
        found = displacement(question, {"clearance_m": 0.004})
        assert found == pytest.approx(history[name][at], abs=1e-13)


def test_the_first_rows_alone_are_the_same() -> None:
    structure: dict[str, Any] = {
        "damping_ratio": 0.01,
        "axes": {"restitution": 0.5, "mass_ratio": 0.1},
        "physical": {"natural_frequency_hz": NATURAL, "friction_force_n": 0.0},
    }
    question = make_history_question(
        History("made", 0.01, np.full(300, START)), structure, {"clearance_m": (1e-3, 1e-2)}
    )
    values = {"clearance_m": 0.005, RELEASE: START}
    assert np.array_equal(displacement(question, values, 120), displacement(question, values)[:120])
