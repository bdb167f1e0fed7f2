"""Shocks according to IEC 60068-2-27: one pulse of the base acceleration, followed by rest."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from damperlab.studies.faults import NOTHING, Fault, StudyFaults, describe, listing, write_nearest
from damperlab.studies.ground.motion import STANDARD_GRAVITY, GroundMotion
from damperlab.studies.ground.recipe import read_numbers, schema_of, too_many_samples
from damperlab.studies.portable import sin
from damperlab.studies.quantity import Quantity

PLACE = "shock"
SHAPES = {"half_sine": "half-sine", "sawtooth": "terminal-peak sawtooth", "trapezoid": "trapezoidal"}
"""Adjective for each pulse shape of IEC 60068-2-27."""
NUMBERS: dict[str, tuple[Quantity, float | None]] = {
    name: (Quantity(name, meaning, low, high, advice), default)
    for name, meaning, low, high, advice, default in (
        ("peak_g", "largest acceleration [g]", 1e-6, 1000.0, "give it in g", None),
        ("duration_ms", "duration of the pulse [ms]", 0.5, 1000.0, "give it in ms", None),
        ("rest_s", "rest after the pulse [s]", 0.0, 1000.0, "some natural periods are enough", 2.0),
    )
}
SAMPLES_PER_PULSE = 50
"""Number of samples per pulse. Linear interpolation deviates from a half sine by at most (π/50)²/8 = 4.9e-4 of the
peak; the other shapes consist of straight lines.
"""
RISE = 0.1
"""Rise time of a trapezoid, as a fraction of the pulse duration. The fall takes the same time."""


@dataclass(frozen=True)
class Shock:
    """A pulse of the base acceleration.

    Parameters
    ----------
    shape : str
        One of `SHAPES`. A sawtooth falls within the last fiftieth of its duration. The area of the pulse equals that of
        an ideal sawtooth.
    peak_g : float
        Largest acceleration [g].
    duration_ms : float
        Duration of the pulse [ms].
    rest_s : float
        Duration of the zero acceleration after the pulse [s], in which the base keeps its final velocity.
    """

    shape: str
    peak_g: float
    duration_ms: float
    rest_s: float

    noun = "shock"
    shorter = "shorten `rest_s`"

    @property
    def step_s(self) -> float:
        """Time between samples [s]."""
        return 1e-3 * self.duration_ms / SAMPLES_PER_PULSE

    @property
    def samples(self) -> int:
        """Number of samples: those of the pulse, then at least one sample of zero acceleration."""
        return SAMPLES_PER_PULSE + 1 + max(1, math.ceil(self.rest_s / self.step_s))

    def motion(self, name: str = "") -> GroundMotion:
        """Return the record of the shock."""
        share = np.arange(SAMPLES_PER_PULSE + 1) / SAMPLES_PER_PULSE
        if self.shape == "half_sine":
            pulse = sin(math.pi * share)
            pulse[-1] = 0.0
        elif self.shape == "sawtooth":
            pulse = share / share[-2]
            pulse[-1] = 0.0
        else:
            pulse = np.minimum(1.0, np.minimum(share, share[::-1]) / RISE)
        acceleration = np.zeros(self.samples)
        acceleration[: share.size] = self.peak_g * STANDARD_GRAVITY * pulse
        told = self.name
        return GroundMotion(name or told, self.step_s, acceleration, f"{told[:1].upper()}{told[1:]}")

    @property
    def name(self) -> str:
        """Name of the record."""
        return self._told(1.0)

    def words_at(self, scale: float) -> str:
        """Return a phrase for the base motion multiplied by `scale`."""
        return f"under a {self._told(scale)}"

    def _told(self, scale: float) -> str:
        return f"{SHAPES[self.shape]} shock of {scale * self.peak_g:.4g} g and {self.duration_ms:.4g} ms"


def shock_of(document: object) -> Shock:
    """Read a shock from a document with ``shape``, ``peak_g``, ``duration_ms``, and optionally ``rest_s`` and ``name``.

    Raises
    ------
    StudyFaults
        If the document is invalid; the exception lists every fault.
    """
    example = '{"shape": "half_sine", "peak_g": 15, "duration_ms": 11}'
    given, found, faults = read_numbers(document, PLACE, NUMBERS, ("shape",), example)
    shape = given.get("shape")
    if not isinstance(shape, str) or shape not in SHAPES:
        words = describe(shape) if "shape" in given else NOTHING
        faults.append(
            Fault(f"{PLACE}.shape", words, f"one of {listing(SHAPES)}", write_nearest(shape, SHAPES))
        )
    if faults:
        raise StudyFaults(faults)
    shock = Shock(str(shape), **found)
    why = f"{SAMPLES_PER_PULSE} in the pulse, and the rest after it with the same time step"
    faults = too_many_samples(f"{PLACE}.rest_s", shock.samples, why, shock.shorter)
    if faults:
        raise StudyFaults(faults)
    return shock


def shock_schema() -> dict[str, Any]:
    """Return the JSON schema of a shock."""
    told = "A pulse of the base acceleration by IEC 60068-2-27, and rest after it."
    return schema_of(told, NUMBERS, {"shape": {"type": "string", "enum": list(SHAPES)}}, ("shape",))
