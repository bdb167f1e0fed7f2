"""Coordinates and results in SI units, in addition to ratios, for a study of one structure."""

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.amplitudes import AMPLITUDE, RATIOS_OF, base_amplitudes
from damperlab.studies.conventions import of_variable_in_units
from damperlab.studies.ground.variables import DIMENSIONS as SUITE_DIMENSIONS
from damperlab.studies.ground.variables import VARIABLES as SUITE_VARIABLES
from damperlab.studies.physical import DERIVATIONS, Physical
from damperlab.studies.quantity import CAVITY_NAMES
from damperlab.studies.unit_names import (
    ACCELERATIONS,
    AMPLITUDES,
    COORDINATE_NAMES,
    ENERGY,
    RESULT_NAMES,
    SPEED,
)
from damperlab.studies.variables import DIMENSION_LONG_NAMES, MADE_BY

if TYPE_CHECKING:
    import xarray as xr

STRUCTURE = ("mass_kg", "natural_frequency_hz", "base_amplitude_m")
"""Numbers in the physical block for the conversion of ratios to SI units."""


@dataclass(frozen=True)
class InUnits:
    """A coordinate or a result as a quantity in SI units.

    Parameters
    ----------
    name : str
        Name of the quantity, with the unit at the end.
    source : str
        The corresponding dimension or variable in ratios.
    factor : float
        Factor from the ratio to the quantity.
    units, long_name : str
        Attributes by the CF conventions.
    power : int
        Power of the base amplitude in the factor. In studies over base amplitudes, `factor` is for an amplitude of 1 m.
    """

    name: str
    source: str
    factor: float
    units: str
    long_name: str
    power: int = 1

    def of(self, values: NDArray[Any]) -> NDArray[np.float64]:
        """Convert values of `source` to the quantity in SI units."""
        return np.asarray(values, np.float64) * self.factor

    @property
    def attributes(self) -> dict[str, str]:
        """Attributes of the variable with the quantity."""
        return {"units": self.units, "long_name": self.long_name}


def coordinates_in_units(cube: "xr.Dataset") -> list[InUnits]:
    """Return the coordinates in SI units that correspond to the dimensions of a cube.

    Parameters
    ----------
    cube : Dataset
        The cube of a study, or a part of the cube. The attribute `study` contains the definition.

    Returns
    -------
    list of InUnits
        One coordinate for each dimension that the physical block can convert to units. The list is empty for a study in
        ratios alone.
    """
    return [each for each in _quantities(cube) if each.source in cube.sizes]


def results_in_units(cube: "xr.Dataset") -> list[InUnits]:
    """Return the results in SI units that correspond to the variables of a cube; see `coordinates_in_units`."""
    return [each for each in _quantities(cube) if each.source in cube.data_vars]


def with_units(cube: "xr.Dataset", results: bool = True) -> "xr.Dataset":
    """Add coordinates and results in units to a cube. Results are computed lazily if the cube has Dask arrays.

    Returns
    -------
    Dataset
        The extended cube. If the study has only ratios, the cube is unchanged.
    """
    coordinates = {
        each.name: (each.source, each.of(cube[each.source].values), each.attributes)
        for each in coordinates_in_units(cube)
    }
    found = cube.assign_coords(coordinates | ratios_beside(cube))
    if not results:
        return found
    along = {
        each.name: _result(
            (cube[each.source] * base_of(cube) ** each.power).assign_attrs(cube[each.source].attrs), each
        )
        for each in results_along(cube)
    }
    found = found.assign({name: array.transpose(*cube["status"].dims) for name, array in along.items()})
    return found.assign({each.name: _result(cube[each.source], each) for each in results_in_units(cube)})


def base_of(cube: "xr.Dataset") -> "xr.DataArray":
    """Return Z [m] of a cube along the base amplitudes and, if Z varies over frequency, along the frequency."""
    constant = _physical(cube).get("constant")
    found: xr.DataArray = base_amplitudes(cube[AMPLITUDE], cube["frequency_ratio"], constant)
    return found


def results_along(cube: "xr.Dataset") -> list[InUnits]:
    """For a cube over base amplitudes, return the results in SI units. Their factors hold for a base amplitude of 1 m.

    Returns
    -------
    list of InUnits
        One quantity for each result of the cube that is a ratio. The list is empty if the cube has no dimension of
        base amplitudes.
    """
    if AMPLITUDE not in cube.sizes:
        return []
    physical = _physical(cube)
    rate = 2.0 * math.pi * _number(physical, "natural_frequency_hz")
    stiffness = _number(physical, "mass_kg") * rate**2
    every = [InUnits(name, source, 1.0, "m", RESULT_NAMES[name]) for source, name in AMPLITUDES.items()]
    every += [
        InUnits(name, source, rate**2, "m s-2", RESULT_NAMES[name]) for source, name in ACCELERATIONS.items()
    ]
    every.append(InUnits(SPEED, "impact_speed_max", rate, "m s-1", RESULT_NAMES[SPEED]))
    every.append(InUnits(ENERGY, "dissipation_per_cycle", stiffness, "J", RESULT_NAMES[ENERGY], 2))
    return [each for each in every if each.source in cube.data_vars and math.isfinite(each.factor)]


def ratios_beside(cube: "xr.Dataset") -> "dict[str, xr.Variable]":
    """Return the ratios for a cube over base amplitudes, which has dimensions in SI units.

    Each ratio varies along the dimensions of Z (see `base_of`). The clearance ratio also varies along the
    clearance, and the friction ratio along the friction force.
    """
    import xarray as xr

    if AMPLITUDE not in cube.sizes:
        return {}
    study = json.loads(cube.attrs["study"])
    physical = Physical.model_validate(study["physical"])
    met = (AMPLITUDE,) if physical.constant is None else (AMPLITUDE, "frequency_ratio")
    own = (slice(None), *(None for _ in met))
    points = {name: cube[name].values[own] for name in RATIOS_OF}
    points |= dict(zip(met, np.meshgrid(*(cube[name].values for name in met), indexing="ij"), strict=True))
    ratios = physical.ratios_at(points, study.get("particle", True))
    over = {ratio: (name, *met) for name, ratio in RATIOS_OF.items()}
    over |= {ratio: met for ratio in MADE_BY if ratio in ratios}
    return {
        ratio: xr.Variable(
            dimensions,
            np.broadcast_to(ratios[ratio], tuple(cube.sizes[each] for each in dimensions)).copy(),
            {"units": "1", "long_name": DIMENSION_LONG_NAMES[ratio]},
        )
        for ratio, dimensions in over.items()
    }


def in_si(cube: "xr.Dataset") -> list[InUnits]:
    """Return the dimensions and results that a cube stores in SI units; empty for a cube in ratios."""
    if "natural_frequency_hz" in cube.sizes:
        every = [name for name in (*SUITE_DIMENSIONS, *SUITE_VARIABLES) if name in cube.variables]
        units = {name: str(cube[name].attrs.get("units", "1")) for name in every}
        return [InUnits(name, name, 1.0, unit, name) for name, unit in units.items() if unit != "1"]
    if AMPLITUDE not in cube.sizes:
        return []
    names = [*RATIOS_OF, AMPLITUDE, *RESULT_NAMES]
    found = {name: dict(cube[name].attrs) for name in names if name in cube.variables}
    return [InUnits(name, name, 1.0, of["units"], of["long_name"]) for name, of in found.items()]


def metric_in_units(cube: "xr.Dataset", answer: "xr.Dataset", metric: str | None) -> "xr.Dataset":
    """Convert a metric and its error in an answer to SI units, if the question names the metric in SI units."""
    results = {each.name: each for each in results_in_units(cube)}
    if metric not in results:
        return answer
    sources = {results[metric].source, "amplitude_error"}
    beside = [each for each in results.values() if each.source in sources and each.source in answer]
    for each in beside:
        dims = answer[each.source].dims
        answer = answer.assign({each.source: (dims, each.of(answer[each.source].values), each.attributes)})
    return answer.rename({each.source: each.name for each in beside})


def place_in_units(cube: "xr.Dataset", answer: "xr.Dataset") -> "xr.Dataset":
    """Add coordinates in SI units to the point of an answer.

    Parameters
    ----------
    cube : Dataset
        The cube of the study.
    answer : Dataset
        An answer with the point as scalar coordinates.
    """
    beside = {
        each.name: ((), each.of(answer[each.source].values), each.attributes)
        for each in coordinates_in_units(cube)
        if each.source in answer.coords and answer[each.source].ndim == 0
    }
    return answer.assign_coords(beside)


def in_ratios(cube: "xr.Dataset", names: Iterable[str]) -> tuple[str, ...]:
    """Replace each name of a coordinate in SI units by the name of the corresponding ratio."""
    sources = {each.name: each.source for each in coordinates_in_units(cube)}
    return tuple(sources.get(name, name) for name in names)


def _result(variable: "xr.DataArray", quantity: InUnits) -> "xr.DataArray":
    found: xr.DataArray = variable * quantity.factor
    found.attrs = {**quantity.attributes, **of_variable_in_units(variable.attrs)}
    return found


def _quantities(cube: "xr.Dataset") -> list[InUnits]:
    return quantities_of({"physical": _physical(cube)})


def quantities_of(definition: Mapping[str, Any]) -> list[InUnits]:
    """Return all coordinates and results in SI units that follow from the physical block of a definition."""
    physical = definition.get("physical") or {}
    mass, frequency, amplitude = (_number(physical, name) for name in STRUCTURE)
    speed = 2.0 * math.pi * frequency * amplitude
    acceleration = (2.0 * math.pi * frequency) ** 2 * amplitude
    force = mass * (2.0 * math.pi * frequency) ** 2 * amplitude
    every = [
        InUnits("clearance_m", "clearance_ratio", amplitude, "m", COORDINATE_NAMES["clearance_m"]),
        InUnits("friction_force_n", "friction_ratio", force, "N", COORDINATE_NAMES["friction_force_n"]),
        InUnits("particle_mass_kg", "mass_ratio", mass, "kg", COORDINATE_NAMES["particle_mass_kg"]),
        InUnits("frequency_hz", "frequency_ratio", frequency, "Hz", COORDINATE_NAMES["frequency_hz"]),
        *(
            InUnits(name, ratio, _per_ratio(ratio, physical), CAVITY_NAMES[name][2], COORDINATE_NAMES[name])
            for ratio, name in MADE_BY.items()
        ),
        *(InUnits(name, source, amplitude, "m", RESULT_NAMES[name]) for source, name in AMPLITUDES.items()),
        *(
            InUnits(name, source, acceleration, "m s-2", RESULT_NAMES[name])
            for source, name in ACCELERATIONS.items()
        ),
        InUnits(SPEED, "impact_speed_max", speed, "m s-1", RESULT_NAMES[SPEED]),
        InUnits(ENERGY, "dissipation_per_cycle", force * amplitude, "J", RESULT_NAMES[ENERGY], 2),
    ]
    return [each for each in every if math.isfinite(each.factor)]


def _per_ratio(ratio: str, physical: Mapping[str, Any]) -> float:
    """Return the factor that converts a ratio of the cavity to its source quantity.

    The factor is NaN if another quantity in the formula of the ratio is missing or is an axis, or if the
    ratio is always 0. The factor is also NaN if the source quantity is neither proportional to the ratio nor
    a single number.
    """
    derivation = DERIVATIONS[ratio]
    given = {name: np.array(_number(physical, name)) for name in (*STRUCTURE, *physical)}
    own = 1.0 if derivation.proportional else _number(physical, derivation.source) or 1.0
    found = float(derivation.law({**given, derivation.source: np.array(own)}))
    return own / found if found else math.nan


def _physical(cube: "xr.Dataset") -> Mapping[str, Any]:
    found = json.loads(cube.attrs.get("study", "{}")).get("physical")
    return found if isinstance(found, Mapping) else {}


def _number(physical: Mapping[str, Any], name: str) -> float:
    """Return a number of the physical block, or NaN if the entry is missing or is an axis."""
    value = physical.get(name)
    return float(value) if isinstance(value, int | float) else math.nan
