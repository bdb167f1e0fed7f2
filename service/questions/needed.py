"""Imports the modules that answer questions.

A service imports this file after its start, before the first question.
"""

import numcodecs.blosc  # type: ignore[import-untyped]  # noqa: F401
import scipy.optimize  # noqa: F401
import xarray as xr

import damperlab.studies.answers.frequency_response
import damperlab.studies.answers.map_difference
import damperlab.studies.answers.phrases
import damperlab.studies.answers.ranking
import damperlab.studies.answers.resonance_map
import damperlab.studies.answers.tmd_comparison
import damperlab.studies.answers.window
import damperlab.studies.store.cube.opened  # noqa: F401

# for its first Dataset, xarray imports every installed array library, for example Dask
xr.Dataset(coords={"first": [0.0]})
