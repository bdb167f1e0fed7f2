"""Records that are generated from what a document says, by the name of the way."""

from collections.abc import Callable
from typing import Any

from damperlab.studies.ground.kanai_tajimi import read_kanai_tajimi
from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.ground.sweep_reading import read_sweep

GENERATED: dict[str, Callable[[object], GroundMotion]] = {
    "kanai_tajimi": read_kanai_tajimi,
    "sweep": read_sweep,
}
"""How each is read; every fault of a reader begins with the name."""
WRITTEN = '{"kanai_tajimi": {"seed": 1}} or {"sweep": {"start_hz": 6, …}}'
"""How a document has them."""


def recipe_in(document: dict[Any, Any]) -> str:
    """Give the way by which a document generates a record; empty where it has none, or several."""
    ways = [way for way in GENERATED if way in document]
    return ways[0] if len(ways) == 1 else ""
