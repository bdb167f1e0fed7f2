"""Start options in the cube like any study, and a motion that is handed on to another frequency or length."""

from typing import Any

import numpy as np
import pytest
from tests.studies.documents import fields_of

from damperlab.studies.choices import Ensemble
from damperlab.studies.definition import Study, parse_study
from damperlab.studies.plan import Block, make_plan, plan_with_chunk
from damperlab.studies.variables import STANDARD, VARIABLES, ResponseClass, Status
from damperlab.worker.block import block_points, kernel_arguments, solve_block
from damperlab.worker.dispatch.cost_model import seconds_per_point
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.state import Dwell, State
from damperlab.worker.steady.ensemble import HIGHEST, attractors, drawn_starts, ensemble_values
from damperlab.worker.steady.response.measures import Response
from damperlab.worker.steady.settle import Settings, at_rest, settle
from damperlab.worker.steady.start import carried

ENSEMBLE = {"kind": "ensemble", "n": 40, "seed": 7}
SYMMETRIC_AMPLITUDE, TWIN_AMPLITUDE = 1.67530417, 2.09540163
"""The two stable responses at γ_F 0.6, d/Z 2, r 1.1, e 0.47, β 0.1, ζ 0.0038."""


def study_of(start: Any, **axes: Any) -> Study:
    given = {
        "clearance_ratio": 2.0,
        "friction_ratio": 0.6,
        "restitution": 0.47,
        "mass_ratio": 0.1,
        "frequency_ratio": 1.1,
    }
    return parse_study({"damping_ratio": 0.0038, "axes": given | axes, "start": start})


def solve(study: Study) -> dict[str, np.ndarray]:
    return solve_block(study, Block.whole(study.shape))


def assert_same_bits(one: dict[str, np.ndarray], other: dict[str, np.ndarray]) -> None:
    for name, values in one.items():
        if name != "run_time":
            assert np.ascontiguousarray(values).tobytes() == np.ascontiguousarray(other[name]).tobytes(), name


def test_up_and_down_differ_where_two_responses_are_stable() -> None:
    frequencies = {"start": 1.0, "stop": 1.2, "num": 21}
    up, down = (
        solve(study_of({"kind": "continuation", "direction": d}, frequency_ratio=frequencies))
        for d in ("up", "down")
    )
    at = 10
    assert up["amplitude_ratio"].flat[at] == pytest.approx(TWIN_AMPLITUDE, abs=1e-7)
    assert up["response_class"].flat[at] == ResponseClass.ASYMMETRIC
    assert down["amplitude_ratio"].flat[at] == pytest.approx(SYMMETRIC_AMPLITUDE, abs=1e-7)
    assert down["response_class"].flat[at] == ResponseClass.SYMMETRIC
    # Far above the branches have met again.
    assert up["amplitude_ratio"].flat[20] == pytest.approx(down["amplitude_ratio"].flat[20], abs=1e-9)


def test_a_continuation_starts_from_rest() -> None:
    alone = solve(study_of("rest", frequency_ratio=1.05))
    row = solve(study_of({"kind": "continuation", "direction": "up"}, frequency_ratio=[1.05, 1.1]))
    for name, values in alone.items():
        if name != "run_time":
            assert values.flat[0] == row[name].flat[0] or np.isnan(values.flat[0]), name


@pytest.mark.parametrize(
    "start", ["rest", ENSEMBLE | {"n": 5}, {"kind": "continuation", "direction": "down"}], ids=str
)
def test_a_point_has_the_same_bits_in_every_block(start: Any) -> None:
    study = study_of(
        start, clearance_ratio=[2.0, 10.0], friction_ratio=[0.0, 0.6], frequency_ratio=[1.0, 1.1]
    )
    whole = solve(study)
    plan = plan_with_chunk(study, (1, 1, 1, 1, 1, 2 if study.whole_rows else 1), seconds_per_point)
    for index in reversed(range(plan.count)):
        block = plan.block(index)
        part = solve_block(study, block)
        assert_same_bits(part, {name: values[block.slices] for name, values in whole.items()})


def test_blocks_of_a_continuation_hold_every_frequency() -> None:
    start = {"kind": "continuation"}
    axes = {"friction_ratio": {"start": 0, "stop": 0.7, "num": 50}}
    study = study_of(start, frequency_ratio={"start": 0.8, "stop": 1.2, "num": 500}, **axes)
    plan = make_plan(study, seconds_per_point)
    assert plan.chunk[-1] == 500
    assert plan.count > 1
    with pytest.raises(ValueError, match="cuts rows of 500 values"):
        plan_with_chunk(study, (1, 1, 1, 1, 1, 250), seconds_per_point)


def test_an_ensemble_finds_both_responses_and_their_shares() -> None:
    values = {name: column.flat[0] for name, column in solve(study_of(ENSEMBLE | {"n": 100})).items()}
    assert values["attractors"] == 2
    assert values["amplitude_ratio"] == pytest.approx(TWIN_AMPLITUDE, abs=1e-7)
    assert values["amplitude_ratio_second"] == pytest.approx(SYMMETRIC_AMPLITUDE, abs=1e-7)
    assert np.isnan(values["amplitude_ratio_third"])
    share, second = values["attractor_share"], values["attractor_share_second"]
    assert share > 0.5
    assert share + second == pytest.approx(1.0, abs=1e-12)
    mean = share * TWIN_AMPLITUDE + second * SYMMETRIC_AMPLITUDE
    assert values["amplitude_ratio_mean"] == pytest.approx(mean, abs=1e-7)
    spread = (TWIN_AMPLITUDE - SYMMETRIC_AMPLITUDE) * np.sqrt(share * second)
    assert values["amplitude_ratio_spread"] == pytest.approx(spread, abs=1e-7)
    assert values["amplitude_ratio_worst"] == pytest.approx(TWIN_AMPLITUDE, abs=1e-7)


def test_an_ensemble_of_one_is_the_start_from_rest() -> None:
    one = solve(study_of(ENSEMBLE | {"n": 1}))
    rest = solve(study_of("rest"))
    assert_same_bits(rest, one)
    assert one["attractor_share"].flat[0] == 1.0


@pytest.mark.parametrize("friction", [0.0, 0.6])
def test_without_a_particle_there_is_one_response_from_every_start(friction: float) -> None:
    """Monotone friction: a moving response attracts everything."""
    values = solve(study_of(ENSEMBLE, friction_ratio=friction, mass_ratio=0.0))
    assert values["attractors"].flat[0] == 1
    assert values["amplitude_ratio_mean"].flat[0] == pytest.approx(
        values["amplitude_ratio"].flat[0], rel=1e-8
    )
    assert values["amplitude_ratio_spread"].flat[0] < 1e-8


def test_drawn_starts_depend_on_seed_and_coordinates_alone() -> None:
    particle = Particle(2.0, 0.47, 0.1)

    def draw(n: int, seed: int, place: float) -> list[Any]:
        return list(drawn_starts(n, seed, (0.0038, place), 0.0038, 1.1, 0.6, particle))

    long = draw(20, 3, 1.0)
    assert draw(5, 3, 1.0) == long[:5]
    assert draw(20, 4, 1.0)[1:] != long[1:]
    assert draw(20, 3, 2.0)[1:] != long[1:]
    for state in long[1:]:
        assert 0.0 <= state.gap <= 2.0 * particle.clearance_ratio
        assert state.w * state.slip >= 0.0


def test_drawn_amplitudes_stay_between_base_and_structure_alone() -> None:
    for zeta, r, most in ((0.0038, 1.0, 131.6), (0.0, 1.0, HIGHEST), (0.1, 5.0, 2.0)):
        for state in list(drawn_starts(200, 0, (zeta,), zeta, r, None, None))[1:]:
            a = np.hypot(state.v, (state.w + r) / r)
            assert 1.0 - 1e-12 <= a <= most * (1.0 + 1e-12)


def test_responses_are_told_apart_within_their_errors() -> None:
    base = settle(
        0.05, 1.0, 0.5, None, Settings(100, 1e-4, 1e-9), next(drawn_starts(1, 0, (), 0.05, 1.0, 0.5, None))
    )[0]
    assert isinstance(base, Response)
    periodic = base._replace(response_class=int(ResponseClass.SYMMETRIC), period=1, amplitude_error=1e-12)
    chaotic = base._replace(response_class=int(ResponseClass.CHAOTIC), period=0, amplitude_error=0.01)
    near = chaotic._replace(
        amplitude_ratio=chaotic.amplitude_ratio + 0.03, response_class=int(ResponseClass.MODULATED)
    )
    far = chaotic._replace(amplitude_ratio=chaotic.amplitude_ratio + 0.3)
    other = periodic._replace(amplitude_ratio=periodic.amplitude_ratio + 1e-3)
    failed = base._replace(status=4, amplitude_ratio=np.nan)
    found = attractors([periodic, other, periodic, chaotic, near, far, failed, other, other])
    assert found == [[1, 7, 8], [0, 2], [3, 4], [5]]
    values = ensemble_values([failed, failed])
    assert values["attractors"] == 0
    assert values["attractor_share"] == 0.0
    assert "amplitude_ratio_mean" not in values


def test_variables_of_an_ensemble_are_stored_by_ensembles_alone() -> None:
    assert study_of("rest").metrics == STANDARD
    always = (name for name, one in VARIABLES.items() if not (one.asked or one.rubbing))
    assert study_of(ENSEMBLE).metrics == tuple(always)
    assert isinstance(study_of(ENSEMBLE).start, Ensemble)
    asked = study_of("rest").document() | {"metrics": ["attractors"]}
    assert fields_of(parse_study, asked) == ["metrics[0]"]


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
    start = carried(end, r, r_now, shrinks)
    expected, _ = settle(zeta, r_now, friction_now, particle_now, settings, start)
    # started alike but for rounding: the run takes as long, and comes to the same
    assert found["cycles"].flat[last] == expected.cycles
    assert found["amplitude_ratio"].flat[last] == pytest.approx(expected.amplitude_ratio, rel=1e-7)
