"""The acceleration of the structure: against its closed form, and against simulators that share no code with the solver."""

import itertools
from math import pi, sqrt
from typing import Any, NamedTuple

import numpy as np
import pytest
from tests.oracles import compliant_wall, dwelling
from tests.reference.simulator import simulate as reference
from tests.reference.state import State as Place
from tests.worker.plain_python import accelerated, plainly

from damperlab.studies.answers.largest_acceleration import Acting, accelerations
from damperlab.studies.definition import parse_study
from damperlab.studies.plan import Block
from damperlab.studies.variables import ResponseClass, Status
from damperlab.worker.block import solve_block
from damperlab.worker.scenes import scenes
from damperlab.worker.solver.excitation.sine import base_rate_at_phase_zero
from damperlab.worker.solver.particle import Particle, Wall
from damperlab.worker.solver.scene import make_scene
from damperlab.worker.solver.state import State
from damperlab.worker.steady.response.closed_form import linear_response
from damperlab.worker.steady.response.measures import Response
from damperlab.worker.steady.response.trace import (
    COLUMNS,
    HALF_ACCELERATION,
    acceleration_of_period,
    acceleration_of_run,
    cycle_peaks,
)
from damperlab.worker.steady.settle import Settings, settle
from damperlab.worker.steady.start import at_rest

METERED = Settings(4000, 0.02, 1e-10, True, True)


ZETA = 0.3


class Orbit(NamedTuple):
    """A response with period 1, whose largest |u''| and mean square of a cycle are those of every cycle."""

    peak: float
    square: float
    impacts: float
    end: State
    start: list[float]
    """u, u', p, p' of that state, at phase 0, in which no wall is touched."""


def orbit_of(
    r: float, gamma: float, particle: Particle | None, forced: bool, settings: Settings = METERED
) -> Orbit:
    friction = gamma or None
    rest = at_rest(r, friction, particle, forced)
    found, end = settle(0.03, r, friction, particle, settings, rest, forced)
    assert (found.status, found.period) == (Status.CONVERGED, 1)
    place, p_rate = end.v, 0.0
    if particle is not None:
        assert end.riding == 0.0
        place, p_rate = end.v - end.wall * (particle.clearance_ratio - end.gap), end.p_rate
    start = [end.v, end.w + base_rate_at_phase_zero(r, forced), place, p_rate]
    square = 0.5 * found.acceleration_ratio_rms**2
    return Orbit(found.acceleration_ratio, square, found.impacts_per_cycle, end, start)


def linear(r: float, forced: bool) -> tuple[float, float, float]:
    """Largest |u''| of a cycle, its square mean twice, and how far rounding may move the first."""
    relative, _ = phasors(r, forced)
    scene = make_scene(ZETA, r, None, None, True, forced)
    start = State(relative.imag, (1j * r * relative).imag, 0.0, 1.0, 0.0, 0.0, 0.0, 0, 0)
    peak, square = accelerated(ZETA, r, None, None, start, forced)
    return peak, square * r / pi, 1e-15 * scene.base.windows + (1e-15 / r**2 if forced else 0.0)


def phasors(r: float, forced: bool) -> tuple[complex, complex]:
    """Displacement relative to the base, and absolute."""
    receptance = 1.0 / (1.0 - r * r + 2j * ZETA * r)
    relative = receptance if forced else r * r * receptance
    return relative, relative if forced else 1.0 + relative


def test_a_linear_response_accelerates_by_its_frequency_squared() -> None:
    """|u''| = r² |u|; rounding of x − f where a slow force and the spring nearly balance is that over r²."""
    asked = list(itertools.product((1e-2, 0.5, 1.0, 3.0, 100.0), (False, True)))
    for (r, forced), (peak, square, rounding) in zip(asked, plainly(linear, asked), strict=True):
        largest = r * r * abs(phasors(r, forced)[1])
        assert peak == pytest.approx(largest, rel=rounding)
        assert sqrt(square) == pytest.approx(largest, rel=1e-13 + rounding)
        closed = linear_response(np.array([ZETA]), np.array([r]), forced)
        assert closed["acceleration_ratio"][0] == pytest.approx(largest, rel=1e-14)
        assert closed["acceleration_ratio_rms"][0] == pytest.approx(largest, rel=1e-14)


# r, γ_F, (d/Z, e, β), forced: hybrid dampers that stick, one of them asymmetric
RIGID = [
    (0.95, 0.8, (0.5, 0.5, 0.1), False),
    (0.6, 0.3, (0.5, 0.5, 0.1), False),
    (1.3, 0.3, (0.5, 0.0, 0.1), False),
]


def assert_accelerates(point: Any, orbit: Orbit, peak: float, square: float) -> None:
    """Assert what the reference simulator says of a cycle.

    The response is known to 1e-10 of a distance from periodicity that impacts amplify; Simpson's rule on 2π/200 to 1e-8.
    """
    r, gamma, given, forced = point
    u, _, p, p_rate = orbit.start
    start = Place(0.0, orbit.end.v, orbit.end.w, u - p, p_rate)
    truth = reference(0.03, r, gamma, given, 1, digits=None, start=start, acceleration=True, forced=forced)
    assert (truth["impacts"] > 0) == (orbit.impacts > 0)
    assert float(truth["u"]) == pytest.approx(u, abs=1e-6)  # it is the same orbit
    assert peak == pytest.approx(float(truth["acceleration_peak"]), rel=1e-7)
    assert square == pytest.approx(float(truth["acceleration_square"]) * r / (2.0 * pi), rel=1e-7)


def test_a_cycle_in_plain_python_agrees_with_the_reference_simulator() -> None:
    """Of orbits that were found without their acceleration."""
    without = METERED._replace(acceleration=None)
    orbits = [orbit_of(r, gamma, Particle(*given), forced, without) for r, gamma, given, forced in RIGID]
    asked = [(0.03, p[0], p[1], Particle(*p[2]), o.end) for p, o in zip(RIGID, orbits, strict=True)]
    for point, orbit, (peak, square) in zip(RIGID, orbits, plainly(accelerated, asked), strict=True):
        assert_accelerates(point, orbit, peak, square * point[0] / (2.0 * pi))


DWELLS = [(0.6, 0.3, 1.0, False), (1.3, 0.3, 1.0, False), (0.6, 0.8, 1.0, False), (1.3, 0.3, 1.0, True)]
"""r, γ_F, d/Z, forced."""


@pytest.mark.night
@pytest.mark.parametrize("point", DWELLS, ids=str)
def test_contacts_of_fixed_duration_agree_with_a_plain_march(point) -> None:
    """Its scan, at an eighth of a step of 0.01, sees a peak to 1e-6; in a jump of the force both take both sides."""
    r, gamma, clearance, forced = point
    peak, square, impacts, _, start = orbit_of(r, gamma, Particle(clearance, 0.6, 0.2, 0.5), forced)
    assert impacts > 0.0
    scene = dwelling.Scene(0.03, r, gamma, clearance, 0.6, 0.2, 0.5, forced)
    found, march = dwelling.end_state(scene, 1, start)
    assert found == pytest.approx(start, abs=1e-6)
    assert peak == pytest.approx(march.acceleration_peak, rel=1e-5)
    assert square == pytest.approx(march.acceleration_square * r / (2.0 * pi), rel=1e-6)


WALLS = [
    (1.3, 0.3, 1.0, (100.0, 1.0), True),
    (0.95, 0.3, 1.0, (1e4, 20.0), True),
    (0.6, 0.8, 1.0, (1e4, 20.0), True),
    (1.3, 0.3, 1.0, (100.0, 1.0), False),
    (0.6, 0.3, 1.0, (1e4, 20.0), False),
    (0.6, 0.8, 0.5, (1e4, 20.0), False),
    (0.6, 0.3, 1.0, (1e6, 2e2), False),
    (1.3, 0.3, 0.5, (1e3, 1e2), False),
]
"""r, γ_F, d/Z, stiffness and damping of the wall, forced."""


@pytest.mark.night
@pytest.mark.parametrize("point", WALLS, ids=str)
def test_compliant_walls_agree_with_a_plain_march(point) -> None:
    """The force of contact counts. Its scan, at an eighth of a fifth of the wall's own time, sees a peak to 1e-4."""
    r, gamma, clearance, wall, forced = point
    particle = Particle(clearance, 0.5, 0.1, None, Wall(*wall))
    peak, square, impacts, _, start = orbit_of(r, gamma, particle, forced)
    assert impacts > 0.0
    march = compliant_wall.Accelerated(
        compliant_wall.Scene(0.03, r, gamma, clearance, 0.1, *wall, forced=forced)
    )
    march.begin(start)
    march.run(1)
    assert [march.u, march.u_rate, march.p, march.p_rate] == pytest.approx(start, abs=1e-6)
    assert peak == pytest.approx(march.acceleration_peak, rel=1e-4)
    assert peak >= march.acceleration_peak * (1.0 - 1e-7)
    assert square == pytest.approx(march.acceleration_square * r / (2.0 * pi), rel=1e-6)


SAME = [
    (0.95, 0.3, Particle(2.0, 0.5, 0.1)),
    (0.9, 0.3, Particle(2.0, 0.5, 0.1, None, Wall(100.0, 1.0))),
    (0.9, 0.3, Particle(2.0, 0.5, 0.1, None, Wall(1e4, 20.0))),
    (1.3, 0.3, None),
]


@pytest.mark.night
@pytest.mark.parametrize("point", SAME, ids=str)
def test_a_response_has_the_same_bits_without_its_acceleration(point) -> None:
    """Some of these do not repeat: any other rounding would be another response."""
    r, gamma, particle = point
    rest = at_rest(r, gamma, particle)
    measured, end = settle(0.05, r, gamma, particle, METERED, rest)
    without, same_end = settle(0.05, r, gamma, particle, METERED._replace(acceleration=None), rest)
    assert same_end == end
    for name, one, other in zip(Response._fields, measured, without, strict=True):
        if name.startswith("acceleration"):
            assert np.isfinite(one)
            assert np.isnan(other)
        else:
            assert one == other or (np.isnan(one) and np.isnan(other)), name


def test_the_mean_peak_of_a_run_is_over_the_windows_of_the_displacement() -> None:
    random = np.random.default_rng(4)
    trace = random.random((21, COLUMNS))
    trace[:, HALF_ACCELERATION] = trace[:, 0]
    peaks = np.empty((2, 10))
    cycle_peaks(trace, 20, peaks)
    mean, square = acceleration_of_run(trace, 3, 10, True)
    assert mean == pytest.approx(peaks[0, 3:].mean(), rel=1e-15)
    assert square == trace[20, -1] - trace[6, -1]
    mean, square = acceleration_of_period(trace, 3, 6, True)
    halves = trace[1:4, HALF_ACCELERATION]
    assert mean == pytest.approx(np.maximum(halves, np.roll(halves, -1)).mean(), rel=1e-15)
    assert square == trace[6, -1]


ASKED = {
    "damping_ratio": 0.03,
    "axes": {
        "clearance_ratio": 0.5,
        "restitution": 0.5,
        "mass_ratio": 0.1,
        "friction_ratio": [0.3, 0.8],
        "frequency_ratio": [0.6, 0.95],
    },
}


METRICS = ["acceleration_ratio", "acceleration_ratio_rms", "amplitude_ratio"]


@pytest.mark.night
def test_a_study_stores_the_acceleration_where_it_asks_for_it() -> None:
    study = parse_study(ASKED | {"metrics": METRICS})
    found = solve_block(study, Block.whole(study.shape))
    for (i, gamma), (j, r) in itertools.product(enumerate((0.3, 0.8)), enumerate((0.6, 0.95))):
        peak, rms = (
            found[name][0, 0, 0, 0, i, j] for name in ("acceleration_ratio", "acceleration_ratio_rms")
        )
        particle = Particle(0.5, 0.5, 0.1)
        alone, _ = settle(0.03, r, gamma, particle, METERED, at_rest(r, gamma, particle))
        expected = (alone.acceleration_ratio, alone.acceleration_ratio_rms)
        assert (peak, rms) == pytest.approx(expected, rel=1e-8)


def test_a_study_that_asks_for_no_acceleration_is_computed_without_it() -> None:
    assert {scene.purpose for scene in scenes(parse_study(ASKED | {"metrics": METRICS}))} == {"acceleration"}
    study = parse_study(ASKED)
    assert not any(name.startswith("acceleration") for name in study.metrics)
    assert {scene.purpose for scene in scenes(study)} == {"steady"}


@pytest.mark.night
def test_the_largest_acceleration_is_that_where_the_structure_turns() -> None:
    rng = np.random.default_rng(7)
    shares = []
    for _ in range(60):
        zeta, r, gamma = 10 ** rng.uniform(-3, -1), rng.uniform(0.6, 1.6), rng.uniform(0.0, 0.8)
        particle = Particle(10 ** rng.uniform(0, 1.3), rng.uniform(0.2, 0.8), rng.uniform(0.02, 0.15))
        settings = Settings(4000, 0.5, 1e-2, True, True)
        found, _ = settle(zeta, r, gamma, particle, settings, at_rest(r, gamma, particle))
        if found.response_class != ResponseClass.LOCKED:
            acting = Acting(zeta, gamma, particle.mass_ratio)
            found_v, kind = np.array(found.relative_amplitude_ratio), np.array(int(found.response_class))
            told = accelerations(found_v, np.array(r), kind, acting)
            shares.append(found.acceleration_ratio / told)
    off = np.abs(np.array(shares) - 1.0)
    assert len(off) >= 40
    assert off.max() <= 0.06
    assert np.quantile(off, 0.9) <= 0.015
