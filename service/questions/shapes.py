"""What answers are made of, as types: each question puts the type of its answer together from these.

They are the truth about a document: JSON schemas are made of them, and a number that is not finite is None.
"""

from typing import Annotated, Any

from typing_extensions import TypedDict

from damperlab.studies.brief import Damper, Severity
from damperlab.studies.vocabulary import State


class Says:
    """An annotation: what the JSON schema of a type says beside what follows from the type.

    Parameters
    ----------
    **schema
        Keys of JSON schema. This class stands in for those of pydantic, which a command does not load.
    """

    def __init__(self, **schema: Any) -> None:
        self.schema = schema

    def __get_pydantic_json_schema__(self, core: Any, handler: Any) -> dict[str, Any]:
        """Give pydantic the schema."""
        return {**handler(core), **self.schema}


Count = Annotated[int, Says(minimum=0)]
Number = float | None
Numbers = list[Number]
Plane = list[list[float | str | None]]
"""Rows of values, [y][x]."""
Range = Annotated[Numbers, Says(minItems=2, maxItems=2)]
Table = Annotated[dict[str, Any], Says(description="Beside one another, by name.")]
Sentences = list[str]


class Brief(TypedDict):
    """A short answer."""

    damper: Damper | None
    sentences: Sentences
    rows: list[list[str]]
    next: str


class Note(TypedDict):
    """One thing that is known beside an answer."""

    kind: str
    severity: Severity
    values: Table


InShort = Annotated[
    Brief,
    Says(description="What to do in short: the decision, what comes second, and one next step."),
]
Notes = Annotated[
    list[Note],
    Says(
        description="What is known beside it, as data: the gravest first; values in the units of this document."
    ),
]


class Column(TypedDict):
    """What a column is; its units and its name are beside the type."""

    dtype: str


class OfStudy(TypedDict):
    """The answer to a question to one study."""

    study: str
    name: str
    state: State


class OfCube(OfStudy):
    """An answer that is read from a cube, of which a part may not be there yet."""

    complete: Annotated[float, Says(minimum=0, maximum=1, description="Share that is computed.")]
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
