"""Types for several kinds of answers.

JSON schemas of answers are derived from these types. In a document, a number that is not finite is None.
"""

from typing import Annotated, Any

from typing_extensions import TypedDict

from damperlab.studies.vocabulary import State


class Says:
    """An annotation that adds keys to the JSON schema of a type, without importing pydantic.

    Parameters
    ----------
    **schema
        Keys of the JSON schema.
    """

    def __init__(self, **schema: Any) -> None:
        self.schema = schema

    def __get_pydantic_json_schema__(self, core: Any, handler: Any) -> dict[str, Any]:
        """Return the JSON schema of the type with the additional keys."""
        return {**handler(core), **self.schema}


class Like:
    """An annotation for a value that a document contains in the form of another type.

    Parameters
    ----------
    kind : type
        The type that determines the form in the document.
    *without : str
        Fields that the document omits.
    **instead : type
        Types of fields with a different type in the document, and of fields that exist only in the document.
    """

    def __init__(self, kind: Any, *without: str, **instead: type) -> None:
        self.kind = kind
        self.without = without
        self.instead = instead

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Return the schema of `kind`, instead of the schema of the annotated type."""
        return handler.generate_schema(self.kind)

    def __get_pydantic_json_schema__(self, core: Any, handler: Any) -> dict[str, Any]:
        """Return the JSON schema of `kind`, without the fields in `without`, and with the fields in `instead`."""
        found = handler(core)
        if not (self.without or self.instead):
            return dict(found)
        from pydantic import TypeAdapter

        whole = handler.resolve_ref_schema(found)
        left = {name: each for name, each in whole["properties"].items() if name not in self.without}
        left |= {name: TypeAdapter(kind).json_schema() for name, kind in self.instead.items()}
        about = {key: value for key, value in whole.items() if key not in ("title", "description")}
        always = dict.fromkeys((*whole["required"], *self.instead))
        return {**about, "properties": left, "required": [name for name in always if name in left]}


Count = Annotated[int, Says(minimum=0)]
Number = float | None
Measured = Annotated[float, Says(type=["number", "null"])]
"""A number in a dataclass. A missing number is NaN in the dataclass and None in the document."""
Numbers = list[Number]
Plane = list[list[float | str | None]]
"""Rows of values, [y][x]."""
Range = Annotated[Numbers, Says(minItems=2, maxItems=2)]
Table = Annotated[dict[str, Any], Says(description="Values by name.")]
Sentences = list[str]


Column = Annotated[dict[str, Any], Says(required=["dtype"], properties={"dtype": {"type": "string"}})]
"""Type and attributes of a column."""


class OfStudy(TypedDict):
    """The answer to a question about one study."""

    study: str
    name: str
    state: State


class OfCube(OfStudy):
    """An answer from a cube that may still be incomplete."""

    complete: Annotated[float, Says(minimum=0, maximum=1, description="Share that has been computed.")]
    note: str
    columns: dict[str, Column]


class OfPoints(OfCube):
    """An answer that shows points of a cube."""

    points: Count
    points_failed: Count
    at: dict[str, float | str | None]
    meanings: dict[str, dict[str, str]]


class OfMetric(OfPoints):
    """An answer that shows one result."""

    metric: str
    units: str
    long_name: str
