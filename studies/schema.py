"""The JSON schema of a study, for OpenAPI documents and editors."""

from typing import Any

from damperlab.studies.definition import Study


def study_json_schema() -> dict[str, Any]:
    """Return the JSON schema of a study. The schema has no references, so any document can embed it."""
    schema = Study.model_json_schema()
    definitions: dict[str, Any] = schema.pop("$defs", {})
    return {key: _inline(value, definitions) for key, value in schema.items()}


def _inline(part: Any, definitions: dict[str, Any]) -> Any:
    """Replace references by their targets. The models of a study must not be recursive."""
    if isinstance(part, list):
        return [_inline(item, definitions) for item in part]
    if not isinstance(part, dict):
        return part
    target = part.get("$ref")
    if isinstance(target, str):
        beside = {key: value for key, value in part.items() if key != "$ref"}
        return _inline(definitions[target.rpartition("/")[2]] | beside, definitions)
    return {key: _inline(value, definitions) for key, value in part.items()}
