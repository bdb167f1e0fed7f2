"""Both registries of result variables, found by the dimensions of a cube."""

from collections.abc import Container, Mapping
from typing import Any

from damperlab.studies.ground.variables import DIMENSIONS as SURVEY_DIMENSIONS
from damperlab.studies.ground.variables import RECORD
from damperlab.studies.ground.variables import VARIABLES as SURVEY_VARIABLES
from damperlab.studies.variables import DIMENSIONS, VARIABLES, Variable

EVERY_DIMENSION: tuple[str, ...] = tuple(dict.fromkeys((*DIMENSIONS, *SURVEY_DIMENSIONS)))
EVERY_VARIABLE: tuple[str, ...] = tuple(dict.fromkeys((*VARIABLES, *SURVEY_VARIABLES)))


def is_survey(dimensions: Container[Any]) -> bool:
    """Whether a cube of these dimensions is a survey's: only that has records."""
    return RECORD in dimensions


def variables_of(dimensions: Container[Any]) -> Mapping[str, Variable]:
    """Give the registry of the variables over these dimensions."""
    return SURVEY_VARIABLES if is_survey(dimensions) else VARIABLES


def dimensions_of_definition(definition: Container[Any]) -> tuple[str, ...]:
    """Give the dimensions of a study by its definition, in the cube's order: a survey names its records."""
    return tuple(SURVEY_DIMENSIONS) if "records" in definition else DIMENSIONS
