"""Registry of the result variables of harmonic studies, with units and meanings, for cubes, queries and documents."""

from collections.abc import Container
from dataclasses import dataclass
from enum import IntEnum
from math import nan

_DIMENSIONS: dict[str, tuple[str, str, str]] = {
    "damping_ratio": ("structural damping ratio", "ζ", ""),
    "restitution": ("coefficient of restitution", "e", ""),
    "mass_ratio": ("mass ratio", "β", ", particle over primary"),
    "clearance_ratio": ("clearance ratio", "d/Z", ""),
    "friction_ratio": ("friction ratio", "γ_F", ""),
    "frequency_ratio": ("frequency ratio", "r", " = ω/ω_n"),
}
DIMENSIONS: tuple[str, ...] = tuple(_DIMENSIONS)
"""Dimensions of the cube of a harmonic study in ratios, in this order. All dimensions are always present."""
PARTICLE_FRICTION, GRAVITY = BEFORE = "particle_friction_ratio", "gravity_ratio"
"""Optional dimensions, which precede `DIMENSIONS`. An optional dimension is present only if the study defines it."""
MADE_BY = {PARTICLE_FRICTION: "particle_friction_coefficient", GRAVITY: "tilt_deg"}
"""Source quantity in a physical block for each of the optional dimensions."""
_DIMENSIONS[PARTICLE_FRICTION] = ("friction ratio of the particle", "κ", " = μ_i·g/(ω_n²·Z)")
_DIMENSIONS[GRAVITY] = ("gravity ratio", "G", " = g·sin α/(ω_n²·Z)")
DIMENSION_NAMES: dict[str, str] = {name: words for name, (words, _, _) in _DIMENSIONS.items()}
SYMBOLS: dict[str, str] = {name: symbol for name, (_, symbol, _) in _DIMENSIONS.items()}
"""Symbol of each dimension."""
DIMENSION_LONG_NAMES: dict[str, str] = {
    name: f"{words} {symbol}{more}" for name, (words, symbol, more) in _DIMENSIONS.items()
}


def dimensions_of(names: Container[object]) -> tuple[str, ...]:
    """Return the dimensions of a harmonic study in the order of the cube, with the optional dimensions in `names`."""
    return (*(name for name in BEFORE if name in names), *DIMENSIONS)


class Status(IntEnum):
    """Outcome of the computation of one design point. Values of 2 and above are failures."""

    NOT_COMPUTED = -1
    CONVERGED = 0
    MAX_CYCLES = 1
    TOO_MANY_EVENTS = 2
    UNBOUNDED = 3
    NO_PROGRESS = 4
    BLOCK_FAILED = 5

    @property
    def outcome(self) -> str:
        """The outcome of the computation as a sentence."""
        return _OUTCOMES[self]

    @property
    def sentence(self) -> str:
        """The outcome and, if possible, a remedy as sentences."""
        return " ".join(filter(None, (self.outcome, _REMEDIES.get(self))))


_OUTCOMES = {
    Status.NOT_COMPUTED: "This point has not been computed yet.",
    Status.CONVERGED: "The steady response was found: it repeats, or else its mean is known to within `steady.tolerance`.",
    Status.MAX_CYCLES: (
        "The run reached its limit on cycles or events before the mean was known to `steady.tolerance`; values are given "
        "with their standard error."
    ),
    Status.TOO_MANY_EVENTS: "The limit on events was reached: impacts or steps follow each other too fast to resolve.",
    Status.UNBOUNDED: (
        "The response grew to the end of the run, with no sign of a bound, as at resonance with little or no "
        "damping."
    ),
    Status.NO_PROGRESS: "Events repeated without time moving on.",
    Status.BLOCK_FAILED: "The block that held this point failed in its worker; the study's record has the reason.",
}
_REMEDIES = {
    Status.MAX_CYCLES: (
        "This error falls as 1/√cycles: half the error takes four times `steady.max_cycles`. If the error is "
        "within `steady.tolerance`, the response may be a transient: a stable orbit lies nearby, or a moving "
        "particle has not met a wall yet. If a force on the structure stays below the friction force, the "
        "particle was still so fast that its impacts may move the mass."
    ),
    Status.UNBOUNDED: "If there is some damping, a larger `steady.max_cycles` may show the bound.",
}


class ResponseClass(IntEnum):
    """Class of the steady response of a design point."""

    UNKNOWN = -1
    LINEAR = 0
    LOCKED = 1
    NO_IMPACT = 2
    SYMMETRIC = 3
    ASYMMETRIC = 4
    SUBHARMONIC = 5
    MODULATED = 6
    CHAOTIC = 7
    CARRIED = 8

    @property
    def sentence(self) -> str:
        """The class in words."""
        return _CLASS_SENTENCES[self]


_CLASS_SENTENCES = {
    ResponseClass.UNKNOWN: "Not computed, or failed.",
    ResponseClass.LINEAR: "Linear: neither friction nor impacts act; the closed form holds.",
    ResponseClass.LOCKED: "Locked: friction holds the mass to the base all the time; a particle may still move.",
    ResponseClass.NO_IMPACT: "Periodic, and the particle never meets a wall.",
    ResponseClass.SYMMETRIC: "Periodic with the excitation, each half cycle the mirror of the other.",
    ResponseClass.ASYMMETRIC: "Periodic with the excitation, symmetry broken: a mirrored twin response exists.",
    ResponseClass.SUBHARMONIC: "Periodic over several excitation periods.",
    ResponseClass.MODULATED: "Not periodic: modulated (quasi-periodic, bursting, or not told apart from chaos).",
    ResponseClass.CHAOTIC: "Chaotic: the largest Lyapunov exponent is positive.",
    ResponseClass.CARRIED: "Periodic, and the particle never slides: its own friction carries it along as dead mass.",
}


@dataclass(frozen=True)
class Variable:
    """One result variable of the cube.

    Parameters
    ----------
    name : str
        Name in the cube, the queries and every document.
    dtype : str
        Data type in the store, in the spelling of numpy, for example ``f8``.
    units : str
        Unit in the spelling of UDUNITS; "1" for ratios.
    long_name : str
        Name for axis titles.
    doc : str
        Meaning of the variable in one sentence, with the normalisation.
    flags : type of IntEnum, optional
        Enumeration of the values, if the values are codes.
    start : str, optional
        The only start option that computes the variable; "" if every start option computes the variable.
    asked : bool
        Whether the variable is stored only on request.
    rubbing : bool
        Whether the variable is stored only if the particle has friction in the cavity.
    """

    name: str
    dtype: str
    units: str
    long_name: str
    doc: str
    flags: type[Status] | type[ResponseClass] | None = None
    start: str = ""
    asked: bool = False
    rubbing: bool = False

    @property
    def fill(self) -> float | int:
        """Value in the store for a point that has not been computed."""
        return nan if self.dtype.startswith("f") else -1


def _of_starts(name: str, dtype: str, long_name: str, doc: str) -> Variable:
    return Variable(name, dtype, "1", long_name, doc, start="ensemble")


def _ratio(name: str, long_name: str, doc: str, units: str = "1") -> Variable:
    return Variable(name, "f8", units, long_name, doc)


def _on_demand(name: str, long_name: str, doc: str) -> Variable:
    return Variable(name, "f8", "1", long_name, doc, asked=True)


VARIABLES: dict[str, Variable] = {
    v.name: v
    for v in (
        _ratio(
            "amplitude_ratio",
            "amplitude ratio X/Z",
            "Mean of the peaks of |x|/Z over steady excitation cycles. A cycle begins at every half cycle, "
            "so a motion and its mirror image have the same value.",
        ),
        _ratio(
            "amplitude_ratio_max",
            "largest amplitude ratio",
            "Largest |x|/Z over the measured steady cycles. If the response does not repeat, only the last "
            "three quarters of these cycles count (with fixed steps, all), and the value is at least "
            "amplitude_ratio; it grows slowly with the number of cycles. It has no error.",
        ),
        _ratio(
            "amplitude_ratio_rms",
            "rms amplitude ratio",
            "√2 times the rms of x/Z over the steady cycles; equals the amplitude for a sinusoid. It has no error of its own.",
        ),
        _ratio(
            "relative_amplitude_ratio",
            "relative amplitude ratio |x−z|/Z",
            "Mean of the peaks of |x−z|/Z over the same cycles; it has no error of its own.",
        ),
        _on_demand(
            "acceleration_ratio",
            "acceleration ratio |ẍ|/(Z·ω_n²)",
            "Mean of the peaks of the acceleration of the structure in the same cycles, divided by Z·ω_n² "
            "(F₀/M under a force). Instantaneous impacts are left out. It has no error of its own.",
        ),
        _on_demand(
            "acceleration_ratio_rms",
            "rms acceleration ratio",
            "√2 times the rms of the acceleration of the structure, divided by Z·ω_n² (F₀/M under a force). "
            "Instantaneous impacts are left out. For a sinusoid it equals the peak. It has no error of its "
            "own.",
        ),
        _ratio(
            "amplitude_error",
            "error of the amplitude ratio",
            "Error of amplitude_ratio. For a periodic response: its distance from periodicity. For a "
            "modulated response: one standard error (batch means). For a mass locked under a force: how far "
            "impacts may still move the mass.",
        ),
        _ratio(
            "energy_residual",
            "energy residual",
            "|work in − losses − change of stored energy| for the measured cycles, divided by the largest of "
            "work, losses, stored energy and k/2 times the squared peak displacement.",
        ),
        Variable(
            "response_class",
            "i1",
            "1",
            "class of the response",
            "What kind of response it is.",
            ResponseClass,
        ),
        Variable(
            "period",
            "i4",
            "1",
            "period in excitation cycles",
            "Period of a periodic response in excitation cycles; 0 for one that is not periodic.",
        ),
        _ratio(
            "floquet_multiplier",
            "Floquet multiplier",
            "Largest modulus of the Floquet multipliers over one period of the response; NaN if it is not "
            "periodic.",
        ),
        _ratio("impacts_per_cycle", "impacts per cycle", "Impacts on either wall per excitation cycle."),
        _ratio(
            "impacts_error",
            "error of the impacts per cycle",
            "One standard error of impacts_per_cycle (batch means); 0 for a periodic response, whose impacts are counted.",
        ),
        _ratio(
            "impact_speed_max",
            "largest impact speed",
            "Largest approach speed at an impact over the same cycles as amplitude_ratio_max, over Z·ω_n.",
        ),
        _ratio(
            "stick_fraction",
            "share of time spent sticking",
            "Share of the steady time in which friction holds the mass.",
        ),
        _ratio(
            "dissipation_per_cycle",
            "energy dissipated per cycle",
            "Viscous, friction and impact loss of an excitation cycle, over k·Z²; it has no error of its own.",
        ),
        _ratio("dissipation_viscous", "viscous share of dissipation", "Share of the loss that is viscous."),
        _ratio(
            "dissipation_friction", "friction share of dissipation", "Share of the loss that is friction."
        ),
        _ratio("dissipation_impact", "impact share of dissipation", "Share of the loss that is impact."),
        Variable(
            "dissipation_particle",
            "f8",
            "1",
            "share of dissipation by the particle's friction",
            "Share of the loss that is friction between the particle and its cavity.",
            rubbing=True,
        ),
        _ratio(
            "dissipation_error",
            "error of the shares of dissipation",
            "Largest standard error of the shares (batch means of their ratio); of a periodic response, the relative "
            "distance from periodicity.",
        ),
        Variable(
            "cycles",
            "i4",
            "1",
            "excitation cycles computed",
            "Excitation cycles of the run that found the response, without the searches for nearby orbits.",
        ),
        _ratio("run_time", "run time", "CPU time for the point, without the compilation of kernels.", "s"),
        Variable("status", "i1", "1", "status", "How the computation ended.", Status),
        _of_starts(
            "amplitude_ratio_mean",
            "f8",
            "mean amplitude ratio over the starts",
            "Mean of amplitude_ratio over the starts that did not fail. The weight of a response is its "
            "share of these starts.",
        ),
        _of_starts(
            "amplitude_ratio_spread",
            "f8",
            "spread of the amplitude ratio over the starts",
            "Standard deviation of amplitude_ratio over the starts that did not fail.",
        ),
        _of_starts(
            "amplitude_ratio_worst",
            "f8",
            "largest amplitude ratio of any start",
            "Largest amplitude_ratio that any start leads to.",
        ),
        _of_starts(
            "attractors",
            "i4",
            "number of responses found",
            "Distinct steady responses that the starts lead to; a response and its mirror image are one.",
        ),
        _of_starts(
            "attractor_share",
            "f8",
            "share of starts of this response",
            "Share of all starts that lead to the response stored, which is the one that most of them lead to.",
        ),
        _of_starts(
            "attractor_share_second",
            "f8",
            "share of starts of the second response",
            "Share of all starts that lead to the second most frequent response; 0 where there is none.",
        ),
        _of_starts(
            "amplitude_ratio_second",
            "f8",
            "amplitude ratio of the second response",
            "amplitude_ratio of the second most frequent response; NaN where there is none.",
        ),
        _of_starts(
            "attractor_share_third",
            "f8",
            "share of starts of the third response",
            "Share of all starts that lead to the third most frequent response; 0 where there is none.",
        ),
        _of_starts(
            "amplitude_ratio_third",
            "f8",
            "amplitude ratio of the third response",
            "amplitude_ratio of the third most frequent response; NaN where there is none.",
        ),
    )
}
"""The variables of a cube, in the order of the cube and of CSV exports."""

STANDARD: tuple[str, ...] = tuple(v.name for v in VARIABLES.values() if not (v.start or v.asked or v.rubbing))
"""Names of the variables that a study stores by default."""

STEPPED: tuple[str, ...] = (
    "amplitude_ratio",
    "amplitude_ratio_max",
    "relative_amplitude_ratio",
    "amplitude_error",
    "impacts_per_cycle",
    "cycles",
    "run_time",
    "status",
)
"""Names of the variables that the fixed-step method computes."""

NONE_IS_ZERO: tuple[str, ...] = (
    "impact_speed_max",
    "dissipation_viscous",
    "dissipation_friction",
    "dissipation_impact",
    "dissipation_particle",
    "amplitude_ratio_second",
    "amplitude_ratio_third",
)
"""Variables whose NaN counts as 0 when a limit is checked.

In these variables, NaN means that the response has no impacts or no losses, or that no other response exists.
"""


def available_variables(start: str) -> tuple[str, ...]:
    """Return the names of the variables that are stored by default for a start option, in the order of the cube."""
    return tuple(v.name for v in VARIABLES.values() if v.start in ("", start) and not (v.asked or v.rubbing))
