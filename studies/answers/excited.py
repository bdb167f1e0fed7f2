"""What excites the structure of a study, and what its amplitude is called."""

import json

import xarray as xr

from damperlab.studies.vocabulary import Excitation


def excitation_of(cube: xr.Dataset) -> Excitation:
    """Give what excites the structure in a study."""
    found: Excitation = json.loads(cube.attrs.get("study", "{}")).get("excitation") or "base"
    return found


def amplitude_called(cube: xr.Dataset) -> str:
    """Name what stands for Z: under a force its static displacement."""
    return "static displacement" if excitation_of(cube) == "force" else "base amplitude"
