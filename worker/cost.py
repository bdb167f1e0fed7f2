"""What a design point is expected to cost, so that blocks take about equal time and the longest start first.

A rough model is enough: it decides sizes and order, never a result. Cycles until the response is known to be
steady times windows and events per cycle; the constants are fits to the solver's own run times.
"""

import numpy as np
from numpy.typing import NDArray

from studies.definition import Study

LINEAR_SECONDS = 2e-6
"""A point in closed form."""
SETUP_SECONDS = 2e-6
"""A point that is stepped, before its first cycle."""
WINDOW_SECONDS = 5e-8
"""One window of the closed form."""
WINDOWS_PER_CYCLE = 16
"""For r ≥ 1; a slower excitation takes as many windows per natural period, so 1/r times more per cycle."""
EVENT_SECONDS = 2e-7
"""Locating one event and applying its law."""
FRICTION_EVENTS, PARTICLE_EVENTS, HYBRID_EVENTS = 2, 2, 6
"""Events per cycle, turns and impacts; see the solver notes in the architecture."""
MODULATED_SHARE = 1.0 / 3.0
"""Share of points with a particle that never become periodic and run to max_cycles."""


def seconds_per_point(study: Study, coordinates: dict[str, NDArray[np.float64]]) -> NDArray[np.float64]:
    """Kernel seconds that design points are expected to take.

    Parameters
    ----------
    study : Study
        Of which only the scene and `steady.max_cycles` matter.
    coordinates : dict of ndarray
        The six dimensions by name, N values each.

    Returns
    -------
    ndarray
        N values [s], all above 0.
    """
    ratio = coordinates["frequency_ratio"]
    damping = np.maximum(coordinates["damping_ratio"], 1e-4)
    rubs = coordinates["friction_ratio"] > 0.0
    most = float(study.steady.max_cycles)
    # A transient dies as exp(-ζ τ), and a cycle lasts 2π/r: about 20 e-foldings r/(2πζ) cycles each.
    settling = np.minimum(most, 8.0 + 20.0 * ratio / (2.0 * np.pi * damping))
    windows = WINDOWS_PER_CYCLE * np.maximum(1.0, 1.0 / ratio)
    if study.particle:
        cycles = (1.0 - MODULATED_SHARE) * np.minimum(settling, 0.25 * most) + MODULATED_SHARE * most
        events = np.where(rubs, HYBRID_EVENTS, PARTICLE_EVENTS)
    else:
        cycles = settling
        events = np.full(ratio.shape, FRICTION_EVENTS)
    stepped = SETUP_SECONDS + cycles * (windows * WINDOW_SECONDS + events * EVENT_SECONDS)
    return stepped if study.particle else np.where(rubs, stepped, LINEAR_SECONDS)
