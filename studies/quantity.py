"""The numeric quantities of a study, with bounds and JSON schemas, and the reading of numbers from documents."""

from dataclasses import dataclass
from math import isnan
from typing import Any

from damperlab.studies.faults import Fault, StudyFaults, describe
from damperlab.studies.spelled_numbers import number_advice


@dataclass(frozen=True)
class Quantity:
    """A real quantity with a range of allowed numbers.

    Parameters
    ----------
    name : str
        Name in documents.
    meaning : str
        Meaning of the quantity with its symbol, on one line for the schema.
    lowest, highest : float
        Bounds.
    below : bool
        Whether `highest` itself is excluded.
    advice : str
        Advice for a number outside the bounds.
    """

    name: str
    meaning: str
    lowest: float
    highest: float
    advice: str
    below: bool = False

    @property
    def allowed(self) -> str:
        """The bounds in words."""
        if self.below:
            return f"a number of at least {self.lowest:g} and below {self.highest:g}"
        return f"a number from {self.lowest:g} to {self.highest:g}"

    @property
    def unit(self) -> str:
        """The unit in brackets at the end of the text `meaning`; empty for a ratio."""
        return self.meaning[self.meaning.rindex("[") + 1 : -1] if self.meaning.endswith("]") else ""

    def schema(self, default: float | None = None) -> dict[str, Any]:
        """Return the JSON schema of the quantity. A default of None or NaN is omitted."""
        found: dict[str, Any] = {"type": "number", "description": self.meaning, "minimum": self.lowest}
        found["exclusiveMaximum" if self.below else "maximum"] = self.highest
        if default is not None and not isnan(default):
            found["default"] = default
        return found

    def admits(self, value: float) -> bool:
        """Return whether a number is within the bounds; False for NaN."""
        return self.lowest <= value <= self.highest and not (self.below and value == self.highest)

    def read(self, raw: object, field: str = "") -> float:
        """Read one number.

        Raises
        ------
        StudyFaults
            If `raw` is not a number or is out of bounds. Booleans and texts are not numbers.
        """
        if isinstance(raw, bool) or not isinstance(raw, int | float):
            raise StudyFaults([Fault(field, describe(raw), self.allowed, number_advice(raw, self.unit))])
        # The bounds are checked before the conversion, because an integer may be too large for a float.
        if not self.admits(raw):
            raise StudyFaults([Fault(field, describe(raw), self.allowed, self.advice)])
        return float(raw) + 0.0  # -0.0 becomes 0.0: both are the same number


def read_count(raw: object, lowest: int, highest: int, field: str = "") -> int:
    """Read a whole number. ``49.0`` is accepted, because JSON does not distinguish it from ``49``.

    Raises
    ------
    StudyFaults
        If `raw` is not a whole number within the bounds.
    """
    allowed = f"a whole number from {lowest:,} to {highest:,}"
    whole = isinstance(raw, int) or (isinstance(raw, float) and raw.is_integer())
    if isinstance(raw, bool) or not isinstance(raw, int | float) or not whole:
        raise StudyFaults([Fault(field, describe(raw), allowed, "write a whole number")])
    if not lowest <= raw <= highest:
        raise StudyFaults([Fault(field, describe(raw), allowed, "choose a number within these bounds")])
    return int(raw)


# Within these bounds every product is finite and far from underflow.
# The values of real dampers are well inside the bounds.
DAMPING_RATIO = Quantity(
    "damping_ratio", "structural damping ratio ζ = c/(2√(kM))", 0.0, 1.0,
    "the structure must be underdamped; the paper's has 0.0038", below=True,
)  # fmt: skip
RESTITUTION = Quantity(
    "restitution",
    "coefficient of restitution e",
    0.0,
    1.0,
    "with 0 the particle stays at the wall, with 1 an impact loses no energy",
)
MASS_RATIO = Quantity("mass_ratio", "mass ratio β = m/M", 0.0, 1e12, "give particle mass over primary mass")
CLEARANCE_RATIO = Quantity(
    "clearance_ratio", "clearance ratio d/Z", 1e-12, 1e12,
    "give half the free cavity length over the base amplitude, or write `particle: false`",
)  # fmt: skip
FRICTION_RATIO = Quantity(
    "friction_ratio", "friction ratio γ_F = F_f/(kZ)", 0.0, 1e12, "give 0 for a structure without friction"
)
# Outside these bounds the periods of structure and excitation differ by a factor above 10^4.
# The response is then quasi-static or isolated, and the closed forms lose digits in their smaller term.
FREQUENCY_RATIO = Quantity(
    "frequency_ratio",
    "frequency ratio r = ω/ω_n",
    1e-4,
    1e4,
    "give excitation over natural frequency; 1 is resonance",
)
PARTICLE_FRICTION = Quantity(
    "particle_friction_coefficient",
    "coefficient μ_i of sliding friction between particle and cavity",
    0.0,
    1e6,
    "give 0 for a particle that slides freely; steel on steel has 0.1 to 0.5, a ball that rolls 0.001 to 0.02",
)
TILT = Quantity(
    "tilt_deg",
    "tilt α of the cavity [°]: 0 is horizontal, 90 is vertical",
    0.0,
    90.0,
    "give it in degrees",
)
OF_CAVITY = (PARTICLE_FRICTION, TILT)
"""The quantities of a cavity, in the order of the corresponding ratios in `BEFORE`."""
CAVITY_NAMES = {
    PARTICLE_FRICTION.name: ("friction coefficient of the particle", "μ_i", "1"),
    TILT.name: ("tilt of the cavity", "α", "degree"),
}
"""Words, symbol and CF unit of each quantity of a cavity. Words and symbol form the long name."""
PARTICLE_FRICTION_RATIO = Quantity(
    "particle_friction_ratio",
    "friction of the particle κ = μ_i g/(ω_n²·Z)",
    0.0,
    1e12,
    "give 0 for a particle that slides freely",
)
GRAVITY_RATIO = Quantity(
    "gravity_ratio",
    "gravity along the cavity G = g·sin α/(ω_n²·Z), towards negative u",
    0.0,
    1e12,
    "give 0 for a horizontal cavity",
)
RATIOS: dict[str, Quantity] = {
    q.name: q
    for q in (DAMPING_RATIO, RESTITUTION, MASS_RATIO, CLEARANCE_RATIO, FRICTION_RATIO, FREQUENCY_RATIO)
}
"""The quantities of the six dimensions of a cube, in the order of the cube."""
QUANTITY_OF = RATIOS | {each.name: each for each in (PARTICLE_FRICTION_RATIO, GRAVITY_RATIO)}
"""The quantity of every dimension that a cube may have."""
