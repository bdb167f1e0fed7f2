"""Shocks: their shapes, the shock spectrum of a half sine against its closed form, and what is refused."""

import math
from typing import Any

import numpy as np
import pytest
from tests.studies.documents import fields_of

from damperlab.studies.ground.generated import GENERATED
from damperlab.studies.ground.motion import STANDARD_GRAVITY
from damperlab.studies.ground.shelf import Shelf
from damperlab.studies.ground.shock import Shock, shock_of
from damperlab.studies.ground.source import read_source
from damperlab.worker.ground.response_spectrum import response_spectrum

HALF_SINE: dict[str, Any] = {"shape": "half_sine", "peak_g": 15, "duration_ms": 11}
SAMPLES = 50


@pytest.mark.parametrize(
    ("shape", "share"), [("half_sine", 2 / math.pi), ("sawtooth", 0.5), ("trapezoid", 0.9)]
)
def test_a_pulse_changes_the_velocity_as_its_shape_does(shape: str, share: float) -> None:
    """A half sine by straight lines loses (π/50)²/12 of its area; a sawtooth that falls over its last sample has all of it."""
    motion = GENERATED["shock"](HALF_SINE | {"shape": shape, "rest_s": 0.05})
    velocity, _ = motion.base_motion()
    change = 15 * STANDARD_GRAVITY * 0.011 * share
    assert velocity[-1] == pytest.approx(change, rel=4e-4 if shape == "half_sine" else 1e-12)
    assert motion.peak_m_s2 == pytest.approx(15 * STANDARD_GRAVITY, rel=1e-12)
    assert motion.step_s * SAMPLES == pytest.approx(0.011)
    assert motion.duration_s >= 0.011 + 0.05 - 1e-12
    assert not motion.acceleration_m_s2[SAMPLES + 1 :].any()


def half_sine_spectrum(ratio: float) -> float:
    """Largest ω²|x − z| over the peak of a half sine whose half period is `ratio` natural periods; no damping.

    With β = π/(ωD): (sin πt/D − β sin ωt)/(1 − β²) while it lasts, whose rate vanishes at t = 2πj/(ω ± π/D), and free
    vibration with 2β cos(π/(2β))/(1 − β²) after it. J. M. Biggs, Introduction to Structural Dynamics (1964).
    """
    beta = 1.0 / (2.0 * ratio)
    omega = 1.0 / beta
    times = [
        2 * math.pi * j / (omega + sign) for j in range(1, int(omega) + 3) for sign in (1, -1) if omega != 1
    ]
    during = [abs(math.sin(t) - beta * math.sin(omega * t)) for t in times if 0 < t < math.pi]
    return max([*during, abs(2 * beta * math.cos(math.pi / (2 * beta)))]) / abs(1 - beta**2)


def test_the_shock_spectrum_of_a_half_sine_is_its_closed_form() -> None:
    """The straight lines miss the half sine by no more than 4.9e-4 of its peak, and by 3.3e-4 of its area."""
    ratios = np.array([0.1, 0.23, 0.4, 0.7, 0.81, 1.1, 1.7, 2.9, 4.3])
    motion = GENERATED["shock"](HALF_SINE | {"rest_s": 0.2})
    spectrum = response_spectrum(motion, 0.011 / ratios, 0.0)
    found = spectrum.pseudo_acceleration_m_s2 / (15 * STANDARD_GRAVITY)
    np.testing.assert_allclose(found, [half_sine_spectrum(ratio) for ratio in ratios], rtol=6e-4)
    # the largest value of the curve that every book draws
    assert max(half_sine_spectrum(ratio) for ratio in np.linspace(0.5, 1.2, 701) + 1e-4) == pytest.approx(
        1.768, abs=1e-3
    )


def test_a_shock_is_called_what_it_is() -> None:
    source, motion = read_source({"shock": HALF_SINE}, Shelf.none())
    assert source.called == motion.name == "half-sine shock of 15 g and 11 ms"
    assert shock_of(HALF_SINE).words_at(0.5) == "under a half-sine shock of 7.5 g and 11 ms"
    assert shock_of(HALF_SINE) == Shock("half_sine", 15.0, 11.0, 2.0)
    assert read_source(source.document(), None)[0] == source


@pytest.mark.parametrize(
    ("document", "fields"),
    [
        ({}, ["peak_g", "duration_ms", "shape"]),
        ({"shape": "half-sine", "peak_g": 0, "duration_ms": 0.1, "rest_s": -1, "name": 3},
         ["peak_g", "duration_ms", "rest_s", "name", "shape"]),
        (HALF_SINE | {"peak_m_s2": 3}, ["peak_m_s2"]),
        (HALF_SINE | {"rest_s": 100}, ["rest_s"]),
        (HALF_SINE | {"seeds": 3}, ["seeds"]),
    ],
)  # fmt: skip
def test_every_fault_is_said_at_once(document: dict[str, Any], fields: list[str]) -> None:
    assert fields_of(shock_of, document) == [f"shock.{field}" for field in fields]
