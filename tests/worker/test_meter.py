"""What a meter reads, against the closed form of a linear steady response: no quadrature and no search to share."""

from math import pi, sqrt

import numpy as np
import pytest

from worker.solver.march import half_cycle
from worker.solver.scene import (
    BUDGET,
    COUNTS,
    METERS,
    PEAK,
    RELATIVE_PEAK,
    SQUARE,
    VISCOUS_LOSS,
    WORK_IN,
    State,
)
from worker.solver.taylor import TERMS
from worker.solver.windows import make_base, make_medium


@pytest.mark.parametrize("frequency_ratio", [1e-3, 0.1, 0.9, 1.0, 3.0, 30.0, 1e3, 1e4])
def test_energies_squares_and_peaks_of_a_linear_response(frequency_ratio: float) -> None:
    damping_ratio, r = 0.3, frequency_ratio
    base = make_base(damping_ratio, r)
    relative = (
        r * r / (1.0 - r * r + 2j * damping_ratio * r)
    )  # v over s, both as the imaginary part of exp(i r τ)
    absolute = 1.0 + relative
    state = State(relative.imag, (1j * r * relative).imag, 0.0, 1.0, 0.0, 0.0, 0.0, 0, 0)
    counts = np.zeros(COUNTS, np.int64)
    counts[BUDGET] = 10
    meter = np.zeros(METERS)
    half_cycle(
        state, base, make_medium(base, 1.0), None, None, None, np.empty((4, TERMS)), counts, meter, None
    )

    half = pi / r
    windows = max(
        8, base.windows
    )  # rounding of a sum over windows: each adds at most one unit in the last place
    rounding = 4e-16 * windows
    assert sqrt(2.0 * meter[SQUARE] / half) == pytest.approx(
        abs(absolute), rel=rounding + 1e-15 * max(1.0, r)
    )
    assert meter[PEAK] == pytest.approx(abs(absolute), rel=4e-16)
    assert meter[RELATIVE_PEAK] == pytest.approx(abs(relative), rel=4e-16)
    loss = damping_ratio * abs(r * relative) ** 2 * half
    assert meter[VISCOUS_LOSS] == pytest.approx(loss, rel=rounding)
    # what goes to and fro in each half cycle, of which the loss is what stays
    exchanged = abs((1.0 + 2j * damping_ratio * r) * relative) * r * half
    assert meter[WORK_IN] == pytest.approx(loss, abs=rounding * exchanged)
