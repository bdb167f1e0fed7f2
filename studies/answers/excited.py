"""A study's name, its excitation, and the name of its amplitude."""

import json
from typing import TYPE_CHECKING, Any

from damperlab.studies.vocabulary import Excitation

if TYPE_CHECKING:
    import xarray as xr


def name_of(cube: "xr.Dataset") -> str:
    """Give the name of a study; empty if it has none."""
    return str(cube.attrs.get("title") or definition_of(cube).get("name") or "")


def excitation_of(cube: "xr.Dataset") -> Excitation:
    """Give the excitation of the structure in a study."""
    found: Excitation = definition_of(cube).get("excitation") or "base"
    return found


def amplitude_called(cube: "xr.Dataset") -> str:
    """Name the reference length Z: under a force the static displacement."""
    return "static displacement" if excitation_of(cube) == "force" else "base amplitude"


def definition_of(cube: "xr.Dataset") -> dict[str, Any]:
    """Give the definition of a study; empty if its cube has none."""
    found: dict[str, Any] = json.loads(cube.attrs.get("study", "{}"))
    return found
