"""Generates records from a document, by the name of the method."""

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
from damperlab.studies.ground.sweep import Sweep
from damperlab.studies.ground.sweep_reading import sweep_of, sweep_schema
from damperlab.studies.quantity import read_count

Recipe = Sweep | RandomVibration | Shock
"""Methods whose definition itself describes the base motion."""
RECIPES: dict[str, Callable[[object], Recipe]] = {
    "sweep": sweep_of,
    "random_vibration": random_vibration_of,
    "shock": shock_of,
}
"""Reader of each method whose definition describes the base motion; it makes no samples yet."""


def _generate(way: str, document: object) -> GroundMotion:
    recipe = RECIPES[way](document)
    return checked(recipe.motion(document.get("name", "") if isinstance(document, dict) else ""), way)


GENERATED: dict[str, Callable[[object], GroundMotion]] = {
    "kanai_tajimi": read_kanai_tajimi,
    **{way: partial(_generate, way) for way in RECIPES},
}
"""Generator of each method; every fault of its reader begins with the name of the method."""
SCHEMAS: dict[str, dict[str, Any]] = {
    "kanai_tajimi": kanai_tajimi_schema(),
    "sweep": sweep_schema(),
    "random_vibration": random_vibration_schema(),
    "shock": shock_schema(),
}
"""JSON schema of each method."""
WRITTEN = '{"kanai_tajimi": {"seed": 1}} or one of sweep, random_vibration and shock with its keys'
"""How a generated record is written in a document, for messages."""
SEEDED = ("kanai_tajimi", "random_vibration")
"""Methods that draw random numbers."""
MOST_SEEDS = 100
SEEDS_SCHEMA = {"type": "integer", "minimum": 1, "maximum": MOST_SEEDS, "default": 1}
LISTED_SCHEMAS = {
    way: schema | {"properties": schema["properties"] | ({"seeds": SEEDS_SCHEMA} if way in SEEDED else {})}
    for way, schema in SCHEMAS.items()
}
"""JSON schema of each method for an entry of a list, which may stand for several records."""


def recipe_in(document: dict[Any, Any]) -> str:
    """Give the method that a document uses to generate a record; empty if it has none, or several."""
    ways = [way for way in GENERATED if way in document]
    return ways[0] if len(ways) == 1 else ""


def same_process(recipe: str, other: str) -> bool:
    """Whether two recipes, of `RecordSource`, draw from one random process: they differ in their seeds alone."""
    if not recipe or not other:
        return False
    (way, one), (other_way, another) = (next(iter(json.loads(each).items())) for each in (recipe, other))
    return way in SEEDED and way == other_way and one | {"seed": 0} == another | {"seed": 0}


def each_of(entry: object) -> tuple[list[object], list[Fault]]:
    """Give the records that one entry of a list stands for: `seeds` is their number, and their seeds count up from
    `seed`.

    Returns
    -------
    entries : list
        Entries with one seed each.
    faults : list of Fault
        If `seeds` is not a count.
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
        # the reader refuses a seed that is not a whole number
        return [entry | {way: one}], faults
    return [entry | {way: one | {"seed": first + place}} for place in range(count)], faults
