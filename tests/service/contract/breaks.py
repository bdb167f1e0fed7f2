"""What a change of the OpenAPI document breaks: for a client that was written against the older one."""

from collections.abc import Iterator
from typing import Any

LIMITS = ("enum", "minimum", "exclusiveMinimum", "maximum", "exclusiveMaximum", "minLength", "maxLength",
          "minItems", "maxItems", "additionalProperties")  # fmt: skip
"""What narrows a schema where it did not stand before."""


def breaks(old: dict[str, Any], new: dict[str, Any]) -> list[str]:
    """Say in a line each which promise of `old` does not stand in `new`, both as `promised` gives them.

    What is only added breaks nobody. Any other change counts, also one that a client would not notice.
    """
    return sorted(set(_lost(_resolved(old, old["paths"]), _resolved(new, new["paths"]), "", False)))


def _resolved(document: dict[str, Any], part: Any, within: tuple[str, ...] = ()) -> Any:
    """Put each schema in the place of its name, but within itself, and each parameter under its name."""
    if isinstance(part, list):
        found = [_resolved(document, each, within) for each in part]
        named = all(isinstance(each, dict) and "name" in each for each in found)
        return {f"{each['in']} {each['name']}": each for each in found} if named else found
    if not isinstance(part, dict):
        return part
    name = part.get("$ref", "").rpartition("/")[2]
    if name and name not in within:
        return _resolved(document, document["components"]["schemas"][name], (*within, name))
    return {key: _resolved(document, each, within) for key, each in part.items()}


def _lost(old: Any, new: Any, place: str, sent: bool) -> Iterator[str]:
    """Compare what a client sends, of which no more may be asked, or what it gets, of which nothing may lack."""
    if isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        old, new = dict(enumerate(old)), dict(enumerate(new))
    if not (isinstance(old, dict) and isinstance(new, dict)):
        if old != new:
            yield f"{place}: {new} in place of {old}"
        return
    for key in old.keys() | new.keys():
        before, after, where = old.get(key), new.get(key), f"{place} {key}"
        if key == "required" and isinstance(before or after, list):
            names = set(after or ()) - set(before or ()) if sent else set(before or ()) - set(after or ())
            yield from (
                f"{place}: {name} {'must be given' if sent else 'may be missing'} now" for name in names
            )
        elif key == "enum" and before and after:
            gone = set(before) - set(after) if sent else ()
            yield from (f"{place}: no longer {each}" for each in gone)
        elif key == "anyOf" and sent and before and after and len(before) < len(after):
            yield from (f"{place}: no longer {each}" for each in before if each not in after)
        elif key in old and key in new:
            yield from _lost(before, after, where, sent or key in ("parameters", "requestBody"))
        elif key in old and key != "required":
            yield f"{where}: gone"
        elif (key == "required" and after) or (isinstance(after, dict) and after.get("required") is True):
            yield f"{where}: must be given now"
        elif sent and key in LIMITS:
            yield f"{where}: {after} in place of none"
