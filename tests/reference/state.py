"""The state between two segments of a run."""

from __future__ import annotations

from dataclasses import dataclass

from tests.reference.numbers import Real


@dataclass
class State:
    """Where everything is, at ``time`` after the last phase 0 of the base.

    v is relative to the base, gap = u - p, p_rate absolute; wall is +-1 while the particle is attached at
    gap = +-delta, else 0; stuck tells whether the mass rides with the base.
    """

    time: Real
    v: Real
    v_rate: Real
    gap: Real
    p_rate: Real
    wall: int = 0
    stuck: bool = False
