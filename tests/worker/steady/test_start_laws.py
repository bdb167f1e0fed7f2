"""Starts at phase 0: a motion that is handed on to another frequency, and to another length."""

from typing import Any

import numpy as np
import pytest

from damperlab.studies.definition import Study, parse_study
from damperlab.studies.plan import Block
from damperlab.worker.block import block_points, kernel_arguments, solve_block
from damperlab.worker.solver.state import Dwell, State
from damperlab.worker.steady.settle import Settings, at_rest, settle
from damperlab.worker.steady.start import carried, over_another_length

STATE = State(0.3, -0.4, -1.0, 1.0, 0.7, 1.9, 0.0, 0, 0, Dwell(0.2, 0.6))


def motion(state: State, r: float, length: float) -> list[float]:
    """Displacements and velocities relative to the base, over a length of 1."""
    dwell = state.dwell
    assert dwell is not None
    return [length * x for x in (state.v, state.w, state.gap, state.p_rate - r, dwell.speed)]


@pytest.mark.parametrize(("r", "r_now"), [(0.8, 1.3), (1.3, 0.8)])
@pytest.mark.parametrize("power", [1, 2])
def test_the_motion_relative_to_the_base_is_the_same_over_another_length(
    r: float, r_now: float, power: int
) -> None:
    length, length_now = r**-power, r_now**-power  # of a base of constant velocity or acceleration
    now = carried(over_another_length(STATE, r, length / length_now), r, r_now)
    assert motion(now, r_now, length_now) == pytest.approx(motion(STATE, r, length), rel=1e-14)
    assert (now.slip, now.wall, now.dwell.left) == (STATE.slip, STATE.wall, STATE.dwell.left)


@pytest.mark.parametrize("constant", ["velocity", "acceleration"])
def test_a_continuation_hands_on_the_motion_where_the_displacement_of_the_base_is_not_constant(
    constant: str,
) -> None:
    physical: dict[str, Any] = {
        "mass_kg": 1.605,
        "natural_frequency_hz": 2.5,
        "base_amplitude_m": [0.002, 0.003],
        "constant": constant,
        "clearance_m": 0.0075,
        "friction_force_n": 0.33,
        "excitation_frequency_hz": [2.3, 2.6],
    }
    study = parse_study({"physical": physical, "start": {"kind": "continuation", "direction": "up"}})
    assert isinstance(study, Study)
    block = Block(0, (0,) * len(study.shape), study.shape)
    found = solve_block(study, block)
    points = block_points(study, block)
    (_, zeta, r, friction, particle), (last, _, r_now, friction_now, particle_now) = list(
        kernel_arguments(study, points, np.array([0, 1]))
    )
    settings = Settings(study.steady.max_cycles, study.steady.tolerance, study.steady.periodic_tolerance)
    _, end = settle(zeta, r, friction, particle, settings, at_rest(r, friction, particle))
    # d is one length: over the displacement of the base before and now
    shrinks = particle_now.clearance_ratio / particle.clearance_ratio
    assert shrinks == pytest.approx((r_now / r) ** (1 if constant == "velocity" else 2), rel=1e-13)
    start = State(
        end.v * shrinks,
        end.w * shrinks,
        end.slip,
        end.wall,
        end.gap * shrinks,
        r_now + shrinks * (end.p_rate - r),
        end.riding,
        0,
        0,
        None,
    )
    expected, _ = settle(zeta, r_now, friction_now, particle_now, settings, start)
    # started alike but for rounding: the run takes as long, and comes to the same
    assert found["cycles"].flat[last] == expected.cycles
    assert found["amplitude_ratio"].flat[last] == pytest.approx(expected.amplitude_ratio, rel=1e-7)
