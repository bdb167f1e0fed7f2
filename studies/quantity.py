"""A quantity: a number of a study, its bounds, and how it is read from a document."""

from dataclasses import dataclass
from math import isnan
from typing import Any

from damperlab.studies.faults import Fault, StudyFaults, describe
from damperlab.studies.spelled_numbers import number_advice


@dataclass(frozen=True)
class Quantity:
    """A real quantity and its allowed numbers.

    Parameters
    ----------
    name : str
        Name in documents.
    meaning : str
        One line for the schema, with the symbol.
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
        """The unit at the end of the meaning; empty for a ratio."""
        return self.meaning[self.meaning.rindex("[") + 1 : -1] if self.meaning.endswith("]") else ""

    def schema(self, default: float | None = None) -> dict[str, Any]:
        """JSON schema of one such number. It states no default if there is none, or if it is NaN."""
        found: dict[str, Any] = {"type": "number", "description": self.meaning, "minimum": self.lowest}
        found["exclusiveMaximum" if self.below else "maximum"] = self.highest
        if default is not None and not isnan(default):
            found["default"] = default
        return found

    def admits(self, value: float) -> bool:
        """Whether a number is within the bounds; NaN is not."""
        return self.lowest <= value <= self.highest and not (self.below and value == self.highest)

    def read(self, raw: object, field: str = "") -> float:
        """Read one number.

        Raises
        ------
        StudyFaults
            If `raw` is not a number (booleans and texts are not), or is out of bounds.
        """
        if isinstance(raw, bool) or not isinstance(raw, int | float):
            raise StudyFaults([Fault(field, describe(raw), self.allowed, number_advice(raw, self.unit))])
        # An integer too large for a float is compared unchanged, and never converted.
        if not self.admits(raw):
            raise StudyFaults([Fault(field, describe(raw), self.allowed, self.advice)])
        return float(raw) + 0.0  # -0.0 + 0.0 is 0.0: two spellings of one number


def read_count(raw: object, lowest: int, highest: int, field: str = "") -> int:
    """Read a whole number; ``49.0`` is one, because JSON does not distinguish the two spellings.

    Raises
    ------
    StudyFaults
        If `raw` is no whole number within the bounds.
    """
    allowed = f"a whole number from {lowest:,} to {highest:,}"
    whole = isinstance(raw, int) or (isinstance(raw, float) and raw.is_integer())
    if isinstance(raw, bool) or not isinstance(raw, int | float) or not whole:
        raise StudyFaults([Fault(field, describe(raw), allowed, "write a whole number")])
    if not lowest <= raw <= highest:
        raise StudyFaults([Fault(field, describe(raw), allowed, "choose a number within these bounds")])
    return int(raw)


# The bounds keep every product finite and far from underflow, and are wider than any damper.
DAMPING_RATIO = Quantity(
    "damping_ratio", "structural damping ratio ζ = c/(2√(kM))", 0.0, 1.0,
    "the structure must be underdamped; the paper's has 0.0038", below=True,
)  # fmt: skip
RESTITUTION = Quantity(
    "restitution",
    "coefficient of restitution e",
    0.0,
    1.0,
    "0 is a wall that keeps the particle, 1 loses nothing",
)
MASS_RATIO = Quantity("mass_ratio", "mass ratio β = m/M", 0.0, 1e12, "give particle mass over primary mass")
CLEARANCE_RATIO = Quantity(
    "clearance_ratio", "clearance ratio d/Z", 1e-12, 1e12,
    "give half the free cavity length over the base amplitude, or write `particle: false`",
)  # fmt: skip
FRICTION_RATIO = Quantity(
    "friction_ratio", "friction ratio γ_F = F_f/(kZ)", 0.0, 1e12, "give 0 for a scene without friction"
)
# Outside these bounds one period lasts more than 10^4 of the other: the response is quasi-static or isolated, and the
# closed forms lose the accuracy of their smaller term.
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
TILT = Quantity("tilt_deg", "tilt α of the cavity [°]: 0 lies, 90 stands", 0.0, 90.0, "give it in degrees")
OF_CAVITY = (PARTICLE_FRICTION, TILT)
"""The quantities of a cavity. Each determines one of the two ratios in `BEFORE`, in this order."""
CAVITY_NAMES = {
    PARTICLE_FRICTION.name: ("friction coefficient of the particle", "μ_i", "1"),
    TILT.name: ("tilt of the cavity", "α", "degree"),
}
"""Words, symbol and CF unit of each quantity of a cavity; its other names are made from them."""
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
    "give 0 for a cavity that lies",
)
RATIOS: dict[str, Quantity] = {
    q.name: q
    for q in (DAMPING_RATIO, RESTITUTION, MASS_RATIO, CLEARANCE_RATIO, FRICTION_RATIO, FREQUENCY_RATIO)
}
"""The six dimensions of a cube as quantities, in the cube's order."""
QUANTITY_OF = RATIOS | {each.name: each for each in (PARTICLE_FRICTION_RATIO, GRAVITY_RATIO)}
"""Every dimension that a cube may have, as a quantity."""
