"""What the columns of an answer are: type, unit and name of each, so that a program can rebuild the Dataset."""

from typing import Any

import xarray as xr


def columns(answer: xr.Dataset) -> dict[str, dict[str, Any]]:
    """Describe every variable and coordinate of an answer.

    Parameters
    ----------
    answer : Dataset
        Of `damperlab.studies.answers`.

    Returns
    -------
    dict
        By name: ``dtype`` as numpy spells it, and the attributes, ``units`` and ``long_name`` among them.
    """
    return {str(name): {"dtype": array.dtype.str, **array.attrs} for name, array in answer.variables.items()}
