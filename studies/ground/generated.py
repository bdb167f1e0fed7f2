"""Generates records from a document that names the method, such as a sweep or a shock."""

import json
from collections.abc import Callable
from functools import partial
from typing import Any

from damperlab.studies.faults import Fault, attempt
from damperlab.studies.ground.kanai_tajimi import kanai_tajimi_schema, read_kanai_tajimi
from damperlab.studies.ground.motion import GroundMotion, checked
from damperlab.studies.ground.random_vibration import (
    RandomVibration,
    random_vibration_of,
    random_vibration_schema,
)
from damperlab.studies.ground.shock import Shock, shock_of, shock_schema
from damperlab.studies.ground.sweep import Sweep, sweep_of, sweep_schema
from damperlab.studies.quantity import read_count

Recipe = Sweep | RandomVibration | Shock
"""Definition of a generated record."""
RECIPES: dict[str, Callable[[object], Recipe]] = {
    "sweep": sweep_of,
    "random_vibration": random_vibration_of,
    "shock": shock_of,
}
"""For each method, the function that reads a `Recipe` without generating samples."""


def _generate(way: str, document: object) -> GroundMotion:
    recipe = RECIPES[way](document)
    return checked(recipe.motion(document.get("name", "") if isinstance(document, dict) else ""), way)


GENERATED: dict[str, Callable[[object], GroundMotion]] = {
    "kanai_tajimi": read_kanai_tajimi,
    **{way: partial(_generate, way) for way in RECIPES},
}
"""For each method, the function that generates a record.

The field of every fault begins with the name of the method.
"""
SCHEMAS: dict[str, dict[str, Any]] = {
    "kanai_tajimi": kanai_tajimi_schema(),
    "sweep": sweep_schema(),
    "random_vibration": random_vibration_schema(),
    "shock": shock_schema(),
}
"""JSON schema of the document of each method."""
WRITTEN = '{"kanai_tajimi": {"seed": 1}} or one of sweep, random_vibration and shock with its keys'
"""Part of a message: how a document defines a generated record."""
SEEDED = ("kanai_tajimi", "random_vibration")
"""Methods that draw random numbers."""
MOST_SEEDS = 100
SEEDS_SCHEMA = {"type": "integer", "minimum": 1, "maximum": MOST_SEEDS, "default": 1}
LISTED_SCHEMAS = {
    way: schema | {"properties": schema["properties"] | ({"seeds": SEEDS_SCHEMA} if way in SEEDED else {})}
    for way, schema in SCHEMAS.items()
}
"""JSON schema of each method in a list of records, where an entry with `seeds` stands for several records."""


def recipe_in(document: dict[Any, Any]) -> str:
    """Return the method by which a document generates a record; empty unless it states exactly one method."""
    ways = [way for way in GENERATED if way in document]
    return ways[0] if len(ways) == 1 else ""


def same_process(recipe: str, other: str) -> bool:
    """Return whether two values of `RecordSource.recipe` define the same random process, apart from the seed."""
    if not recipe or not other:
        return False
    (way, one), (other_way, another) = (next(iter(json.loads(each).items())) for each in (recipe, other))
    return way in SEEDED and way == other_way and one | {"seed": 0} == another | {"seed": 0}


def each_of(entry: object) -> tuple[list[object], list[Fault]]:
    """Expand an entry of a list into one entry for each seed.

    `seeds` is the number of entries. Their seeds are `seed`, `seed` + 1, and so on.

    Returns
    -------
    entries : list
        Entries with one seed each.
    faults : list of Fault
        A fault if `seeds` is not a valid count; otherwise empty.
    """
    way = recipe_in(entry) if isinstance(entry, dict) else ""
    if not isinstance(entry, dict) or way not in SEEDED or not isinstance(entry[way], dict):
        return [entry], []
    one = {key: value for key, value in entry[way].items() if key != "seeds"}
    faults: list[Fault] = []
    count = attempt(lambda: read_count(entry[way].get("seeds", 1), 1, MOST_SEEDS, f"{way}.seeds"), 1, faults)
    first = one.get("seed", 0)
    first = int(first) if isinstance(first, float) and first.is_integer() else first
    if count == 1 or isinstance(first, bool) or not isinstance(first, int):
        # the fault is reported when the entry is read
        return [entry | {way: one}], faults
    return [entry | {way: one | {"seed": first + place}} for place in range(count)], faults
