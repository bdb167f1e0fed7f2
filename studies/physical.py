"""A physical case: masses, forces and lengths in SI units, and the ratios derived from these quantities."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.amplitudes import (
    AMPLITUDE,
    CONSTANT,
    RATIOS_OF,
    base_amplitudes,
    is_axis,
    kept_by_damper,
    over_amplitudes,
)
from damperlab.studies.axes import AxisSpec, along, axis_values
from damperlab.studies.choices import Choice
from damperlab.studies.faults import Fault, StudyFaults, describe
from damperlab.studies.portable import cos, sin
from damperlab.studies.quantity import OF_CAVITY, PARTICLE_FRICTION, QUANTITY_OF, TILT, Quantity
from damperlab.studies.reads import Reads
from damperlab.studies.variables import GRAVITY, MADE_BY
from damperlab.studies.variables import PARTICLE_FRICTION as PARTICLE_FRICTION_RATIO

Values = Mapping[str, NDArray[np.float64]]


def _si(name: str, meaning: str, lowest: float = 1e-12, highest: float = 1e12) -> Quantity:
    unit = meaning[meaning.rindex("[") :]
    least = "of at least 0" if lowest == 0.0 else "greater than 0"
    return Quantity(name, meaning, lowest, highest, f"give it in {unit}, a number {least}")


MASS = _si("mass_kg", "mass M of the primary structure [kg]")
NATURAL_FREQUENCY = _si("natural_frequency_hz", "undamped natural frequency ω_n/2π [Hz]", 1e-9, 1e9)
BASE_AMPLITUDE = _si("base_amplitude_m", "amplitude Z of the base [m]")
EXCITATION_FREQUENCY = _si("excitation_frequency_hz", "excitation frequency ω/2π [Hz]", 1e-9, 1e9)
FORCE = _si("force_n", "amplitude F₀ of a force on the structure [N]")
DAMPING = _si("damping_n_s_per_m", "viscous damping coefficient c [N s/m]", 0.0)
FRICTION_FORCE = _si("friction_force_n", "Coulomb friction force F_f [N]", 0.0)
CLEARANCE = _si("clearance_m", "clearance d on either side of the particle, half the free cavity length [m]")
PARTICLE_MASS = _si("particle_mass_kg", "mass m of the particle [kg]", 0.0)

STANDARD_GRAVITY = 9.80665
"""g [m/s²]."""
RADIAN = math.pi / 180.0
"""One degree, in radians."""

QUANTITIES = (
    MASS,
    NATURAL_FREQUENCY,
    BASE_AMPLITUDE,
    EXCITATION_FREQUENCY,
    DAMPING,
    FRICTION_FORCE,
    CLEARANCE,
    PARTICLE_MASS,
    *OF_CAVITY,
)
"""Every quantity of a physical block."""


_FREQUENCY = "frequency_ratio"


def _read_constant(raw: object) -> str | None:
    if raw is None or (isinstance(raw, str) and raw in CONSTANT):
        return raw
    raise StudyFaults(
        [
            Fault(
                "",
                describe(raw),
                " or ".join(CONSTANT),
                "write one of them, or leave it out for a displacement",
            )
        ]
    )


class Physical(Choice):
    """A physical case. Each entry is a number or an axis, except `constant`.

    A ratio is derived if the block contains the source quantity of the ratio. For example, `clearance_m` determines the
    clearance ratio, and requires `base_amplitude_m`. If the base amplitude is an axis while friction force and
    clearance of the damper are fixed, the study is over base amplitudes (see `damperlab.studies.amplitudes`). In such a
    study, `constant` may specify that the velocity or the acceleration of the base is the same at every frequency. Then
    `base_amplitude_m` is the amplitude at the natural frequency. Under a force on the structure, the static
    displacement F₀/k replaces the base amplitude, and `force_n` determines this displacement.
    """

    mass_kg: Annotated[AxisSpec | None, along(MASS)] = None
    natural_frequency_hz: Annotated[AxisSpec | None, along(NATURAL_FREQUENCY)] = None
    base_amplitude_m: Annotated[AxisSpec | None, along(BASE_AMPLITUDE)] = None
    force_n: Annotated[AxisSpec | None, along(FORCE)] = None
    excitation_frequency_hz: Annotated[AxisSpec | None, along(EXCITATION_FREQUENCY)] = None
    damping_n_s_per_m: Annotated[AxisSpec | None, along(DAMPING)] = None
    friction_force_n: Annotated[AxisSpec | None, along(FRICTION_FORCE)] = None
    clearance_m: Annotated[AxisSpec | None, along(CLEARANCE)] = None
    particle_mass_kg: Annotated[AxisSpec | None, along(PARTICLE_MASS)] = None
    particle_friction_coefficient: Annotated[AxisSpec | None, along(PARTICLE_FRICTION)] = None
    tilt_deg: Annotated[AxisSpec | None, along(TILT)] = None
    constant: Annotated[
        Literal["velocity", "acceleration"] | None,
        Reads(
            _read_constant,
            {
                "type": ["string", "null"],
                "enum": [*CONSTANT, None],
                "description": "quantity of the base that is the same at every frequency, in place of the "
                "displacement; only in studies over base amplitudes. `base_amplitude_m` then holds the "
                "amplitudes at the natural frequency",
            },
        ),
    ] = None

    def values(self) -> dict[str, NDArray[np.float64]]:
        """Return the values of the given quantities, by name."""
        given = {quantity.name: getattr(self, quantity.name) for quantity in QUANTITIES}
        return {name: axis_values(spec) for name, spec in given.items() if spec is not None}

    def over_amplitudes(self, particle: bool) -> bool:
        """Return whether the block describes a study over base amplitudes."""
        return over_amplitudes(dict(self), particle)

    def ratios_at(self, points: Values, particle: bool) -> dict[str, NDArray[np.float64]]:
        """Return the ratios of dampers at given base amplitudes.

        Parameters
        ----------
        points : mapping of ndarray
            Arrays of `clearance_m`, `friction_force_n` and `base_amplitude_m`, and of `frequency_ratio` unless
            `constant` is None. The arrays must broadcast together.
        particle : bool
            Whether the scene has a particle.

        Returns
        -------
        dict of ndarray
            `clearance_ratio` and `friction_ratio`, bitwise equal to the ratios of each point computed alone.
            `clearance_ratio` is 0 without a particle, and `friction_ratio` is 0 without friction. The ratios
            of `BEFORE` are added if the block determines these ratios.
        """
        given = {**self.values(), **points}
        given[AMPLITUDE] = base_amplitudes(given[AMPLITUDE], points.get(_FREQUENCY), self.constant)
        kept = kept_by_damper(dict(self), particle)
        ratios = {
            ratio: DERIVATIONS[ratio].law(given) + 0.0 if name in kept else 0.0 * given[AMPLITUDE]
            for name, ratio in RATIOS_OF.items()
        }
        beside = [ratio for ratio, name in MADE_BY.items() if particle and name in given]
        return ratios | {ratio: DERIVATIONS[ratio].law(given) + 0.0 for ratio in beside}


@dataclass(frozen=True)
class Derivation:
    """Derivation of one ratio from physical quantities.

    Parameters
    ----------
    ratio : str
        The derived ratio.
    source : str
        The quantity whose presence triggers the derivation.
    partners : tuple of str
        The other quantities that the derivation needs.
    law : callable
        Function that computes the ratio from arrays of the quantities.
    of_particle : bool
        Whether the ratio belongs to the particle. Scenes without a particle ignore such a ratio.
    proportional : bool
        Whether the ratio is proportional to the source.
    """

    ratio: str
    source: str
    partners: tuple[str, ...]
    law: Callable[[Values], NDArray[np.float64]]
    of_particle: bool = False
    proportional: bool = True

    def values(self, given: Values) -> NDArray[np.float64]:
        """Return the ratio as a sorted 1-D float64 array. At most one of the quantities may be an axis."""
        return np.sort(self.law(given)) + 0.0


def _stiffness(of: Values) -> NDArray[np.float64]:
    return of["mass_kg"] * (2.0 * math.pi * of["natural_frequency_hz"]) ** 2


def _critical(of: Values) -> NDArray[np.float64]:
    return 2.0 * of["mass_kg"] * (2.0 * math.pi * of["natural_frequency_hz"])


def _weight(of: Values) -> NDArray[np.float64]:
    """Return g/(Z·ω_n²), the acceleration of gravity as a ratio."""
    return STANDARD_GRAVITY / ((2.0 * math.pi * of["natural_frequency_hz"]) ** 2 * of["base_amplitude_m"])


def lying(of: Values) -> float | NDArray[np.float64]:
    """Return the fraction of the particle's weight that presses on the floor of the cavity."""
    if "tilt_deg" not in of:
        return 1.0
    return np.where(of["tilt_deg"] == 90.0, 0.0, cos(RADIAN * of["tilt_deg"]))


DERIVATIONS: dict[str, Derivation] = {
    d.ratio: d
    for d in (
        Derivation(
            "damping_ratio", "damping_n_s_per_m", ("mass_kg", "natural_frequency_hz"),
            lambda of: of["damping_n_s_per_m"] / _critical(of),
        ),
        Derivation(
            "mass_ratio", "particle_mass_kg", ("mass_kg",),
            lambda of: of["particle_mass_kg"] / of["mass_kg"], of_particle=True,
        ),
        Derivation(
            "clearance_ratio", "clearance_m", ("base_amplitude_m",),
            lambda of: of["clearance_m"] / of["base_amplitude_m"], of_particle=True,
        ),
        Derivation(
            "friction_ratio", "friction_force_n", ("mass_kg", "natural_frequency_hz", "base_amplitude_m"),
            lambda of: of["friction_force_n"] / (_stiffness(of) * of["base_amplitude_m"]),
        ),
        Derivation(
            PARTICLE_FRICTION_RATIO, MADE_BY[PARTICLE_FRICTION_RATIO], ("natural_frequency_hz", "base_amplitude_m"),
            lambda of: of["particle_friction_coefficient"] * _weight(of) * lying(of), of_particle=True,
        ),
        Derivation(
            GRAVITY, MADE_BY[GRAVITY], ("natural_frequency_hz", "base_amplitude_m"),
            lambda of: _weight(of) * sin(RADIAN * of["tilt_deg"]), of_particle=True, proportional=False,
        ),
        Derivation(
            "frequency_ratio", "excitation_frequency_hz", ("natural_frequency_hz",),
            lambda of: of["excitation_frequency_hz"] / of["natural_frequency_hz"],
        ),
    )
}  # fmt: skip
"""Derivation of each ratio from physical quantities, with the stiffness k = M·ω_n²."""


def derivations(given: Mapping[str, object], particle: bool) -> list[Derivation]:
    """Return the derivations that a physical block triggers in a scene with or without a particle."""
    return [d for d in DERIVATIONS.values() if d.source in given and (particle or not d.of_particle)]


def physical_faults(raw: Mapping[str, Any], particle: bool) -> list[Fault]:
    """Return a fault for each violated rule between entries of a physical block.

    The entries themselves are not checked, and may be invalid.
    """
    faults: list[Fault] = []
    made = derivations(raw, particle)
    crossed = over_amplitudes(raw, particle)
    for derivation in made:
        for partner in derivation.partners:
            if partner not in raw:
                advice = (
                    f"add `{partner}`, or give {derivation.ratio} as a ratio and remove `{derivation.source}`"
                )
                allowed = f"a number: {derivation.source} needs it to make {derivation.ratio}"
                told = f"{{field}} is missing: {derivation.source} needs it to give {derivation.ratio}."
                faults.append(Fault(f"physical.{partner}", "nothing", allowed, advice, told))
    if raw.get("constant") is not None and not crossed:
        faults.append(_constant_alone(raw, particle))
    axes = [name for name, value in raw.items() if name != "constant" and is_axis(value)]
    for name in axes:
        here = f"physical.{name}"
        fed = [d.ratio for d in made if name == d.source or name in d.partners]
        ignored = not particle and any(d.of_particle and d.source == name for d in DERIVATIONS.values())
        if name in Physical.model_fields and not fed and not ignored:
            allowed = "a single number, because no ratio depends on it here"
            faults.append(
                Fault(here, describe(raw[name]), allowed, "give one number here, or vary the ratio in `axes`")
            )
        if len(fed) > 1 and not (crossed and name == AMPLITUDE):
            found = f"an axis that moves {' and '.join(fed)} together"
            advice = "vary the ratios in `axes`, or submit one study for each value"
            told = f"{{field}} is an axis that changes {' and '.join(fed)} together, but an axis may change one ratio only."
            faults.append(Fault(here, found, "an axis of one ratio", advice, told))
    for derivation in made:
        several = [name for name in axes if name == derivation.source or name in derivation.partners]
        if crossed and derivation.source in (*RATIOS_OF, *MADE_BY.values()):
            faults.extend(
                Fault(f"physical.{name}", describe(raw[name]), "a single number if the base amplitude is an axis",
                      "give one number, or submit one study for each value")
                for name in several if name not in (derivation.source, AMPLITUDE)
            )  # fmt: skip
        elif len(several) > 1:
            faults.append(
                Fault(f"physical.{several[-1]}", f"a second axis of {derivation.ratio} in addition to {several[0]}",
                      "one axis for each ratio", "keep one of them an axis and make the others numbers",
                      f"{derivation.ratio} has two axes, `physical.{several[0]}` and {{field}}; a ratio may have only one.")
            )  # fmt: skip
    return faults


def _constant_alone(raw: Mapping[str, Any], particle: bool) -> Fault:
    """Return the fault if `constant` is used outside a study over base amplitudes.

    The advice explains how to write such a study.
    """
    constant = raw["constant"]
    amplitude = raw.get(AMPLITUDE)
    one = isinstance(amplitude, int | float) and not isinstance(amplitude, bool)
    shown = f"as in `{AMPLITUDE}: [{amplitude:g}]`" if one else f"as in `{AMPLITUDE}: [0.0001]`"
    missing = [f"`{name}`" for name in RATIOS_OF if name not in raw]
    advice = f"write the amplitude at the natural frequency as a list, even of one value, {shown}"
    if not particle:
        advice += ", and `friction_force_n` as a list"
    elif missing:
        advice += f", and give {' and '.join(missing)}"
    advice += "; without `constant` the displacement is the same at every frequency"
    told = (
        f"{{field}} needs a study over base amplitudes: with a constant {constant} the amplitude of the "
        "displacement changes with the frequency."
    )
    return Fault("physical.constant", describe(constant), f"with `{AMPLITUDE}` as a list", advice, told)


def derived_faults(physical: Physical, particle: bool, band: NDArray[np.float64]) -> list[Fault]:
    """Find derived ratios that are out of bounds or not distinct. The physical block itself must be valid.

    Parameters
    ----------
    physical : Physical
        The physical block.
    particle : bool
        Whether the scene has a particle.
    band : ndarray
        The frequency ratios of the study.
    """
    faults: list[Fault] = []
    given = physical.values()
    crossed = physical.over_amplitudes(particle)
    for derivation in derivations(given, particle):
        quantity = QUANTITY_OF[derivation.ratio]
        spans = crossed and derivation.source in (*RATIOS_OF, *MADE_BY.values())
        values = derivation.values(_corners(physical, derivation.source, band) if spans else given)
        field = f"physical.{derivation.source}"
        wrong = [float(value) for value in (values[0], values[-1]) if not quantity.admits(float(value))]
        if wrong:
            found = f"{derivation.ratio} = {wrong[0]:.6g}"
            told = f"{{field}} gives {found}, which must be {quantity.allowed}."
            advice = "check the units and the sizes of the physical block"
            faults.append(Fault(field, found, quantity.allowed, advice, told))
        elif not spans and not bool(np.all(np.diff(values) > 0.0)):
            found = f"values of {derivation.ratio} that are equal in double precision"
            told = f"{{field}} gives {found}."
            faults.append(Fault(field, found, "distinct values", "use fewer values or a wider range", told))
    return faults


def _corners(physical: Physical, source: str, band: NDArray[np.float64]) -> Values:
    """Return the quantities at the 8 corners of the ranges of `source`, base amplitude and frequency ratio."""
    given = physical.values()
    own, amplitude, r = (
        ends.ravel()
        for ends in np.meshgrid(*(axis[[0, -1]] for axis in (given[source], given[AMPLITUDE], band)))
    )
    return {**given, source: own, AMPLITUDE: base_amplitudes(amplitude, r, physical.constant)}
