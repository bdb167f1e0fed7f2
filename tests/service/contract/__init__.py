"""What clients of the HTTP interface rely on: the promises of the OpenAPI document as last released, and what breaks them."""

import json
from collections import Counter
from functools import cache
from pathlib import Path
from typing import Any

import httpx
from jsonschema import Draft202012Validator
from jsonschema.exceptions import best_match

COPY = Path(__file__).with_name("promised.json")
NOTES = Path(__file__).with_name("breaks.md")
SCHEMA_KEYS = (
    "$ref", "type", "enum", "required",
    "minimum", "exclusiveMinimum", "maximum", "exclusiveMaximum", "minLength", "maxLength", "minItems", "maxItems",
)  # fmt: skip
"""What `breaks` compares of a schema, beside the schemas within it."""
WIDTH = 160


@cache
def document_now() -> dict[str, Any]:
    """Give the document that the service has now; nobody changes it."""
    from damperlab.service.app import create_app
    from damperlab.service.settings import Settings

    document: dict[str, Any] = json.loads(json.dumps(create_app(Settings()).openapi()))
    return document


def check(method: str, path: str, answer: httpx.Response) -> None:
    """Hold an answer to the schema that the document states for it."""
    document = document_now()
    assert answer.status_code < 300, (path, answer.text)
    responses = document["paths"][path][method]["responses"]
    assert str(answer.status_code) in responses
    schema = responses[str(answer.status_code)]["content"]["application/json"]["schema"]
    # beside it the document's parts, which it refers to from the root
    whole = _closed(schema | {"components": document["components"]})
    wrong = [best_match([each]) for each in Draft202012Validator(whole).iter_errors(answer.json())]
    assert [(path, each.json_path, each.message[:300]) for each in wrong] == []


def _closed(schema: Any) -> Any:
    """Allow no field that is not described: a client of a later service may meet one, these tests may not.

    A schema with `columns` is left open: it describes an answer that has the attributes of a cube.
    """
    if isinstance(schema, list):
        return [_closed(each) for each in schema]
    if not isinstance(schema, dict):
        return schema
    found = {key: _closed(each) for key, each in schema.items()}
    described = found.get("properties", {})
    if described and "columns" not in described and isinstance(found.get("type"), str):
        found.setdefault("additionalProperties", False)
    return found


def promised(document: dict[str, Any]) -> dict[str, Any]:
    """Leave of a document what programs rely on: no prose, examples or defaults, and no refusals."""
    paths = {
        path: {method: _operation(each) for method, each in operations.items()}
        for path, operations in document["paths"].items()
    }
    schemas = {name: _schema(each) for name, each in document["components"]["schemas"].items()}
    return {"paths": paths, "components": {"schemas": schemas}}


def promised_before() -> dict[str, Any]:
    """Give the copy."""
    document: dict[str, Any] = json.loads(COPY.read_text())
    return document


def keep(document: dict[str, Any]) -> None:
    """Write the copy, in which a long schema stands once."""
    COPY.write_text(_laid_out(_once(promised(document))) + "\n")


def _operation(operation: dict[str, Any]) -> dict[str, Any]:
    parameters = [
        {"in": each["in"], "name": each["name"], "schema": _schema(each["schema"])}
        | ({"required": True} if each.get("required") else {})
        for each in operation.get("parameters", ())
    ]
    responses = {
        status: _given(_contents(each) | {"headers": {name: {} for name in each.get("headers", {})}})
        for status, each in operation["responses"].items()
        if status.startswith("2")
    }
    body = operation.get("requestBody", {})
    sent = _contents(body) | ({"required": True} if body.get("required") else {})
    return _given({"parameters": parameters, "requestBody": _given(sent)}) | {"responses": responses}


def _given(parts: dict[str, Any]) -> dict[str, Any]:
    return {name: part for name, part in parts.items() if part}


def _contents(holder: dict[str, Any]) -> dict[str, Any]:
    contents = holder.get("content", {}).items()
    return {"content": {kind: {"schema": _schema(each.get("schema", {}))} for kind, each in contents}}


def _schema(schema: dict[str, Any]) -> dict[str, Any]:
    found = {key: schema[key] for key in SCHEMA_KEYS if key in schema}
    if "properties" in schema:
        found["properties"] = {name: _schema(each) for name, each in schema["properties"].items()}
    if "anyOf" in schema:
        found["anyOf"] = [_schema(each) for each in schema["anyOf"]]
    for key in ("items", "additionalProperties"):
        if key in schema:
            found[key] = _schema(schema[key]) if isinstance(schema[key], dict) else schema[key]
    return found


def _once(promises: dict[str, Any]) -> dict[str, Any]:
    """Give a schema that takes several lines at several places a name, that of its first place, and refer to it there."""
    schemas = promises["components"]["schemas"]
    places: Counter[str] = Counter()
    names: dict[str, str] = {}
    named: dict[str, Any] = {}

    def text(part: Any) -> str:
        return json.dumps(part, sort_keys=True)

    def count(part: Any) -> None:
        if isinstance(part, list):
            for each in part:
                count(each)
        elif isinstance(part, dict):
            places[text(part)] += 1
            if places[text(part)] == 1:
                count(list(part.values()))

    def within(part: Any, place: str) -> Any:
        """Refer to the schemas within a schema, or within what holds some."""
        if isinstance(part, list):
            return [put(each, place) for each in part]
        if not isinstance(part, dict):
            return part
        fields = {name: put(each, f"{place}.{name}") for name, each in part.get("properties", {}).items()}
        rest = {key: put(each, place) for key, each in part.items() if key != "properties"}
        return rest | ({"properties": fields} if fields else {})

    def put(part: Any, place: str) -> Any:
        whole = text(part)
        if places[whole] < 2 or len(whole) <= WIDTH or not part.keys() & {"type", "anyOf"}:
            return within(part, place)
        if whole not in names:
            names[whole] = f"{place} {len(named)}" if place in schemas.keys() | named.keys() else place
            named[names[whole]] = None  # for what it holds has another name
            named[names[whole]] = within(part, place)
        return {"$ref": f"#/components/schemas/{names[whole]}"}

    count(promises)
    referring = {name: within(each, name) for name, each in schemas.items()}
    return {"paths": within(promises["paths"], "Route"), "components": {"schemas": referring | named}}


def _laid_out(value: Any, indent: str = "") -> str:
    """Write JSON a line for each parameter and field: what fits, and each list of words, is in one line."""
    line = json.dumps(value, sort_keys=True, ensure_ascii=False)
    words = isinstance(value, list) and not any(isinstance(each, dict) for each in value)
    if len(indent + line) <= WIDTH or words or not isinstance(value, dict | list):
        return line
    inner = indent + " "
    if isinstance(value, dict):
        parts = [f"{json.dumps(key)}: {_laid_out(each, inner)}" for key, each in sorted(value.items())]
    else:
        parts = [_laid_out(each, inner) for each in value]
    return f"{line[0]}\n{inner}" + f",\n{inner}".join(parts) + f"\n{indent}{line[-1]}"
