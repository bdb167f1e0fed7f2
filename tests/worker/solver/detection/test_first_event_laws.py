"""The first event of a segment, where one follows hard upon another."""

import numpy as np
import pytest
from tests.worker.plain_march import marched

from damperlab.worker.solver.state import State


@pytest.mark.parametrize("forced", [True, False])
def test_a_slip_of_next_to_no_excess_goes_next_to_nowhere(forced: bool) -> None:
    """A held mass that the largest force P moves by an excess x slips for √(18x/P)/r, and by 4.5 x²/(P r²), towards zero.

    To first order in x/P. Of 2,000 frequencies, margins and excesses, the shortest slips last a millionth of a window, and
    begin anywhere in one.
    """
    random = np.random.default_rng(3)
    for _ in range(2000):
        r = 10.0 ** random.uniform(-1.0, 1.0)
        largest = 1.0 if forced else r * r
        edge = largest * random.choice([1e-9, 1e-3, 0.2])
        excess = largest * 10.0 ** random.uniform(-13.0, -3.0)
        v = random.choice([-1.0, 1.0]) * (edge + excess)
        held = State(v, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0, 0, None)
        end = marched(0.01, r, largest + edge, None, held, 2, forced)
        inwards = abs(v) - abs(end.v)
        # the excess is known to the rounding of forces; the spring takes its share, damping and higher orders a tenth
        known = 4e-15 * (largest + edge)
        stiffness = 4.5 / (largest * r * r)
        less = 0.9 - stiffness * excess
        assert inwards >= less * stiffness * max(excess - known, 0.0) ** 2 - known, (r, edge, excess)
        assert inwards <= 1.1 * stiffness * (excess + known) ** 2 + known, (r, edge, excess)
