"""Outcomes of fits, written down for tests of what is made of them."""

from typing import Any

import numpy as np

from damperlab.studies.fit.asking import make_question
from damperlab.studies.fit.fitted import Estimate
from damperlab.studies.fit.history.asking import make_history_question
from damperlab.studies.fit.history.history import History
from damperlab.studies.fit.history.question import HistoryQuestion
from damperlab.studies.fit.measured import parse_measurement
from damperlab.studies.fit.question import FitQuestion

BENCH: dict[str, Any] = {
    "damping_ratio": 0.0038,
    "axes": {"restitution": 0.47},
    "physical": {
        "mass_kg": 1.605,
        "natural_frequency_hz": 2.5,
        "base_amplitude_m": 0.0015,
        "particle_mass_kg": 0.1605,
        "clearance_m": 0.015,
        "friction_force_n": 0.2,
    },
}
"""A prototype of which everything is known."""
TABLE = "frequency (Hz), amplitude (mm)\n2.4, 9\n2.5, 12\n2.55, 10\n2.6, 8\n2.7, 7\n"
IN_RATIOS: dict[str, Any] = {
    "damping_ratio": 0.0038,
    "axes": {"restitution": 0.47, "mass_ratio": 0.1, "clearance_ratio": 10, "friction_ratio": 0.3},
}
RATIO_TABLE = "r, X/Z\n0.9, 9\n1, 12\n1.1, 8\n1.2, 7\n"


def estimate(name: str, value: float, low: float, high: float, *, determined: bool = True) -> Estimate:
    """Give a parameter with its interval."""
    share = (0.4, 0.6) if determined else (0.0, 1.0)
    return Estimate(name, value, low, high, 0.25 * (high - low), low / 2, 2 * high, *share)


def response(structure: dict[str, Any] = BENCH, table: str = TABLE, **fit: Any) -> FitQuestion:
    """Ask a frequency response."""
    return make_question(parse_measurement(table), structure, fit)


def history(structure: dict[str, Any], *, shaken: bool = False, **fit: Any) -> HistoryQuestion:
    """Ask a history that begins at 20 mm, or one that is shaken by at most 0.5 m/s²."""
    time = 0.01 * np.arange(200)
    base = 0.5 * np.sin(2 * np.pi * 2.4 * time) if shaken else None
    moved = 0.02 * np.cos(2 * np.pi * 2.5 * time) * np.exp(-time)
    return make_history_question(History("decay", 0.01, moved, True, base), structure, fit)
