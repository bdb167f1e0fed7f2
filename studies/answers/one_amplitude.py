"""Select one base amplitude of a study over base amplitudes, for questions that need a study in ratios."""

import json

import xarray as xr

from damperlab.studies.amplitudes import AMPLITUDE, CONSTANT, RATIOS_OF
from damperlab.studies.answers.excited import amplitude_called, definition_of
from damperlab.studies.answers.phrases import noted
from damperlab.studies.answers.query_fault import refused
from damperlab.studies.answers.selection import choose
from damperlab.studies.field import At
from damperlab.studies.spelling import spelled
from damperlab.studies.unit_names import RESULT_NAMES


def at_one_amplitude(cube: xr.Dataset, at: At) -> tuple[xr.Dataset, At]:
    """Return the cube of one base amplitude, and the wanted point in this cube.

    Parameters
    ----------
    cube : Dataset
        Cube of a harmonic study. A cube without a dimension of base amplitudes is returned unchanged.
    at : mapping of float
        The wanted point, with a base amplitude if the study has several base amplitudes. The nearest is taken.

    Returns
    -------
    Dataset
        Lazily computed cube over ratios. The attribute `study` is a definition with the chosen base
        amplitude. If the velocity or the acceleration of the base is constant, the ratios of a damper vary
        with the frequency. In this case, the cube keeps its dimensions, but has only the chosen base
        amplitude.
    mapping of float
        The wanted point in the returned cube. The base amplitude is left out if the returned cube has no
        dimension of base amplitudes.

    Raises
    ------
    QueryFault
        If `at` does not name the base amplitude, or its value is not a number.
    """
    if AMPLITUDE not in cube.sizes:
        return cube, at
    values = cube[AMPLITUDE].values
    if AMPLITUDE not in at and values.size > 1:
        ends = f"one base amplitude from {values[0]:g} to {values[-1]:g} m; the nearest of {values.size} is taken"
        told = f"This question is about one base amplitude, and the study has {values.size}."
        raise refused(AMPLITUDE, "nothing", ends, f"name it: `{AMPLITUDE}={values[-1]:g}`", told)
    asked = {AMPLITUDE: at[AMPLITUDE]} if AMPLITUDE in at else {}
    others = tuple(str(name) for name in cube["status"].dims if name != AMPLITUDE)
    place = choose(cube, asked, others)[AMPLITUDE]
    chosen = float(values[place])
    definition = definition_of(cube)
    if definition["physical"].get("constant") is not None:
        definition["physical"][AMPLITUDE] = [chosen]
        return cube.isel({AMPLITUDE: [place]}).assign_attrs(study=json.dumps(definition)), at
    # the encoding contains chunk sizes of the former dimensions
    part = cube.sel({AMPLITUDE: chosen}).swap_dims(RATIOS_OF).drop_encoding()
    part = part.drop_vars([*RATIOS_OF, AMPLITUDE, *(name for name in RESULT_NAMES if name in part)])
    definition["physical"][AMPLITUDE] = chosen
    part = part.assign_attrs(study=json.dumps(definition))
    return part, {name: value for name, value in at.items() if name != AMPLITUDE}


def said_of_it(answer: xr.Dataset, cube: xr.Dataset, whole: xr.Dataset) -> xr.Dataset:
    """Add the base amplitude that `at_one_amplitude` selected to the note of an answer."""
    if AMPLITUDE not in whole.sizes:
        return answer
    physical = definition_of(cube)["physical"]
    metres, constant = physical[AMPLITUDE], physical.get("constant")
    if constant is None:
        called = amplitude_called(cube).capitalize()
        first = {"note": f"{called} Z = {metres:g} m."}
        in_units = {"note": f"{called} Z = {spelled(metres, 'm', 6)}."}
    else:  # the rest of the note names the base amplitude
        power = {1: "", 2: "²"}[CONSTANT[constant]]
        first = in_units = {
            "note": f"The {constant} of the base is the same at every frequency, and Z is the base amplitude at the natural "
            f"frequency. X/Z is relative to the amplitude at each frequency, Z/r{power}."
        }
    words = {**first, "in_units": in_units}
    answer.attrs |= noted(
        words, {name: answer.attrs[name] for name in ("note", "in_units") if name in answer.attrs}
    )
    return answer
