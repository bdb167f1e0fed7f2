"""An annotation by which a field of a model reads its raw value with one of our functions."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, core_schema


@dataclass(frozen=True)
class Reads:
    """Validation by a function alone, which raises `StudyFaults` for a refused value.

    Pydantic's own number types are not used: they read texts and booleans as numbers, or mention unions for an axis.

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
        """Validate by the function, serialise by the type of the value."""
        return core_schema.no_info_plain_validator_function(self.function)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Return the given schema."""
        return dict(self.schema)
