"""Names and values of quantities in the sentences of answers: as ratios, or in units if the study is given in units."""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, NamedTuple

from damperlab.studies.amplitudes import AMPLITUDE as BASE_AMPLITUDE
from damperlab.studies.amplitudes import RATIOS_OF
from damperlab.studies.answers.excited import amplitude_called
from damperlab.studies.ground.variables import DIMENSIONS as SUITE_DIMENSIONS
from damperlab.studies.ground.variables import SYMBOLS as SUITE_SYMBOLS
from damperlab.studies.ground.variables import VARIABLES as SUITE_VARIABLES
from damperlab.studies.quantity import CAVITY_NAMES
from damperlab.studies.rounding import is_rounding
from damperlab.studies.spelling import unit_of, written
from damperlab.studies.unit_names import (
    ACCELERATIONS,
    AMPLITUDES,
    COORDINATE_NAMES,
    ENERGY,
    OVER,
    RESULT_NAMES,
    RESULTS,
    SPEED,
    with_what_it_is_over,
)
from damperlab.studies.units import InUnits, coordinates_in_units, in_si, results_in_units
from damperlab.studies.variables import DIMENSION_NAMES, MADE_BY, SYMBOLS, VARIABLES

if TYPE_CHECKING:
    import xarray as xr

AMPLITUDE = "amplitude_ratio"
FREQUENCY = "frequency_ratio"


class Printed(NamedTuple):
    """A quantity in an engineer's units."""

    symbol: str
    label: str
    unit: str
    scale: float
    """Factor from the SI unit to this unit."""


PRINTED: dict[str, Printed] = {
    "clearance_ratio": Printed("d", "clearance d", "mm", 1e3),
    "friction_ratio": Printed("F_f", "friction force F_f", "N", 1.0),
    "mass_ratio": Printed("m", "mass of the particle m", "kg", 1.0),
    FREQUENCY: Printed("f", "excitation frequency f", "Hz", 1.0),
    **{
        ratio: Printed(CAVITY_NAMES[name][1], COORDINATE_NAMES[name], unit_of(name), 1.0)
        for ratio, name in MADE_BY.items()
    },
    "impact_speed_max": Printed("v", "largest impact speed", "m/s", 1.0),
    "dissipation_per_cycle": Printed("ΔE", "energy dissipated per cycle", "J", 1.0),
    **{name: Printed("X", "amplitude X", "mm", 1e3) for name in AMPLITUDES},
    **{ratio: Printed("a", RESULT_NAMES[name], "m/s²", 1.0) for ratio, name in ACCELERATIONS.items()},
}
"""Printed quantity of each ratio, for a study that is given in units."""

_PRINTED_UNITS = {
    "m": ("mm", 1e3),
    "m s-1": ("m/s", 1.0),
    "m s-2": ("m/s²", 1.0),
    "J": ("J", 1.0),
    "s": ("s", 1.0),
}

PRINTED_OF_SI: dict[str, Printed] = {
    **{name: PRINTED[ratio] for name, ratio in RATIOS_OF.items()},
    BASE_AMPLITUDE: Printed("Z", "base amplitude Z", "mm", 1e3),
    "particle_mass_kg": PRINTED["mass_ratio"],
    **{name: PRINTED[ratio] for ratio, name in MADE_BY.items()},
    "frequency_hz": PRINTED[FREQUENCY],
    **{name: PRINTED[source] for source, name in (AMPLITUDES | ACCELERATIONS).items()},
    SPEED: PRINTED["impact_speed_max"],
    ENERGY: PRINTED["dissipation_per_cycle"],
    "natural_frequency_hz": Printed("f_n", "natural frequency f_n", "Hz", 1.0),
    **{
        name: Printed(
            SUITE_SYMBOLS.get(name, variable.long_name), variable.long_name, *_PRINTED_UNITS[variable.units]
        )
        for name, variable in SUITE_VARIABLES.items()
        if variable.units != "1"
    },
}
"""Printed quantity of each dimension and result in SI units."""

_PRINTED = PRINTED | PRINTED_OF_SI

TERMS: dict[str, str] = {
    **{name: words for name, (_, words) in SUITE_DIMENSIONS.items()},
    **{name: f"{words} {SYMBOLS[name]}" for name, words in DIMENSION_NAMES.items()},
    **{name: printed.label for name, printed in PRINTED_OF_SI.items()},
}
"""Names of dimensions and quantities in sentences."""


@dataclass(frozen=True)
class Phrases:
    """Names and values of quantities, in words.

    Parameters
    ----------
    quantities : mapping of InUnits
        Quantities in units, by name in the cube. All other quantities are ratios.
    amplitude : str
        Name of the reference length Z.
    """

    quantities: Mapping[str, InUnits] = field(default_factory=dict)
    amplitude: str = "base amplitude"

    @classmethod
    def of(cls, cube: "xr.Dataset") -> "Phrases":
        """Return the phrases for a study: in units, or in ratios if the study is given in ratios alone."""
        beside = (*coordinates_in_units(cube), *results_in_units(cube))
        found = {each.source: each for each in (*beside, *in_si(cube))}
        named = found | {each.name: replace(each, source=each.name, factor=1.0) for each in beside}
        return cls(named, amplitude_called(cube))

    @classmethod
    def of_ratios(cls, cube: "xr.Dataset") -> "Phrases":
        """Return phrases that state ratios. Quantities that the cube stores in SI units keep their units."""
        return cls({each.source: each for each in in_si(cube)}, amplitude_called(cube))

    def as_named(self, metric: str | None) -> "Phrases":
        """Return the phrases for a table of a result. If the user named a ratio, all quantities are ratios.

        Parameters
        ----------
        metric : str or None
            The name of the result that the user wrote; None if the user named no result.
        """
        if metric not in VARIABLES:
            return self
        kept = {name: each for name, each in self.quantities.items() if name not in VARIABLES}
        return replace(self, quantities=kept)

    def _has(self, name: str) -> bool:
        return name in self.quantities

    def symbol(self, name: str) -> str:
        """Return the symbol of a dimension or of the amplitude."""
        if self._has(name):
            return _PRINTED[name].symbol
        return "X/Z" if name == AMPLITUDE else SYMBOLS.get(name, name)

    def label(self, name: str) -> str:
        """Return the name of a dimension, or of its quantity in units, with the symbol."""
        if name == BASE_AMPLITUDE:
            return f"{self.amplitude} Z"
        return _PRINTED[name].label if self._has(name) else TERMS.get(name, name)

    def unit(self, name: str) -> str:
        """Return the unit with a leading space, or "" for a ratio. The sign for degrees has no leading space."""
        unit = _PRINTED[name].unit if self._has(name) else ""
        return unit if unit == "°" else f" {unit}".rstrip()

    def column(self, name: str, quantity: str) -> str:
        """Name a column of a table, with the unit in brackets.

        `quantity` is the quantity of a cube with this unit. It differs from `name` if `name` occurs only in answers.
        """
        if not self._has(quantity):
            if name in SYMBOLS:
                return f"{name} {SYMBOLS[name]}"
            # next to a ratio, the reference Z is implied
            return f"{name} [{OVER[quantity]}]" if quantity in OVER_MORE_THAN_Z else name
        of_a_dimension = name in TERMS and name not in RESULTS
        named = _SI_SUFFIX.sub("", (AMPLITUDES | ACCELERATIONS).get(name, name))
        unit = _PRINTED[quantity].unit
        return f"{self.label(name) if of_a_dimension else named}{unit and f' [{unit}]'}"

    def printed(self, name: str, value: float) -> float:
        """Convert a ratio to the printed unit of its quantity."""
        return value * self.quantities[name].factor * _PRINTED[name].scale if self._has(name) else value

    def number(self, name: str, value: float, form: str = ".6g") -> str:
        """Convert a ratio to the printed unit of the quantity, and write the number without the unit."""
        return format(self.printed(name, value), form)

    def value(self, name: str, value: float, form: str = ".6g") -> str:
        """Convert a ratio to the printed unit of the quantity, and write the number with the unit."""
        return written(self.printed(name, value), self.unit(name).lstrip(), form)

    def equal(self, name: str, value: float, form: str = ".6g") -> str:
        """Write ``r = 0.8``, or ``f = 2 Hz``."""
        return f"{self.symbol(name)} = {self.value(name, value, form)}"

    def span(self, name: str, low: float, high: float, form: str = ".6g") -> str:
        """Write a range as ``r = 0.8 to 1.25``, or ``f = 2 to 3.125 Hz``; write a range of one value as that value."""
        if low == high:
            return self.equal(name, low, form)
        return f"{self.symbol(name)} = {self.pair(name, low, 'to', high, form)}"

    def pair(self, name: str, first: float, word: str, second: float, form: str = ".6g") -> str:
        """Write two values of a quantity, as ``2 to 3.125 Hz``. Each has its unit if the units differ (mm and nm)."""
        unit, both = self.unit(name).lstrip(), [self.value(name, each, form) for each in (first, second)]
        if unit and all(each.endswith(unit) for each in both):
            both[0] = both[0].removesuffix(unit).rstrip()
        return f" {word} ".join(both)

    def measured(self, value: float, error: float, form: str = ".6g") -> str:
        """Write an amplitude with its error. An error too small for the digits shown is omitted."""
        hides = form == ".3g" and abs(error) < HIDDEN * abs(value)
        if is_rounding(value, error) or hides:
            return self.value(AMPLITUDE, value, form)
        if math.isnan(error):
            return f"{self.value(AMPLITUDE, value, form)} (error not known)"
        shown, doubt = self.value(AMPLITUDE, value, form), self.value(AMPLITUDE, error, ".2g")
        unit = doubt.partition(" ")[2]
        return f"{shown.removesuffix(f' {unit}')} ± {doubt}"

    def shown(self, name: str, array: "xr.DataArray") -> str:
        """Return the name of a result with the unit or the reference, such as ``amplitude X in mm``."""
        units = str(array.attrs.get("units", "1"))
        told = self.about(with_what_it_is_over(name, str(array.attrs.get("long_name", name))))
        if self._has(name):
            units = _PRINTED[name].unit
            told = (
                _PRINTED[name].label if name in ACCELERATIONS else self.about(str(array.attrs["long_name"]))
            )
        return told if units == "1" else f"{told}{',' if ',' in told else ''} in {units}"

    def about(self, long_name: str) -> str:
        """Replace ratios in the long name of a criterion by quantities in units."""
        if self._has(AMPLITUDE):
            for ratio, length in (("X/Z", "X"), ("amplitude ratio", "amplitude"), ("|x−z|/Z", "|x−z|")):
                long_name = long_name.replace(ratio, length)
        return long_name.replace("r = 1", self.equal(FREQUENCY, 1.0))


OVER_MORE_THAN_Z = OVER.keys() - AMPLITUDES.keys() - ACCELERATIONS.keys()
"""Results that are divided by a reference which their names do not state."""
HIDDEN = 5e-4
"""Relative error below which an error does not show in three digits."""
RATIOS = Phrases()
_SI_SUFFIX = re.compile(r"_(m_per_s2|m_per_s|m_s2|m_s|m|j|s)$")  # the unit is given separately


def said(cube: "xr.Dataset", say: Callable[[Phrases], dict[str, Any]]) -> dict[str, Any]:
    """Return the texts of an answer in ratios. If the study is given in units, add the texts in units as ``in_units``.

    Parameters
    ----------
    cube : Dataset
        The study of the question.
    say : callable
        Function of the phrases. The function returns a mapping from attributes to texts.
    """
    units = Phrases.of(cube)
    words = say(Phrases.of_ratios(cube))
    return words | {"in_units": say(units)} if units.quantities else words


def together(first: Mapping[str, Any], second: Mapping[str, Any]) -> dict[str, Any]:
    """Combine the texts of two answers, separately for ratios and for physical units."""
    words = {**first, **second}
    if "in_units" in first and "in_units" in second:
        words["in_units"] = {**first["in_units"], **second["in_units"]}
    return words


def noted(first: Mapping[str, Any], second: Mapping[str, Any]) -> dict[str, Any]:
    """Join the notes of two answers, separately for ratios and for physical units."""
    words = {**second, "note": f"{first['note']} {second['note']}".strip()}
    if "in_units" in second:
        words["in_units"] = noted(first.get("in_units", first), second["in_units"])
    return words


def first_said(answer: Mapping[str, Any], sentences: list[str]) -> dict[str, Any]:
    """Put sentences in front of a short answer, and return the attributes of the answer.

    The sentences are added to both versions of the short answer: in ratios, and in physical units.
    """
    words = dict(answer)
    if sentences and "brief" in words:
        words["verdict"] = [*sentences, *words["brief"]["sentences"]]
        words["brief"] = {**words["brief"], "sentences": words["verdict"]}
    if "in_units" in words:
        words["in_units"] = first_said(words["in_units"], sentences)
    return words
