"""An annotation for fields of pydantic models: a function of this package reads the raw value."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, core_schema


@dataclass(frozen=True)
class Reads:
    """Validation of a field by a function that raises `StudyFaults` for an invalid value.

    The number types of pydantic are not used, because they accept texts and booleans.

    Parameters
    ----------
    function : callable
        Function from the raw value to the field's value.
    schema : dict
        JSON schema of the raw value.
    """

    function: Callable[[object], Any]
    schema: dict[str, Any] = field(hash=False)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Return a schema that validates a value with `function`, and serialises the value by its type."""
        return core_schema.no_info_plain_validator_function(self.function)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Return the given schema."""
        return dict(self.schema)
