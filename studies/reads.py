"""An annotation that makes a model's field read its raw value through one function of ours."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, core_schema


@dataclass(frozen=True)
class Reads:
    """Validation by a function alone, which raises `StudyFaults` for what it refuses.

    Pydantic's own number types are not asked: they read texts and booleans as numbers, or speak of unions
    where a user wrote an axis.

    Parameters
    ----------
    function : callable
        From the raw value to the field's value.
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
        """Return the schema that was given."""
        return dict(self.schema)
