"""The design points whose end states `tests/reference/states.json` keeps."""

from __future__ import annotations

from typing import NamedTuple


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


POINTS = [
    Point("linear", 0.0038, 1.0, 0.0, None, 10),
    Point("linear", 0.0, 1.0, 0.0, None, 20),
    Point("linear", 0.3, 0.1, 0.0, None, 5),
    Point("linear", 0.9, 0.5, 0.0, None, 5),
    Point("linear", 0.0, 0.999, 0.0, None, 20),
    Point("linear", 0.0038, 20.0, 0.0, None, 20),
    Point("slip", 0.0038, 1.0, 0.6, None, 10),
    Point("slip", 0.05, 1.5, 0.3, None, 10),
    Point("slip", 0.0, 1.0, 0.7853981633974483, None, 20),
    Point("slip", 0.0, 1.0, 0.2, None, 10),
    Point("slip", 0.1, 5.0, 1.2, None, 10),
    Point("stick", 0.0038, 0.5, 0.2, None, 10),
    Point("stick", 0.0038, 0.9, 0.7, None, 20),
    Point("stick", 0.0038, 1.0, 0.8, None, 20),
    Point("stick", 0.0038, 0.3, 0.05, None, 5),
    Point("stick", 0.9, 0.5, 0.2, None, 5),
    Point("stick", 0.0, 1.0, 0.95, None, 10),
    Point("stick", 0.05, 1.0, 1.0, None, 5),
    Point("stick", 0.0038, 0.1, 0.008, None, 5),
    Point("stick", 0.0038, 0.9, 1.2, None, 5),
    Point("particle", 0.0038, 1.0, 0.0, (10.0, 0.47, 0.1), 10),
    Point("particle", 0.0038, 1.1, 0.0, (3.0, 0.82, 0.1), 10),
    Point("particle", 0.0, 1.0, 0.0, (5.0, 1.0, 0.05), 10),
    Point("particle", 0.1, 0.7, 0.0, (0.5, 0.1, 1.0), 10),
    Point("particle", 0.0038, 1.0, 0.0, (20.0, 0.47, 0.1), 20),
    Point("particle", 0.0038, 1.0, 0.0, (15.0, 0.82, 0.1), 10),
    Point("particle", 0.0038, 1.0, 0.0, (5.0, 0.47, 0.001), 10),
    Point("particle", 0.05, 0.95, 0.0, (2.0, 0.6, 3.0), 10),
    Point("particle", 0.2, 1.0, 0.0, (2.0, 0.0, 0.1), 10),
    Point("particle", 0.9, 0.5, 0.0, (0.5, 0.9, 0.3), 5),
    Point("particle", 0.0038, 5.0, 0.0, (0.05, 0.47, 0.1), 20),
    Point("particle", 0.0, 1.0, 0.0, (5.0, 1.0, 0.05), 4),
    Point("hybrid", 0.0038, 1.0, 0.4, (5.0, 0.47, 0.1), 10),
    Point("hybrid", 0.0038, 1.0, 0.6, (2.0, 0.47, 0.1), 10),
    Point("hybrid", 0.0038, 1.0, 0.2, (10.0, 0.82, 0.1), 10),
    Point("hybrid", 0.0038, 1.1, 0.3, (3.0, 0.47, 0.2), 10),
    Point("hybrid", 0.02, 1.5, 0.5, (1.0, 0.47, 0.1), 20),
    Point("hybrid", 0.0038, 1.0, 0.7, (1.0, 0.82, 0.05), 10),
    Point("hybrid", 0.0, 1.0, 0.5, (3.0, 1.0, 0.1), 8),
    Point("hybrid-stick", 0.0038, 0.9, 0.6, (2.0, 0.47, 0.1), 10),
    Point("hybrid-stick", 0.0038, 1.0, 0.8, (0.5, 0.47, 0.1), 10),
    Point("hybrid-stick", 0.0038, 0.5, 0.2, (0.5, 0.9, 0.1), 8),
    Point("hybrid-stick", 0.0038, 0.9, 0.7, (0.8, 0.6, 0.3), 10),
    Point("hybrid-stick", 0.05, 1.0, 1.0, (0.5, 0.8, 0.2), 10),
    Point("hybrid-stick", 0.0038, 0.7, 0.4, (1.0, 1.0, 0.1), 5),
    Point("hybrid-stick", 0.0038, 0.9, 1.2, (0.5, 0.47, 0.1), 10),
    Point("chatter", 0.0038, 0.9, 0.6, (0.5, 0.1, 0.1), 10),
    Point("chatter", 0.0038, 1.0, 0.0, (1.0, 0.47, 0.1), 10),
    Point("chatter", 0.0038, 1.2, 0.3, (0.7, 0.0, 0.2), 10),
    Point("chatter", 0.0038, 0.95, 0.4, (2.0, 0.47, 0.1), 8),
    Point("chatter", 0.0, 0.5, 0.0, (1.0, 0.1, 3.0), 5),
    Point("chatter", 0.0038, 2.0, 0.5, (0.2, 0.1, 0.1), 10),
    Point("chatter", 0.0038, 1.0, 0.0, (0.5, 0.0, 0.1), 10),
    Point("chatter", 0.1, 0.1, 0.0, (0.3, 0.47, 0.1), 3),
    Point("attached-stick", 0.0038, 0.5, 0.2, (0.5, 0.0, 0.1), 10),
    Point("attached-stick", 0.05, 0.8, 0.5, (0.3, 0.47, 0.3), 10),
    Point("attached-stick", 0.0038, 0.9, 0.8, (0.3, 0.1, 0.1), 8),
    Point("attached-stick", 0.0038, 0.5, 0.22, (0.2, 0.1, 1.0), 8),
    Point("attached-stick", 0.0038, 0.9, 1.2, (0.5, 0.1, 0.1), 5),
    Point("attached-stick", 0.0038, 0.3, 0.07, (0.5, 0.47, 0.5), 4),
    Point("attached-stick", 0.0038, 1.0, 0.9, (0.5, 0.0, 0.3), 10),
    Point("fast", 0.0038, 5.0, 0.6, (1.0, 0.47, 0.1), 20),
    Point("fast", 0.0038, 5.0, 0.6, (0.05, 0.47, 0.1), 20),
    Point("fast", 0.0, 20.0, 0.2, (0.01, 0.47, 0.1), 20),
    Point("slow", 0.0038, 0.1, 0.008, (0.5, 0.1, 0.1), 4),
]
