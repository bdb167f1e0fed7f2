"""The functions whose zeros are events; each is positive until its event."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from tests.reference.motion import Sample
from tests.reference.numbers import Real
from tests.reference.roots import Triple


@dataclass(frozen=True)
class Watch:
    """A named event function: its value and first two derivatives, from a sample of the motion and its h."""

    name: str
    triple: Callable[[Sample, Real], Triple]


def turn(slip: int) -> Watch:
    """Slip in direction `slip` ends where v' = 0."""
    return Watch("turn", lambda x, h: (slip * x[0][1], slip * x[0][2], slip * x[0][3]))


def loose(sign: int, gamma: Real) -> Watch:
    """Stick ends where the push less v reaches the friction limit, sign * gamma."""
    return Watch(
        "loose+" if sign > 0 else "loose-",
        lambda x, h: (gamma - sign * (x[2][0] - x[0][0]), -sign * x[2][1], -sign * x[2][2]),
    )


def release(wall: int) -> Watch:
    """An attached particle leaves where the wall stops pushing it: wall * u'' = 0."""
    return Watch(
        "release",
        lambda x, h: (
            wall * (x[0][2] + x[1][2]),
            wall * (x[0][3] + x[1][3]),
            wall * (x[0][4] + x[1][4]),
        ),
    )


def clearance(sign: int, delta: Real, gap_start: Real, u_start: Real, p_rate: Real) -> Watch:
    """A free particle meets the wall where delta - sign * gap = 0; the gap is counted from where it started."""
    rest = delta - sign * gap_start  # exactly zero, or two delta, after an impact
    return Watch(
        "wall+" if sign > 0 else "wall-",
        lambda x, h: (
            rest - sign * ((x[0][0] + x[1][0] - u_start) - p_rate * h),
            -sign * (x[0][1] + x[1][1] - p_rate),
            -sign * (x[0][2] + x[1][2]),
        ),
    )
