"""Starts at phase 0: a motion that is handed on to another frequency, and to another length."""

from typing import Any

import numpy as np
import pytest

from damperlab.studies.definition import Study, parse_study
from damperlab.studies.plan import Block
from damperlab.studies.variables import ResponseClass, Status
from damperlab.worker.block import block_points, kernel_arguments, solve_block
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.state import Dwell, State
from damperlab.worker.steady.settle import Settings, at_rest, settle
from damperlab.worker.steady.start import carried

STATE = State(0.3, -0.4, -1.0, 1.0, 0.7, 1.9, 0.0, 0, 0, Dwell(0.2, 0.6))
SETTINGS = Settings(4000, 0.02, 1e-9)


@pytest.mark.parametrize(("r", "r_now"), [(0.8, 1.3), (1.3, 0.8)])
@pytest.mark.parametrize("power", [0, 1, 2])
@pytest.mark.parametrize("on_the_wall", [False, True])
def test_the_motion_is_the_same_over_another_length(
    r: float, r_now: float, power: int, on_the_wall: bool
) -> None:
    """A base of constant displacement, velocity or acceleration; all in one unit of length."""
    length, length_now = r**-power, r_now**-power
    state = STATE._replace(riding=1.0) if on_the_wall else STATE
    now = carried(state, r, r_now, length / length_now)
    for name in ("v", "w", "gap"):
        assert length_now * getattr(now, name) == pytest.approx(length * getattr(state, name), rel=1e-14)
    assert length_now * now.dwell.speed == pytest.approx(length * state.dwell.speed, rel=1e-14)
    # on its wall it goes with the structure, whose motion relative to the base goes on
    before, after = (r, r_now) if on_the_wall else (0.0, 0.0)
    assert length_now * (now.p_rate - after) == pytest.approx(length * (state.p_rate - before), rel=1e-14)
    assert (now.slip, now.wall, now.riding, now.dwell.left) == (
        state.slip,
        state.wall,
        state.riding,
        state.dwell.left,
    )


@pytest.mark.parametrize("friction", [None, 2.0])
def test_a_particle_that_rests_still_rests_at_the_next_frequency(friction: float | None) -> None:
    """A branch without impacts, also of a mass that friction holds, is followed."""
    particle = Particle(20.0, 0.8, 0.1)
    state, before = at_rest(0.5, friction, particle), 0.5
    for r in (0.5, 0.51, 0.52):
        response, state = settle(0.05, r, friction, particle, SETTINGS, carried(state, before, r))
        from_rest, _ = settle(0.05, r, friction, particle, SETTINGS, at_rest(r, friction, particle))
        assert response.status == Status.CONVERGED
        assert response.impacts_per_cycle == 0.0
        assert response.response_class == from_rest.response_class
        if friction is None:  # one that is held may rest anywhere
            assert response.amplitude_ratio == pytest.approx(from_rest.amplitude_ratio, rel=1e-7)
        assert state.p_rate == 0.0
        before = r


def test_a_mass_without_a_particle_that_is_held_is_held_at_the_next_frequency() -> None:
    state, before = at_rest(0.9, 1.2, None), 0.9
    for r in (0.9, 0.95, 1.0, 1.05):
        response, state = settle(0.02, r, 1.2, None, SETTINGS, carried(state, before, r))
        assert (response.response_class, response.status) == (ResponseClass.LOCKED, Status.CONVERGED)
        before = r


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
    block = Block.whole(study.shape)
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
        end.p_rate * shrinks,
        end.riding,
        0,
        0,
        None,
    )
    expected, _ = settle(zeta, r_now, friction_now, particle_now, settings, start)
    # started alike but for rounding: the run takes as long, and comes to the same
    assert found["cycles"].flat[last] == expected.cycles
    assert found["amplitude_ratio"].flat[last] == pytest.approx(expected.amplitude_ratio, rel=1e-7)
