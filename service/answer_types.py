"""JSON schemas of the answers, made from the types that routes declare.

Each type is a TypedDict or a dataclass (`damperlab.studies.shapes.Like`), defined in the module that computes the answer.
The service does not validate answers, because most of their content is arrays. Tests check the types.
"""

from typing import Any, get_args

from pydantic import TypeAdapter
from typing_extensions import TypeAliasType

Schema = dict[str, Any]

_REFERENCE = "#/components/schemas/"
_declared: dict[str, Any] = {}


def gives(kind: Any, description: str = "The answer", **headers: str) -> Schema:
    """Declare the type of an answer, and return the OpenAPI description of the response.

    Parameters
    ----------
    kind : type
        A TypedDict or an alias (`TypeAliasType`). The schema gets the name of this type.
    description : str
        Meaning of the response.
    **headers : str
        Meaning of each response header; underscores in the names stand for hyphens.
    """
    declare(kind, *get_args(getattr(kind, "__value__", None)))
    content = {"application/json": {"schema": {"$ref": _REFERENCE + name_of(kind)}}}
    declared: Schema = {"description": description, "content": content}
    if headers:
        declared["headers"] = {
            key.replace("_", "-"): {"description": text, "schema": {"type": "string"}}
            for key, text in headers.items()
        }
    return declared


def declare(*kinds: Any) -> None:
    """Register types. Each registered type gets a separate schema, to which other schemas refer."""
    for kind in kinds:
        if isinstance(kind, type | TypeAliasType) and _declared.setdefault(name_of(kind), kind) is not kind:
            raise ValueError(f"two types of answers have one name: {name_of(kind)}")


def name_of(kind: Any) -> str:
    """Return the name of a type's schema, which is the name of the type without the ending `Document`."""
    return str(kind.__name__).removesuffix("Document")


def declared_schemas() -> dict[str, Schema]:
    """Return the schemas of all types that routes have declared, by name."""
    return {name: schema_of(kind) for name, kind in _declared.items()}


def schema_of(kind: Any) -> Schema:
    """Return the JSON schema of a type, without titles and docstrings, and with references only to declared types."""
    found = TypeAdapter(list[kind]).json_schema(mode="serialization")
    parts, own = found.get("$defs", {}), found["items"]
    while own.keys() == {"$ref"}:
        own = _undocumented(parts[own["$ref"].rpartition("/")[2]])
    schema: Schema = _whole(own, parts)
    return schema


def _undocumented(part: Schema) -> Schema:
    return {key: value for key, value in part.items() if key not in ("title", "description")}


def _whole(schema: Any, parts: Schema) -> Any:
    """Replace references to undeclared types by the schemas of these types, and write alternative types as a list."""
    if isinstance(schema, list):
        return [_whole(each, parts) for each in schema]
    if not isinstance(schema, dict):
        return schema
    about = {key: value for key, value in schema.items() if not (key == "title" and isinstance(value, str))}
    if (reference := about.pop("$ref", None)) is not None:
        part = reference.rpartition("/")[2]
        if part in (kind.__name__ for kind in _declared.values()):
            return {"$ref": _REFERENCE + part.removesuffix("Document"), **about}
        about = _undocumented(parts[part]) | about
    if "const" in about:
        about["enum"] = [about.pop("const")]
    if about.get("additionalProperties") is True and "properties" not in about:
        del about["additionalProperties"]
    found = {key: _whole(value, parts) for key, value in about.items()}
    choices = found.get("anyOf", ())
    if choices and all(each.keys() == {"type"} for each in choices):
        del found["anyOf"]
        found["type"] = [each["type"] for each in choices]
    return found
