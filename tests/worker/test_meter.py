"""What a meter reads, against the closed form of a linear steady response: no quadrature and no search to share."""

from math import pi, sqrt

import numpy as np
import pytest

from damperlab.studies.definition import parse_study
from damperlab.studies.plan import Block
from damperlab.studies.variables import STANDARD, ResponseClass
from damperlab.worker.block import solve_block
from damperlab.worker.point import Design, simulate_ready
from damperlab.worker.solver.events import BUDGET
from damperlab.worker.solver.integrate import half_cycle
from damperlab.worker.solver.observe.meter import (
    METERS,
    PEAK,
    RELATIVE_PEAK,
    SQUARE,
    VISCOUS_LOSS,
    WORK_IN,
    Meter,
)
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.scene import make_scene
from damperlab.worker.solver.segment_log import empty_log
from damperlab.worker.solver.state import State
from damperlab.worker.steady.response.measures import INTEGRATED


@pytest.mark.parametrize("frequency_ratio", [1e-3, 0.1, 0.9, 1.0, 3.0, 30.0, 1e3, 1e4])
def test_energies_squares_and_peaks_of_a_linear_response(frequency_ratio: float) -> None:
    damping_ratio, r = 0.3, frequency_ratio
    scene = make_scene(damping_ratio, r, None, None, True)
    relative = (
        r * r / (1.0 - r * r + 2j * damping_ratio * r)
    )  # v over s, both as the imaginary part of exp(i r τ)
    absolute = 1.0 + relative
    state = State(relative.imag, (1j * r * relative).imag, 0.0, 1.0, 0.0, 0.0, 0.0, 0, 0)
    scene.counts[BUDGET] = 10
    sums = np.zeros(METERS)
    half_cycle(state, scene, Meter(sums), empty_log(1000))

    half = pi / r
    windows = max(
        8, scene.base.windows
    )  # rounding of a sum over windows: each adds at most one unit in the last place
    rounding = 4e-16 * windows
    assert sqrt(2.0 * sums[SQUARE] / half) == pytest.approx(abs(absolute), rel=rounding + 1e-15 * max(1.0, r))
    assert sums[PEAK] == pytest.approx(abs(absolute), rel=4e-16)
    assert sums[RELATIVE_PEAK] == pytest.approx(abs(relative), rel=4e-16)
    loss = damping_ratio * abs(r * relative) ** 2 * half
    assert sums[VISCOUS_LOSS] == pytest.approx(loss, rel=rounding)
    # what goes to and fro in each half cycle, of which the loss is what stays
    exchanged = abs((1.0 + 2j * damping_ratio * r) * relative) * r * half
    assert sums[WORK_IN] == pytest.approx(loss, abs=rounding * exchanged)


def test_energy_dissipated_per_cycle_is_that_of_its_mechanisms() -> None:
    """Linear: 2πζ r |H|², with H of the base's motion. Friction without rest: 4 γ_F times the peak of the relative motion."""
    linear = simulate_ready(Design(0.05, 0.9)).metrics
    share = 0.9**2 / abs(1.0 - 0.9**2 + 2j * 0.05 * 0.9)
    assert linear["dissipation_per_cycle"] == pytest.approx(2 * pi * 0.05 * 0.9 * share**2, rel=1e-14)
    rubbing = simulate_ready(Design(0.05, 0.9, 0.2)).metrics
    assert rubbing["response_class"] in (ResponseClass.SYMMETRIC, ResponseClass.NO_IMPACT)
    assert rubbing["stick_fraction"] == 0.0
    lost = rubbing["dissipation_per_cycle"] * rubbing["dissipation_friction"]
    assert lost == pytest.approx(4 * 0.2 * rubbing["relative_amplitude_ratio"], rel=1e-12)
    # impacts that follow one another in the same way: ½ β/(1+β) (1 − e²) w² each, at the one speed that there is
    rattling = simulate_ready(Design(0.05, 1.0, 0.0, Particle(8.0, 0.6, 0.1))).metrics
    assert (rattling["response_class"], rattling["impacts_per_cycle"]) == (ResponseClass.SYMMETRIC, 2.0)
    one = 0.5 * (0.1 / 1.1) * (1.0 - 0.6**2) * rattling["impact_speed_max"] ** 2
    lost = rattling["dissipation_per_cycle"] * rattling["dissipation_impact"]
    assert lost == pytest.approx(2 * one, rel=1e-9)


def test_a_study_without_energies_stores_the_same_bits() -> None:
    document = {
        "damping_ratio": 0.02,
        "axes": {"friction_ratio": [0.3, 0.7], "frequency_ratio": [0.9, 1.05]},
        "particle": False,
    }
    lean = [name for name in STANDARD if name not in INTEGRATED and name != "run_time"]
    every = parse_study(document)
    some = parse_study(document | {"metrics": lean})
    block = Block.whole(every.shape)
    expected, found = solve_block(every, block), solve_block(some, block)
    assert set(expected) - set(found) == (INTEGRATED & set(STANDARD)) | {"run_time"}
    for name, values in found.items():
        assert values.tobytes() == expected[name].tobytes(), name
