"""A design point whose end state `tests/reference/states.json` keeps."""

from __future__ import annotations

from typing import Any, NamedTuple


class Point(NamedTuple):
    """One design point and the excitation cycles to run it from rest.

    ``particle`` is (clearance ratio, restitution, mass ratio), or None for a scene without one.
    """

    scene: str
    damping_ratio: float
    frequency_ratio: float
    friction_ratio: float
    particle: tuple[float, float, float] | None
    cycles: int


def point_of(record: dict[str, Any]) -> Point:
    """Read the point of a record of `states.json`."""
    particle = record["particle"] and tuple(record["particle"].values())
    return Point(**{name: record[name] for name in Point._fields} | {"particle": particle})
