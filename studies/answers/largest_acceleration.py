"""The largest acceleration of the structure.

Under base motion the acceleration is estimated from the displacement amplitude, without integration. While the
particle is in free flight, ü = −v − 2ζv' − γ_F sign v' [Z ω_n²], where v is the displacement relative to the base.
If v is harmonic with the amplitude V, the largest |ü| is V √(1 + (2ζr)²) + γ_F. Friction accelerates the particle
by at most κ. While the particle slides, the acceleration of the structure is smaller by βκ. While the particle
moves with the structure, the acceleration is smaller by the factor 1 + β. The estimate neglects two effects: the
higher harmonics of v, and a particle that stays on a wall. `tests/worker/test_acceleration.py` checks the estimate
against integrated responses.
"""

from collections.abc import Mapping, Sequence
from math import isfinite, nan, pi
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.amplitudes import AMPLITUDE
from damperlab.studies.answers.design_question import DesignQuestion
from damperlab.studies.answers.excited import definition_of, excitation_of
from damperlab.studies.answers.phrases import FREQUENCY
from damperlab.studies.cavity import cavity_of, left_open
from damperlab.studies.physical import STANDARD_GRAVITY
from damperlab.studies.quantity import OF_CAVITY
from damperlab.studies.units import base_of, quantities_of
from damperlab.studies.variables import PARTICLE_FRICTION, ResponseClass

if TYPE_CHECKING:
    import xarray as xr

_MEASURED, _RELATIVE, _CLASS = "acceleration_ratio", "relative_amplitude_ratio", "response_class"
Floats = NDArray[np.float64]
ACCELERATION = "acceleration"
"""Name of the row of a short answer that states the largest acceleration."""
LARGEST = "largest of the structure"
"""Text that follows the acceleration of the structure with the recommended damper."""


class Acting(NamedTuple):
    """Ratios of the structure and its damper that determine the acceleration.

    Each ratio is a number, or an array with one value per response.

    Parameters
    ----------
    damping_ratio, friction_ratio : float or ndarray
        Damping ratio ζ and friction ratio γ_F of the structure.
    mass_ratio, particle_friction_ratio : float or ndarray
        Mass ratio β and friction ratio κ of the particle.
    """

    damping_ratio: Floats | float
    friction_ratio: Floats | float
    mass_ratio: Floats | float = 0.0
    particle_friction_ratio: Floats | float = 0.0


def accelerations(
    relative_amplitude: Floats, frequency_ratio: Floats, kinds: NDArray[Any], acting: Acting
) -> Floats:
    """Return the largest acceleration of a structure under base motion with a particle between rigid walls.

    Parameters
    ----------
    relative_amplitude, frequency_ratio : ndarray, (n,)
        Largest |v| [Z], and frequency ratio r.
    kinds : ndarray, (n,)
        Classes of the responses. A locked structure moves with the base.
    acting : Acting
        Ratios of the structure and its damper.

    Returns
    -------
    ndarray, (n,)
        Largest acceleration of each response [Z ω_n²].
    """
    r, beta = frequency_ratio, acting.mass_ratio
    pulled = relative_amplitude * np.hypot(1.0, 2.0 * acting.damping_ratio * r) + acting.friction_ratio
    carried = pulled / (1.0 + beta)
    dragged = np.maximum(pulled - beta * acting.particle_friction_ratio, carried)
    moving = np.where(kinds == ResponseClass.CARRIED, carried, dragged)
    return np.where(kinds == ResponseClass.LOCKED, r**2, moving)


def acceleration_g(cube: "xr.Dataset", place: Mapping[str, int | NDArray[np.intp]]) -> float:
    """Return the largest acceleration of the structure with one damper of a study.

    Parameters
    ----------
    cube : Dataset
        The cube of the study.
    place : mapping
        Grid indices of the damper and of the judged frequencies and base amplitudes, by dimension.

    Returns
    -------
    float
        Acceleration in g, from the stored `acceleration_ratio` if the study has it. NaN if the study is given in ratios
        alone, or stores no results that determine the acceleration.
    """
    import xarray as xr

    model = (definition_of(cube).get("contact") or {}).get("model", "instant")
    if _MEASURED in cube:
        there = cube[[_MEASURED]].isel(place)
        ratios = there[_MEASURED]
    elif {_RELATIVE, _CLASS} <= cube.keys() and excitation_of(cube) == "base" and model == "instant":
        there = cube[[_RELATIVE, _CLASS]].isel(place)
        acting = (
            there["damping_ratio"],
            there["friction_ratio"],
            there["mass_ratio"],
            _particle_friction(there),
        )
        along = xr.broadcast(there[_RELATIVE], there[FREQUENCY], there[_CLASS], *acting)
        found, r, kinds, *others = (each.values for each in along)
        ratios = along[0].copy(data=accelerations(found, r, kinds, Acting(*others)))
    else:
        return nan
    return float((ratios * _unit(there)).max()) / STANDARD_GRAVITY


def acceleration_of(design: Mapping[str, Any], question: DesignQuestion, cube: "xr.Dataset") -> float:
    """Return `acceleration_g` of a design, over all frequencies of the cube within the judged band."""
    own = cube[FREQUENCY].values
    counted = np.flatnonzero((own >= question.frequencies[0]) & (own <= question.frequencies[-1]))
    return acceleration_g(cube, {**question.place_of(design, cube), FREQUENCY: counted})


def _particle_friction(cube: "xr.Dataset") -> "xr.DataArray":
    """Return the friction ratio κ of the particle, or 0 if the particle has no friction."""
    import xarray as xr

    if PARTICLE_FRICTION in cube.coords:
        return cube[PARTICLE_FRICTION]
    if AMPLITUDE not in cube.coords:
        return xr.DataArray(0.0)
    physical = definition_of(cube)["physical"]
    cavity = cavity_of({each.name: physical.get(each.name) for each in OF_CAVITY})
    case = {"natural_frequency_hz": float(physical["natural_frequency_hz"]), "base_amplitude_m": 1.0}
    at_one_metre = cavity.ratio(PARTICLE_FRICTION, case)
    found: xr.DataArray = at_one_metre / base_of(cube)
    return found


def _unit(cube: "xr.Dataset") -> "xr.DataArray | float":
    """Return Z ω_n² [m/s²], or NaN if the study is given in ratios alone."""
    if AMPLITUDE in cube.coords:
        rate = 2.0 * pi * float(definition_of(cube)["physical"]["natural_frequency_hz"])
        return base_of(cube) * rate**2
    factors = {each.source: each.factor for each in quantities_of(definition_of(cube))}
    return factors.get(_MEASURED, nan)


def acceleration_rows(
    g: float, cube: "xr.Dataset", acts: bool, beaten: bool = False
) -> list[tuple[str, str, str]]:
    """Return the row of a short answer with the acceleration of a damper of a study; no row if it is unknown.

    If the damper has a moving particle, the row contains the assumptions about its cavity. `beaten` states whether a
    tuned mass damper is recommended instead.
    """
    if not isfinite(g):
        return []
    cavity = left_open(definition_of(cube)) if acts else []
    return [acceleration_row(g, cavity, "with the study's damper" if beaten else LARGEST)]


def acceleration_row(g: float, cavity: Sequence[str] = (), whose: str = LARGEST) -> tuple[str, str, str]:
    """Write the largest acceleration of the structure as a row of a short answer.

    Parameters
    ----------
    g : float
        The acceleration in g.
    cavity : sequence of str
        Assumptions about the cavity, from `cavity.left_open`. Empty if the damper works without the particle.
    whose : str
        Text that follows the acceleration, such as "with the study's damper".
    """
    assumed = f"; assumed {', '.join(cavity)}" if cavity else ""
    return ACCELERATION, f"{g:.2g} g", whose + assumed
