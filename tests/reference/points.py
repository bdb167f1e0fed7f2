"""The design points whose end states `tests/reference/states.json` keeps."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Point:
    """One design point: (clearance ratio, restitution, mass ratio) or None, and the cycles to run from rest."""

    scene: str
    damping_ratio: float
    frequency_ratio: float
    friction_ratio: float
    particle: tuple[float, float, float] | None
    cycles: int


FIRST = [
    Point("linear", 0.0038, 1.0, 0.0, None, 10),
    Point("linear", 0.0, 1.0, 0.0, None, 20),
    Point("linear", 0.3, 0.1, 0.0, None, 5),
    Point("slip", 0.0038, 1.0, 0.6, None, 10),
    Point("slip", 0.05, 1.5, 0.3, None, 10),
    Point("stick", 0.0038, 0.5, 0.2, None, 10),
    Point("stick", 0.0038, 0.9, 0.7, None, 20),
    Point("stick", 0.0038, 1.0, 0.8, None, 20),
    Point("particle", 0.0038, 1.0, 0.0, (10.0, 0.47, 0.1), 10),
    Point("particle", 0.0038, 1.1, 0.0, (3.0, 0.82, 0.1), 10),
    Point("particle", 0.0, 1.0, 0.0, (5.0, 1.0, 0.05), 10),
    Point("particle", 0.1, 0.7, 0.0, (0.5, 0.1, 1.0), 10),
    Point("hybrid", 0.0038, 1.0, 0.4, (5.0, 0.47, 0.1), 10),
    Point("hybrid", 0.0038, 1.0, 0.6, (2.0, 0.47, 0.1), 10),
    Point("hybrid-stick", 0.0038, 0.9, 0.6, (2.0, 0.47, 0.1), 10),
    Point("hybrid-stick", 0.0038, 1.0, 0.8, (0.5, 0.47, 0.1), 10),
    Point("chatter", 0.0038, 0.9, 0.6, (0.5, 0.1, 0.1), 10),
    Point("chatter", 0.0038, 1.0, 0.0, (1.0, 0.47, 0.1), 10),
    Point("chatter", 0.0038, 1.2, 0.3, (0.7, 0.0, 0.2), 10),
    Point("attached-stick", 0.0038, 0.5, 0.2, (0.5, 0.0, 0.1), 10),
    Point("attached-stick", 0.05, 0.8, 0.5, (0.3, 0.47, 0.3), 10),
    Point("fast", 0.0038, 5.0, 0.6, (1.0, 0.47, 0.1), 20),
]

POINTS = FIRST
