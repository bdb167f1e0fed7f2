"""What a change of the OpenAPI document breaks: for a client that was written against the older one."""

from collections.abc import Iterator
from typing import Any

METHODS = ("get", "put", "post", "delete", "patch")
LOWER = (("minimum", "exclusiveMinimum"), ("minLength",), ("minItems",))
EVERYTHING = ("array", "boolean", "integer", "null", "number", "object", "string")
UPPER = (("maximum", "exclusiveMaximum"), ("maxLength",), ("maxItems",))


def breaks(old: dict[str, Any], new: dict[str, Any]) -> list[str]:
    """Say in a line each what a client of `old` can no longer do or find; what is only added breaks nobody."""
    return sorted(set(_Compared(old, new).operations()))


class _Compared:
    def __init__(self, old: dict[str, Any], new: dict[str, Any]) -> None:
        self.old, self.new = old, new
        self.under_way: set[tuple[str, str, bool]] = set()

    def operations(self) -> Iterator[str]:
        for path, operations in self.old["paths"].items():
            for method in set(operations) & set(METHODS):
                place = f"{method.upper()} {path}"
                new = self.new["paths"].get(path, {}).get(method)
                if new is None:
                    yield f"{place}: the operation is gone"
                else:
                    yield from self._operation(operations[method], new, place)

    def _operation(self, old: dict[str, Any], new: dict[str, Any], place: str) -> Iterator[str]:
        given = {(one["in"], one["name"]): one for one in old.get("parameters", ())}
        taken = {(one["in"], one["name"]): one for one in new.get("parameters", ())}
        for key in given.keys() - taken.keys():
            yield f"{place}: the parameter {key[1]} is gone"
        for key, parameter in taken.items():
            if parameter.get("required") and not given.get(key, {}).get("required"):
                yield f"{place}: the parameter {key[1]} must be given now"
            if key in given:
                where = f"{place}: {key[1]}"
                yield from self._schemas(
                    given[key].get("schema", {}), parameter.get("schema", {}), where, True
                )
        body, wanted = old.get("requestBody", {}), new.get("requestBody", {})
        if wanted.get("required") and not body.get("required"):
            yield f"{place}: a body must be sent now"
        yield from self._contents(body, wanted, f"{place}: body", True)
        for status, response in old["responses"].items():
            if not status.startswith("2"):
                continue
            if status not in new["responses"]:
                yield f"{place}: the answer {status} is gone"
                continue
            answer = new["responses"][status]
            yield from self._contents(response, answer, f"{place}: {status}", False)
            for header in response.get("headers", {}).keys() - answer.get("headers", {}).keys():
                yield f"{place}: {status}: the header {header} is gone"

    def _contents(self, old: dict[str, Any], new: dict[str, Any], place: str, sent: bool) -> Iterator[str]:
        for kind, content in old.get("content", {}).items():
            if kind not in new.get("content", {}):
                yield f"{place}: {kind} is gone"
            else:
                schema = new["content"][kind].get("schema", {})
                yield from self._schemas(content.get("schema", {}), schema, place, sent)

    def _schemas(self, old: Any, new: Any, place: str, sent: bool) -> Iterator[str]:
        """Compare what a client sends, which must not be narrowed, or what it gets, which must not be widened."""
        names = old.get("$ref", ""), new.get("$ref", ""), sent
        if names[0] and names in self.under_way:
            return
        self.under_way.add(names)
        old, new = _resolved(self.old, old), _resolved(self.new, new)
        ours, theirs = (old, new) if sent else (new, old)
        choices = _choices(ours), _choices(theirs)
        if len(choices[0]) > 1 or len(choices[1]) > 1:
            for one in choices[0]:
                tries = [
                    list(self._schemas(*((one, other) if sent else (other, one)), place, sent))
                    for other in choices[1]
                ]
                if all(tries):
                    yield from min(tries, key=len)
        else:
            yield from self._plain(old, new, place, sent)
        self.under_way.discard(names)

    def _plain(self, old: Any, new: Any, place: str, sent: bool) -> Iterator[str]:
        before, after = _types(old), _types(new)
        if (before - after if sent else after - before) and before != after:
            yield f"{place}: {_said(after)} in place of {_said(before)}"
            return
        if sent:
            yield from _narrower(old, new, place)
        elif "enum" in old and "enum" not in new:
            yield f"{place}: any value in place of {old['enum']}"
        for name in set(new.get("required", ())) - set(old.get("required", ())) if sent else ():
            yield f"{place}: {name} must be given now"
        for name in set(old.get("required", ())) - set(new.get("required", ())) if not sent else ():
            yield f"{place}: {name} may be missing now"
        for name, schema in old.get("properties", {}).items():
            if name in new.get("properties", {}):
                yield from self._schemas(schema, new["properties"][name], f"{place}: {name}", sent)
            else:
                yield f"{place}: {name} is gone"
        for key in ("items", "additionalProperties"):
            if isinstance(old.get(key), dict) and isinstance(new.get(key, {}), dict):
                yield from self._schemas(old[key], new.get(key, {}), f"{place}[]", sent)


def _narrower(old: Any, new: Any, place: str) -> Iterator[str]:
    if "enum" in new and (
        gone := set(map(str, old.get("enum", ("any value",)))) - set(map(str, new["enum"]))
    ):
        yield f"{place}: no longer {', '.join(sorted(gone))}"
    for limits, sign in ((LOWER, 1), (UPPER, -1)):
        for keys in limits:
            # an end that is left out is narrower than the same one that is not
            before, after = (
                max(
                    ((sign * each[key], key.startswith("exclusive"), key) for key in keys if key in each),
                    default=None,
                )
                for each in (old, new)
            )
            if after is not None and (before is None or after > before):
                said = "none" if before is None else f"{before[2]} {old[before[2]]}"
                yield f"{place}: {after[2]} {new[after[2]]} in place of {said}"
    if new.get("additionalProperties") is False and old.get("additionalProperties") is not False:
        yield f"{place}: unknown names are refused now"


def _resolved(document: dict[str, Any], schema: Any) -> Any:
    while "$ref" in schema:
        schema = document["components"]["schemas"][schema["$ref"].rpartition("/")[2]]
    return schema


def _choices(schema: Any) -> list[Any]:
    """Give what a schema allows one by one, whether they are schemas or types."""
    if isinstance(types := schema.get("type"), list):
        return [schema | {"type": each} for each in types]
    choices: list[Any] = schema.get("anyOf", [schema])
    return choices


def _types(schema: Any) -> frozenset[str]:
    found = schema.get("type", EVERYTHING)
    types = {found} if isinstance(found, str) else set(found)
    return frozenset(types | {"integer"} if "number" in types else types)


def _said(types: frozenset[str]) -> str:
    return "anything" if len(types) == len(EVERYTHING) else " or ".join(sorted(types))
