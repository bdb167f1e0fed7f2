"""The interpretation of a study in sentences: assumed values, derived ratios and implausible values."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.amplitudes import AMPLITUDE, RATIOS_OF
from damperlab.studies.axes import AxisSpec
from damperlab.studies.cavity import left_open
from damperlab.studies.definition import Study
from damperlab.studies.kind import AnyStudy
from damperlab.studies.physical import derivations
from damperlab.studies.quantity import PARTICLE_FRICTION
from damperlab.studies.specification.specification import Specification
from damperlab.studies.variables import DIMENSION_NAMES, SYMBOLS
from damperlab.studies.vocabulary import ACCELERATION_UNITS, DEFAULTS

FEW, MANY = 0.1, 100.0
"""Lowest plausible clearance ratio, and highest plausible friction ratio. Ratios beyond these limits suggest
a wrong unit.
"""
ROUGH = 2.0
"""Largest coefficient of sliding friction of dry materials."""
DISPLACEMENTS = ("displacement_m", "relative_displacement_m")
"""Names of the limits on a displacement of the structure."""
VIOLENT = 20.0 * ACCELERATION_UNITS["g"]
"""Acceleration of a base [m/s²] above which a unit is probably wrong. For example, 0.3 m instead of 0.3 mm at 8 Hz is
77 g.
"""
APART = 2.5
"""A band of frequency ratios is far from the natural frequency if it lies above `APART` or below 1/`APART`.

An angular frequency in place of a frequency is wrong by the factor 2π. `APART` is about √(2π).
"""

Ends = tuple[float, float]


def understood(study: AnyStudy) -> list[str]:
    """Describe the interpretation of a study.

    Parameters
    ----------
    study : AnyStudy
        The study as read from the user's document. (A stored definition does not show which values are defaults.)

    Returns
    -------
    list of str
        Sentences on the assumed values, on the ratios from the physical block, and on implausible values. For a list of
        two frequencies, a sentence explains how to write a range. The list is empty for a ground-motion
        suite.
    """
    if not isinstance(study, Study):
        return []
    found = []
    made = ratios(study)
    cavity = left_open(study.document()) if study.particle and made else []
    if taken := assumed({name: DEFAULTS[name] for name in study.assumed}, cavity):
        found.append(taken)
    if made:
        found.append(f"In ratios: {', '.join(_spelled(name, ends) for name, ends in made.items())}.")
    return [*found, *unusual_study(study), *_two_frequencies(study)]


def unusual_study(study: AnyStudy) -> list[str]:
    """Return sentences about implausible values in the physical block of a study."""
    if not isinstance(study, Study) or study.physical is None:
        return []
    zeta = float(study.coordinates["damping_ratio"][0])
    found = _unusual(ratios(study), zeta, study.forced, "the physical block")
    found += _violent(_base_acceleration(study), "`base_amplitude_m`")
    found += _far_band(study)
    given = study.physical.values().get("particle_friction_coefficient")
    return found + _rough(0.0 if given is None else float(given.min()))


def unusual_specification(asked: Specification) -> list[str]:
    """Return sentences about implausible values in a specification in SI units.

    A value is reported only if it is implausible for all dampers in the ranges and for all amplitudes. Excitations by
    ground-motion records are not checked.
    """
    if not asked.in_units:
        return []
    structure, chosen = asked.structure, asked.choices
    made = {"mass_ratio": (chosen["particle_mass_kg"].start / structure.mass_kg,) * 2}
    over_m = [
        float(amplitude * each.base_m(1.0, r))
        for each in asked.excitations
        for amplitude in (each.lowest_m, each.highest_m)
        for r in (each.low, each.high)
    ]
    if over_m:
        clearance, force = chosen["clearance_m"], chosen["friction_force_n"]
        made["friction_ratio"] = (
            force.start / (structure.stiffness_n_per_m * max(over_m)),
            force.stop / (structure.stiffness_n_per_m * min(over_m)),
        )
        if chosen["particle_mass_kg"].stop > 0.0:
            made["clearance_ratio"] = (clearance.start / max(over_m), clearance.stop / min(over_m))
    forced = all(each.motion.force for each in asked.excitations)
    motions = {each.motion.key for each in asked.excitations}
    key = f"`{motions.pop()}`" if len(motions) == 1 else "the excitations"
    found = _unusual(made, structure.damping_ratio, forced, "the specification", key)
    shakes = [
        float(each.lowest_m * each.base_m(1.0, each.low)) * (structure.angular_frequency * each.low) ** 2
        for each in asked.excitations
        if not each.motion.force
    ]
    found += _rough(asked.choices[PARTICLE_FRICTION.name].start)
    if asked.excitations:
        band = min(each.low for each in asked.excitations), max(each.high for each in asked.excitations)
        found += _far(band, structure.angular_frequency / (2.0 * np.pi))
    if not asked.records:
        found += _loose(asked.limits, max(over_m), structure.damping_ratio)
    return found + _violent(min(shakes, default=0.0), key)


def ratios(study: Study) -> dict[str, Ends]:
    """Return the smallest and the largest value of every ratio from the physical block."""
    if study.physical is None:
        return {}
    given = study.physical.values()
    names = [each.ratio for each in derivations(given, study.particle)]
    values: Mapping[str, NDArray[Any]] = study.coordinates
    if study.over_amplitudes:
        sources = (*RATIOS_OF, AMPLITUDE, "frequency_ratio")
        ends = np.meshgrid(*(values[name][[0, -1]] for name in sources))
        corners = {name: each.ravel() for name, each in zip(sources, ends, strict=True)}
        values = {**values, **study.physical.ratios_at(corners, study.particle)}
    return {name: (float(np.min(values[name])), float(np.max(values[name]))) for name in names}


def _base_acceleration(study: Study) -> float:
    """Return the smallest acceleration of the base in a study [m/s²]; 0 if the acceleration is unknown."""
    given = {} if study.physical is None or study.forced else study.physical.values()
    if not given.keys() >= {"base_amplitude_m", "natural_frequency_hz"}:
        return 0.0
    slowest = 2.0 * np.pi * given["natural_frequency_hz"].min() * study.coordinates["frequency_ratio"].min()
    return float(given["base_amplitude_m"].min() * slowest**2)


def _far_band(study: Study) -> list[str]:
    given = {} if study.physical is None else study.physical.values()
    r = study.coordinates["frequency_ratio"]
    if "natural_frequency_hz" not in given or "excitation_frequency_hz" not in given or len(r) == 1:
        return []
    return _far((float(np.min(r)), float(np.max(r))), float(given["natural_frequency_hz"].min()))


def _far(band: Ends, natural_hz: float) -> list[str]:
    """Report a band of frequency ratios that lies far from the natural frequency on one side."""
    low, high = band
    if high >= 1.0 / APART and low <= APART:
        return []
    shown = f"{low * natural_hz:.4g} to {high * natural_hz:.4g} Hz"
    side = "below" if high < 1.0 else "above"
    field, given = (
        ("`natural_frequency_hz`", natural_hz) if high < 1.0 else ("the frequencies", low * natural_hz)
    )
    return [
        f"The frequencies, {shown}, are all far {side} the natural frequency {natural_hz:.4g} Hz, where "
        f"there is no resonance to damp: check {field}. If rad/s was meant: {given:.4g} rad/s are "
        f"{given / (2.0 * np.pi):.4g} Hz."
    ]


def _violent(acceleration: float, key: str) -> list[str]:
    if acceleration <= VIOLENT:
        return []
    shown = f"{acceleration / ACCELERATION_UNITS['g']:.3g} g"
    return [f"The base shakes with at least {shown}: check the units of {key} and of the frequencies."]


def _loose(limits: Mapping[str, float], base_m: float, damping: float) -> list[str]:
    """Report each displacement limit that the structure satisfies at every frequency even without a damper.

    Near resonance, the displacement of the structure relative to the base is ``Z/(2ζ)``. The absolute
    displacement exceeds this value by at most Z.
    """
    most = base_m * (1.0 + 0.5 / damping) if damping > 0.0 else np.inf
    return [
        f"Without a damper the displacement is at most {most:.3g} m, below the limit of {limit:g} m: check the "
        f"unit of `limits.{name}`."
        for name, limit in limits.items()
        if name in DISPLACEMENTS and limit > most
    ]


def _rough(coefficient: float) -> list[str]:
    """Report a friction coefficient above `ROUGH`."""
    if coefficient <= ROUGH:
        return []
    return [
        f"The friction coefficient of the particle is μ_i = {coefficient:g} or more: check "
        "`particle_friction_coefficient`."
    ]


def assumed(values: Mapping[str, float], cavity: Sequence[str]) -> str:
    """Return a sentence that states the values assumed for missing entries.

    Parameters
    ----------
    values : mapping of float
        The assumed numbers, by name.
    cavity : sequence of str
        Words for the assumed properties of the cavity, see `cavity.left_open`; empty without a particle.

    Returns
    -------
    str
        One sentence; empty if nothing was assumed.
    """
    names = [f"{DIMENSION_NAMES[name]} {_spelled(name, (value,) * 2)}" for name, value in values.items()]
    if cavity:
        names.append(f"a {', '.join(cavity)} cavity")
    return f"Not given, and assumed: {', '.join(names)}." if names else ""


def _spelled(name: str, ends: Ends) -> str:
    low, high = ends
    return f"{SYMBOLS[name]} = {low:.3g}" + (f" to {high:.3g}" if low < high else "")


def _unusual(made: Mapping[str, Ends], damping: float, forced: bool, where: str, key: str = "") -> list[str]:
    """Return sentences about implausible ratios, with the fields to check."""
    found = []
    moves, exerts = "base moves {} times as far as", "base exerts"
    if forced:
        moves, exerts = "static displacement is {} times", "excitation exerts"
    key = key or ("`force_n`" if forced else "`base_amplitude_m`")
    if "mass_ratio" in made and made["mass_ratio"][1] > 1.0:
        shown = _spelled("mass_ratio", made["mass_ratio"])
        found.append(f"The particle is heavier than the structure ({shown}): check the masses.")
    if "clearance_ratio" in made:
        low, high = made["clearance_ratio"]
        shown = _spelled("clearance_ratio", (low, high))
        if high < FEW:
            found.append(
                f"The {moves.format(f'more than {1.0 / FEW:g}')} the clearance ({shown}): check the units of "
                f"`clearance_m` and {key}."
            )
        # without other damping the steady amplitude at resonance is Z/(2ζ); the transient is at most twice as large
        if damping > 0.0 and low > max(1.0 / damping, MANY):
            found.append(
                f"The clearance is larger than any motion ({shown}), so that the particle meets no wall: check the units of "
                f"`clearance_m` and {key}."
            )
    if "friction_ratio" in made and made["friction_ratio"][0] > MANY:
        found.append(
            f"The friction force is more than {MANY:g} times the force that the {exerts} "
            f"({_spelled('friction_ratio', made['friction_ratio'])}): check the units of {where}."
        )
    return found


def _two_frequencies(study: Study) -> list[str]:
    """Point out that a list of two frequencies has only two values, because users often mean a range."""
    in_units = study.physical is not None and study.physical.excitation_frequency_hz is not None
    spec: AxisSpec | None = study.axes.frequency_ratio
    if study.physical is not None and in_units:
        spec = study.physical.excitation_frequency_hz
    if not isinstance(spec, tuple) or len(spec) != 2:
        return []
    low, high = (f"{each:.10g}" for each in spec)
    name = "excitation frequencies" if in_units else "frequency ratios"
    return [
        f"Two {name} are computed, {low} and {high}{' Hz' if in_units else ''}, and none between; a range is written as "
        f"{{start: {low}, stop: {high}, num: 21}}."
    ]
