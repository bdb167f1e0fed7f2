"""The section: the state at the start of every (mirrored) half cycle, on which periodic responses are recognised."""

from math import sqrt

from worker.jit import kernel

COORDINATES = 4
"""v, w, u − p and the particle's velocity; the last two stay 0 without a particle."""

RING = 128
"""Half cycles remembered."""

LONGEST = 32
"""Longest period looked for, in half cycles: 16 excitation periods of an asymmetric response."""


@kernel
def section_point(state, particle, out):
    """Coordinates of a state on the section into `out`, shape (COORDINATES,)."""
    out[0] = state.v
    out[1] = state.w
    out[2] = 0.0
    out[3] = 0.0
    if particle is not None:
        out[2] = state.wall * (particle.clearance_ratio - state.gap)
        out[3] = state.p_rate


@kernel
def recurrence(ring, now, lag):
    """Distance between the section points `now` and `now − lag`, indices counted from the start of the march."""
    a = ring[now % RING]
    b = ring[(now - lag) % RING]
    total = 0.0
    for i in range(COORDINATES):
        total += (a[i] - b[i]) ** 2
    return sqrt(total)


@kernel
def extent(ring, now):
    """Size of the section point `now`, at least 1: the scale that distances are judged by."""
    a = ring[now % RING]
    total = 1.0
    for i in range(COORDINATES):
        total += a[i] ** 2
    return sqrt(total)
