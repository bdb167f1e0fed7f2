"""Types of the parts of answers: each answer composes its own type from them.

They define the documents: JSON schemas are derived from them, and a number that is not finite is None.
"""

from typing import Annotated, Any

from typing_extensions import TypedDict

from damperlab.studies.vocabulary import State


class Says:
    """An annotation: additions to the JSON schema of a type.

    Parameters
    ----------
    **schema
        Keys of JSON schema. With this class instead of those of pydantic, a command need not load pydantic.
    """

    def __init__(self, **schema: Any) -> None:
        self.schema = schema

    def __get_pydantic_json_schema__(self, core: Any, handler: Any) -> dict[str, Any]:
        """Give pydantic the schema."""
        return {**handler(core), **self.schema}


class Like:
    """An annotation: in the document the value has the form of another type, for example of a dataclass.

    Parameters
    ----------
    kind : type
        The type with that form.
    *without : str
        Fields that the document omits.
    **instead : type
        Fields with another type in the document, or only there.
    """

    def __init__(self, kind: Any, *without: str, **instead: type) -> None:
        self.kind = kind
        self.without = without
        self.instead = instead

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Give pydantic that type instead of the annotated one."""
        return handler.generate_schema(self.kind)

    def __get_pydantic_json_schema__(self, core: Any, handler: Any) -> dict[str, Any]:
        """Give pydantic the schema, under another name if fields are omitted."""
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
"""A number of a dataclass; NaN if it is missing."""
Numbers = list[Number]
Plane = list[list[float | str | None]]
"""Rows of values, [y][x]."""
Range = Annotated[Numbers, Says(minItems=2, maxItems=2)]
Table = Annotated[dict[str, Any], Says(description="Values by name.")]
Sentences = list[str]


Column = Annotated[dict[str, Any], Says(required=["dtype"], properties={"dtype": {"type": "string"}})]
"""A column: its type and its attributes."""


class OfStudy(TypedDict):
    """The answer to a question about one study."""

    study: str
    name: str
    state: State


class OfCube(OfStudy):
    """An answer from a cube, part of which may still be missing."""

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
