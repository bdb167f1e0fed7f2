"""Read the name, the definition and the excitation of a study from its cube."""

import json
from typing import TYPE_CHECKING, Any

from damperlab.studies.vocabulary import Excitation

if TYPE_CHECKING:
    import xarray as xr


def name_of(cube: "xr.Dataset") -> str:
    """Return the name of a study, or an empty text."""
    return str(cube.attrs.get("title") or definition_of(cube).get("name") or "")


def excitation_of(cube: "xr.Dataset") -> Excitation:
    """Return the excitation of the structure in a study."""
    found: Excitation = definition_of(cube).get("excitation") or "base"
    return found


def amplitude_called(cube: "xr.Dataset") -> str:
    """Name the reference length Z: the static displacement under a force, otherwise the base amplitude."""
    return "static displacement" if excitation_of(cube) == "force" else "base amplitude"


def definition_of(cube: "xr.Dataset") -> dict[str, Any]:
    """Return the definition of a study, or an empty mapping if the cube contains no definition."""
    found: dict[str, Any] = json.loads(cube.attrs.get("study", "{}"))
    return found
