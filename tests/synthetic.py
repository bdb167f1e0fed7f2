"""Measurements made up from prototypes that are drawn: the truth behind them is known."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from damperlab.studies.fit.asking import make_question
from damperlab.studies.fit.measured import Measurement
from damperlab.studies.fit.question import FitQuestion
from damperlab.worker.fit.model import responses_at

NOISE = 0.03
"""Standard deviation of the made-up amplitudes over the true ones."""
FINE = {"max_cycles": 20_000, "tolerance": 5e-3}
"""The truth is computed longer than the fit computes its responses."""

RANGES: dict[str, dict[str, tuple[float, float]]] = {
    "friction": {"friction_ratio": (0.0, 1.2), "damping_ratio": (0.0, 0.05)},
    "particle": {"clearance_ratio": (1.0, 25.0), "restitution": (0.0, 1.0)},
    "hybrid": {"friction_ratio": (0.0, 0.78), "restitution": (0.0, 1.0), "clearance_ratio": (1.0, 20.0)},
}
"""What is estimated of each kind of prototype, and where."""


@dataclass(frozen=True)
class Made:
    """A made-up measurement: what is asked of it, and the truth."""

    question: FitQuestion
    truth: dict[str, float]


def made(kind: str, seed: int, rows: int = 25, noise: float = NOISE) -> Made:
    """Draw a prototype of a kind and its measurement, with normal noise in proportion to the amplitude."""
    rng = np.random.default_rng([seed, len(kind)])
    truth: dict[str, float] = {}
    structure: dict[str, Any] = {
        "damping_ratio": float(rng.uniform(0.003, 0.02)),
        "axes": {"mass_ratio": 0.1},
    }
    if kind == "friction":
        truth = {
            "friction_ratio": float(rng.uniform(0.3, 0.75)),
            "damping_ratio": structure.pop("damping_ratio"),
        }
        structure["particle"] = False
    else:
        truth["clearance_ratio"] = float(rng.uniform(3.0, 12.0))
        truth["restitution"] = float(rng.uniform(0.2, 0.85))
        if kind == "hybrid":
            truth["friction_ratio"] = float(rng.uniform(0.1, 0.6))
        else:
            structure["axes"]["friction_ratio"] = 0.0
    frequency = np.linspace(0.85, 1.2, rows)
    columns = {"frequency_ratio": frequency, "amplitude_ratio": np.ones(rows)}
    fit: dict[str, Any] = dict(RANGES[kind])
    blank = make_question(Measurement(kind, columns), structure | {"steady": FINE}, fit)
    true = responses_at(blank, truth).amplitude
    measured = true * (1.0 + noise * rng.standard_normal(rows))
    measurement = Measurement(f"{kind} {seed}", columns | {"amplitude_ratio": measured}, noise * true)
    return Made(make_question(measurement, structure, fit), truth)
