"""The two-impacts-per-cycle solution and its stability against the extended-precision simulator."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from tests.oracles.impact_pair import ImpactPair, two_impacts_per_cycle
from tests.reference.march import Simulation
from tests.reference.numbers import ExtendedNumbers
from tests.reference.simulator import simulate
from tests.reference.state import State

NUMBERS = ExtendedNumbers(40)
STABLE = (0.0038, 1.0, 10.0, 0.47, 0.1)
UNSTABLE = (0.0038, 1.0, 5.0, 0.47, 0.1)


def started_on(scene: tuple[float, float, float, float, float], orbit: ImpactPair) -> Simulation:
    """Return a run that stands on the orbit, just after its impact at gap = +delta."""
    zeta, r, delta, e, beta = scene
    run = Simulation(NUMBERS, zeta, r, 0, (delta, e, beta))
    convert = NUMBERS.convert
    time = convert(orbit.phase % (2 * math.pi)) / run.r
    cos_base, sin_base = NUMBERS.cos_sin(run.r * time)
    u, u_rate, _, p_rate = orbit.start
    run.state = State(
        time, convert(u) - sin_base, convert(u_rate) - run.r * cos_base, run.delta, convert(p_rate)
    )
    run.vanishing["wall+"] = 1
    return run


@pytest.mark.parametrize("scene", [STABLE, UNSTABLE, (0.05, 1.2, 2.0, 0.6, 0.3), (0.05, 1.5, 1.0, 0.9, 1.0)])
def test_half_a_period_later_everything_is_mirrored(
    scene: tuple[float, float, float, float, float],
) -> None:
    orbits = two_impacts_per_cycle(*scene)
    assert orbits
    for orbit in orbits:
        run = started_on(scene, orbit)
        begun = run.state.time
        run.run_segment(2 * NUMBERS.pi / run.r)
        assert [name for _, name in run.events] == ["wall-"]
        # The oracle is in double precision; an orbit of size 10 is known to some 1e-14.
        assert float(run.state.time - begun) == pytest.approx(math.pi / scene[1], abs=1e-12)
        found = [-float(x) for x in run.absolute()]
        assert found == pytest.approx(orbit.start, abs=1e-12)


@pytest.mark.parametrize("scene", [STABLE, UNSTABLE])
def test_multipliers_are_those_of_the_simulated_period(
    scene: tuple[float, float, float, float, float],
) -> None:
    (orbit,) = two_impacts_per_cycle(*scene)
    zeta, r, delta, e, beta = scene
    run = started_on(scene, orbit)
    period = 2 * NUMBERS.pi / run.r
    while period - run.state.time > NUMBERS.rounding * 100:
        run.run_segment(period - run.state.time)
    start = replace(run.state, time=NUMBERS.convert(0))
    step = NUMBERS.convert("1e-18")
    columns = []
    for move in (
        {"v": start.v + step, "gap": start.gap + step},  # u alone
        {"v_rate": start.v_rate + step},
        {"gap": start.gap - step},  # p alone
        {"p_rate": start.p_rate + step},
    ):
        ends = [
            simulate(zeta, r, 0.0, (delta, e, beta), cycles=1, start=at)
            for at in (replace(start, **move), start)
        ]
        columns.append(
            [float((ends[0][name] - ends[1][name]) / step) for name in ("u", "u_rate", "p", "p_rate")]
        )
    found = np.linalg.eigvals(np.array(columns).T)
    # Both are eigenvalues of a matrix with entries of order 10 known to a dozen ulps.
    for multiplier in orbit.multipliers:
        assert min(abs(multiplier - other) for other in found) < 1e-10 * max(1, abs(multiplier))
    assert orbit.stable == (scene == STABLE)
