"""The first event of a segment, where one follows hard upon another."""

import numpy as np
import pytest

from damperlab.worker.accuracy.march import march_halves
from damperlab.worker.solver.excitation.sine_base import Forced
from damperlab.worker.solver.state import State


@pytest.mark.parametrize("forced", [True, False])
def test_a_slip_of_next_to_no_excess_goes_next_to_nowhere(forced: bool) -> None:
    """A held mass that the largest force moves by an excess x slips for √(8x/P)/r and by less than x, from where it was.

    Of 2,000 frequencies, margins and excesses: the slip lasts a millionth of a window, and begins anywhere in one.
    """
    random = np.random.default_rng(3)
    for _ in range(2000):
        r = 10.0 ** random.uniform(-1.0, 1.0)
        largest = 1.0 if forced else r * r
        edge = largest * random.choice([1e-9, 1e-3, 0.2])
        excess = largest * 10.0 ** random.uniform(-13.0, -3.0)
        v = random.choice([-1.0, 1.0]) * (edge + excess)
        held = State(v, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0, 0, None)
        end, _ = march_halves(
            0.01, Forced(r) if forced else r, largest + edge, None, held, 0, np.zeros((2, 3))
        )
        inwards = abs(v) - abs(end.v)
        # the position is rounded, and with it the friction limit and the excess
        assert -4e-15 * max(1.0, abs(v)) <= inwards <= excess + 4e-15 * max(1.0, largest), (r, edge, excess)
