"""The section: the state at the start of every (mirrored) half cycle, on which periodic responses are recognised."""

from math import sqrt

from worker.jit import kernel
from worker.steady.tangent import SIZE

RING = 128
"""Half cycles remembered, as section coordinates v, w, p, p'."""

LONGEST = 64
"""Longest period looked for, in half cycles: 32 excitation periods of an asymmetric response."""


@kernel
def recurrence(ring, now, lag):
    """Distance between the section points `now` and `now − lag`, indices counted from the start of the march."""
    a = ring[now % RING]
    b = ring[(now - lag) % RING]
    total = 0.0
    for i in range(SIZE):
        total += (a[i] - b[i]) ** 2
    return sqrt(total)


@kernel
def extent(ring, now):
    """Size of the section point `now`, at least 1: the scale that distances are judged by."""
    a = ring[now % RING]
    total = 1.0
    for i in range(SIZE):
        total += a[i] ** 2
    return sqrt(total)
