"""What must not change a result: the unit of length, a march taken up again, the cycles after the end."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.properties.designs import CYCLES, any_design
from tests.worker.plain_march import marched

from damperlab.studies.definition import parse_study
from damperlab.studies.plan import Block
from damperlab.worker.block import solve_block
from damperlab.worker.point import Design
from damperlab.worker.simulate import simulate
from damperlab.worker.solver.state import State
from damperlab.worker.steady.settle import at_rest

FEW = settings(max_examples=20, deadline=None)


def march(design: Design, state: State, halves: int) -> State:
    structure = (design.damping_ratio, design.frequency_ratio, design.friction_ratio or None)
    return marched(*structure, design.particle, state, halves)


@FEW
@given(any_design, st.integers(1, 2 * CYCLES - 1))
def test_a_march_taken_up_again_ends_the_same(design: Design, halves: int) -> None:
    """All that a march remembers is its state: to the last bit, wherever it is cut."""
    rest = at_rest(design.frequency_ratio, design.friction_ratio or None, design.particle)
    whole = march(design, rest, 2 * CYCLES)
    first = march(design, rest, halves)
    assert march(design, first, 2 * CYCLES - halves) == whole


@FEW
@given(any_design, st.integers(1, CYCLES))
def test_what_comes_later_does_not_change_what_was(design: Design, cycles: int) -> None:
    short = simulate(design, cycles, history=cycles).history
    long = simulate(design, CYCLES, history=CYCLES).history
    for name, column in short.items():
        assert np.array_equal(column, long[name][: column.size], equal_nan=True), name


# Subnormal forces would lose bits when they are scaled.
newtons = st.one_of(st.just(0.0), st.floats(1e-6, 2.0))


@FEW
@given(st.integers(-8, 8), st.integers(-8, 8), st.floats(0.1, 5.0), newtons, st.floats(0.5, 20.0))
def test_the_unit_of_length_and_of_mass_do_not_matter(
    length: int, mass: int, stretch: float, friction: float, clearance: float
) -> None:
    """Lengths × 2^k with forces × 2^(k + l), masses × 2^l: the same ratios to the last bit, so the same cube."""

    def study(length_unit: float, mass_unit: float) -> dict[str, object]:
        amplitude = 1.5e-3 * stretch * length_unit
        return {
            "physical": {
                "mass_kg": 1.6 * mass_unit,
                "natural_frequency_hz": 2.5,
                "base_amplitude_m": amplitude,
                "clearance_m": clearance * 1.5e-3 * length_unit,
                "friction_force_n": friction * length_unit * mass_unit,
                "particle_mass_kg": 0.16 * mass_unit,
            },
            "axes": {"restitution": 0.47, "frequency_ratio": 1.0},
            "damping_ratio": 0.0038,
            "steady": {"max_cycles": 10},
        }

    one = parse_study(study(1.0, 1.0))
    other = parse_study(study(2.0**length, 2.0**mass))
    for name, values in one.coordinates.items():
        assert np.array_equal(values, other.coordinates[name]), name
    block = Block.whole((1,) * 6)
    found, again = solve_block(one, block), solve_block(other, block)
    for name, values in found.items():
        if name != "run_time":
            assert values.tobytes() == again[name].tobytes(), name
