"""The largest acceleration of the structure.

Under base motion it is computed without integration. In flight ü = −v − 2ζv' − γ_F sign v' [Z ω_n²], with the
displacement v from the base. It is largest while the structure moves outward: V √(1 + (2ζr)²) + γ_F for a harmonic v of
amplitude V. A particle with friction accelerates by at most κ. While it slides, the acceleration of the structure is
less by βκ; while it is carried along, it is less by the factor 1 + β. This neglects the harmonics of v and a particle
that stays on a wall. `tests/worker/test_acceleration.py` compares it with the accelerations of integrated random responses.
"""

from collections.abc import Mapping, Sequence
from math import nan, pi
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.amplitudes import AMPLITUDE
from damperlab.studies.answers.design_question import FREQUENCY, DesignQuestion
from damperlab.studies.answers.excited import definition_of, excitation_of
from damperlab.studies.answers.nearness import nearest_place
from damperlab.studies.cavity import cavity_of
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
"""Description of an acceleration of the structure with the recommended damper."""


class Acting(NamedTuple):
    """What acts on the structure, each a number or an array along the responses.

    Parameters
    ----------
    damping_ratio, friction_ratio : float or ndarray
        ζ, γ_F.
    mass_ratio, particle_friction_ratio : float or ndarray
        β, κ.
    """

    damping_ratio: Floats | float
    friction_ratio: Floats | float
    mass_ratio: Floats | float = 0.0
    particle_friction_ratio: Floats | float = 0.0


def accelerations(
    relative_amplitude: Floats, frequency_ratio: Floats, kinds: NDArray[Any], acting: Acting
) -> Floats:
    """Give the largest acceleration of a structure under base motion, whose particle meets rigid walls.

    Parameters
    ----------
    relative_amplitude, frequency_ratio : ndarray, (n,)
        Peak of |v| [Z]; r.
    kinds : ndarray, (n,)
        Classes of the responses. A structure that friction locks moves with its base.
    acting : Acting
        What acts on the structure.

    Returns
    -------
    ndarray, (n,)
        [Z ω_n²].
    """
    r, beta = frequency_ratio, acting.mass_ratio
    pulled = relative_amplitude * np.hypot(1.0, 2.0 * acting.damping_ratio * r) + acting.friction_ratio
    carried = pulled / (1.0 + beta)
    dragged = np.maximum(pulled - beta * acting.particle_friction_ratio, carried)
    moving = np.where(kinds == ResponseClass.CARRIED, carried, dragged)
    return np.where(kinds == ResponseClass.LOCKED, r**2, moving)


def acceleration_g(cube: "xr.Dataset", place: Mapping[str, int | NDArray[np.intp]]) -> float:
    """Give the largest acceleration of the structure with one damper of a study.

    Parameters
    ----------
    cube : Dataset
        Of the study.
    place : mapping
        Grid indices of the damper and of the frequencies and base amplitudes that were judged, by dimension.

    Returns
    -------
    float
        In g; that of the integration if the study stores `acceleration_ratio`. NaN if the study is in ratios, or stores
        nothing that determines it.
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
    """Give `acceleration_g` of a design on a cube's grid, over the frequencies that count."""
    place = {name: nearest_place(cube[name].values, float(design[name])) for name in question.design}
    own = cube[FREQUENCY].values
    counted = np.flatnonzero((own >= question.frequencies[0]) & (own <= question.frequencies[-1]))
    return acceleration_g(cube, {**place, FREQUENCY: counted})


def _particle_friction(cube: "xr.Dataset") -> "xr.DataArray":
    """Give κ; 0 without friction of the particle."""
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
    """Give Z ω_n² [m/s²]; NaN where the study is in ratios."""
    if AMPLITUDE in cube.coords:
        rate = 2.0 * pi * float(definition_of(cube)["physical"]["natural_frequency_hz"])
        return base_of(cube) * rate**2
    factors = {each.source: each.factor for each in quantities_of(definition_of(cube))}
    return factors.get(_MEASURED, nan)


def acceleration_row(g: float, cavity: Sequence[str] = (), whose: str = LARGEST) -> tuple[str, str, str]:
    """Spell the largest acceleration of the structure as a row.

    Parameters
    ----------
    g : float
        The acceleration in g.
    cavity : sequence of str
        Assumptions on the cavity, of `cavity.left_open`; empty without an acting particle.
    whose : str
        What is accelerated, and with which damper.
    """
    assumed = f"; assumed {', '.join(cavity)}" if cavity else ""
    return ACCELERATION, f"{g:.2g} g", whose + assumed
