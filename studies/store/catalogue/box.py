"""The box that a study's grid fills: by it the catalogue finds studies that may share points."""

from typing import Any

from damperlab.studies.kind import AnyStudy


def box_of(study: AnyStudy) -> list[list[Any]]:
    """Give the lowest and the highest value along every dimension of numbers, in the cube's order."""
    return [
        [float(values[0]), float(values[-1])]
        for values in study.coordinates.values()
        if values.dtype.kind == "f"
    ]
