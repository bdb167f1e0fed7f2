"""Time histories made up from prototypes that are drawn: the truth behind them is known."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from damperlab.studies.fit.history.asking import make_history_question
from damperlab.studies.fit.history.question import RELEASE, History, HistoryQuestion
from damperlab.worker.fit.history.march import displacement

NOISE = 0.01
"""Standard deviation of the made-up displacements over the largest."""
MASS_KG, NATURAL_HZ, RELEASE_M = 1.605, 2.5, 0.02
STEP_S, ROWS = 0.01, 1000
BASE_M, BASE_HZ = 0.0015, 2.4

RANGES: dict[str, dict[str, tuple[float, float]]] = {
    "friction": {"friction_force_n": (0.0, 0.3), "damping_ratio": (0.0, 0.05)},
    "particle": {"clearance_m": (0.001, 0.03), "restitution": (0.0, 1.0)},
    "rubbing": {"clearance_m": (0.001, 0.03), "particle_friction_coefficient": (0.0, 0.5)},
    "hybrid": {"clearance_m": (0.001, 0.03), "restitution": (0.0, 1.0), "friction_force_n": (0.0, 0.3)},
}
"""What is estimated of each kind of prototype, and where."""
TRUE = {
    "friction_force_n": (0.02, 0.12),
    "damping_ratio": (0.003, 0.02),
    "clearance_m": (0.004, 0.015),
    "restitution": (0.2, 0.85),
    "particle_friction_coefficient": (0.01, 0.1),
}
"""Where the truth is drawn."""


@dataclass(frozen=True)
class MadeHistory:
    """A made-up time history: what is asked of it, and the truth."""

    question: HistoryQuestion
    truth: dict[str, float]


def made_history(
    kind: str,
    seed: int,
    rows: int = ROWS,
    *,
    shaken: bool = False,
    given: bool = False,
    noise: float = NOISE,
) -> MadeHistory:
    """Draw a prototype of a kind and its free decay, or its response to a sine that begins at rest, with normal noise."""
    rng = np.random.default_rng([seed, len(kind), shaken])
    truth = {name: float(rng.uniform(*TRUE[name])) for name in RANGES[kind]}
    structure: dict[str, Any] = {"physical": {"mass_kg": MASS_KG, "natural_frequency_hz": NATURAL_HZ}}
    if kind == "friction":
        structure["particle"] = False
    else:
        structure |= {"damping_ratio": 0.0038, "axes": {"mass_ratio": 0.1}}
    if kind in ("particle", "rubbing"):
        structure["physical"]["friction_force_n"] = 0.0
    if kind == "rubbing":
        structure["axes"]["restitution"] = 0.5
    base = None
    if shaken:
        rate = 2.0 * np.pi * BASE_HZ
        base = BASE_M * rate**2 * np.sin(rate * STEP_S * np.arange(rows))
    else:
        truth[RELEASE] = RELEASE_M * float(rng.uniform(0.98, 1.02))
    blank = History(f"{kind} {seed}", STEP_S, np.full(rows, RELEASE_M), True, base)
    exact = displacement(make_history_question(blank, structure, RANGES[kind]), truth)
    deviation = noise * float(np.abs(exact).max())
    moved = exact + deviation * rng.standard_normal(rows)
    measured = replace(blank, displacement_m=moved, deviation_m=np.full(rows, deviation) if given else None)
    return MadeHistory(make_history_question(measured, structure, RANGES[kind]), truth)
