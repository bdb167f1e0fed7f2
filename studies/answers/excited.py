"""What a study is called, what excites its structure, and what its amplitude is called."""

import json
from typing import Any

import xarray as xr

from damperlab.studies.vocabulary import Excitation


def name_of(cube: xr.Dataset) -> str:
    """Give the name of a study; empty where it has none."""
    return str(cube.attrs.get("title") or definition_of(cube).get("name") or "")


def excitation_of(cube: xr.Dataset) -> Excitation:
    """Give what excites the structure in a study."""
    found: Excitation = definition_of(cube).get("excitation") or "base"
    return found


def amplitude_called(cube: xr.Dataset) -> str:
    """Name what stands for Z: under a force its static displacement."""
    return "static displacement" if excitation_of(cube) == "force" else "base amplitude"


def definition_of(cube: xr.Dataset) -> dict[str, Any]:
    """Give the definition of a study; empty where its cube has none."""
    found: dict[str, Any] = json.loads(cube.attrs.get("study", "{}"))
    return found
