"""Swept sines: their laws against differences and integrals; what is refused."""

import json
import math
from typing import Any

import numpy as np
import pytest
from tests.studies.documents import without

from damperlab.studies.faults import StudyFaults
from damperlab.studies.ground.generated import GENERATED
from damperlab.studies.ground.shelf import Shelf
from damperlab.studies.ground.source import read_source
from damperlab.studies.ground.sweep import sweep_of

INTERPOLATION = 1e-3
"""How far a straight line from sample to sample is from the acceleration, at most, over its largest value."""
UP: dict[str, Any] = {"start_hz": 6, "stop_hz": 10, "rate_hz_per_s": 0.5, "base_amplitude_m": 0.001}
DOWN = UP | {"start_hz": 10, "stop_hz": 6}
OCTAVES = {"start_hz": 6, "stop_hz": 12, "rate_octaves_per_minute": 10, "base_velocity_m_per_s": 0.05}
ACCELERATED = {"start_hz": 12, "stop_hz": 3, "rate_octaves_per_minute": 20, "base_acceleration_m_per_s2": 2}
BY_VELOCITY = without(UP, "base_amplitude_m") | {"base_velocity_m_per_s": 0.05}
SWEEPS = [UP, DOWN, OCTAVES, ACCELERATED, BY_VELOCITY]


@pytest.mark.parametrize("document", SWEEPS)
def test_velocity_and_acceleration_are_the_derivatives_of_the_displacement(document: dict[str, Any]) -> None:
    """By central differences over h, off by h²/6·z''' ~ (ωh)²/6; rounding adds 1e-16/(ωh)."""
    sweep = sweep_of(document)
    h = 1e-5 / sweep.highest_hz
    time = np.linspace(h, sweep.duration_s - h, 997)
    before, at, after = (sweep.base(time + shift) for shift in (-h, 0.0, h))
    for order in (0, 1):
        slope = (after[order] - before[order]) / (2 * h)
        np.testing.assert_allclose(slope, at[order + 1], atol=1e-8 * np.abs(at[order + 1]).max())


@pytest.mark.parametrize("document", SWEEPS)
def test_the_base_begins_and_ends_at_rest_and_goes_where_straight_lines_between_the_samples_say(
    document: dict[str, Any],
) -> None:
    sweep = sweep_of(document)
    for derivative in sweep.base([0.0, sweep.duration_s]):
        assert derivative.tolist() == [0.0, 0.0]
    motion = sweep.motion()
    velocity, displacement = motion.base_motion()
    # the record, integrated as straight lines, comes back: its samples have no drift of their own
    assert abs(velocity[-1]) < 1e-7 * np.abs(velocity).max()
    assert abs(displacement[-1]) < 1e-5 * np.abs(displacement).max()
    assert motion.duration_s == pytest.approx(sweep.duration_s, rel=1e-12)
    time = np.linspace(0.0, sweep.duration_s, 8 * (sweep.samples - 1) + 1)
    z, _, exact = sweep.base(time)
    lines = np.interp(time, time[::8], motion.acceleration_m_s2)
    assert np.abs(lines - exact).max() <= INTERPOLATION * np.abs(exact).max()
    assert np.abs(displacement - z[::8]).max() <= INTERPOLATION * np.abs(z).max()


@pytest.mark.parametrize("document", SWEEPS)
def test_the_amplitude_is_constant_between_the_ramps(document: dict[str, Any]) -> None:
    """That of the displacement exactly; of a derivative but for (ω'/ω²)² ~ 1e-5, and an extremum is met to (ωh)²/8."""
    sweep = sweep_of(document)
    time = np.linspace(sweep.rise_s, sweep.duration_s - sweep.fall_s, 200_001)
    constant = np.abs(sweep.base(time)[sweep.order])
    cycles = np.array_split(constant, 20)
    assert len({round(float(each.max()) / sweep.amplitude, 3) for each in cycles}) == 1
    assert constant.max() == pytest.approx(sweep.amplitude, rel=1e-3)


@pytest.mark.parametrize("document", SWEEPS)
def test_the_phase_is_the_integral_of_the_frequency(document: dict[str, Any]) -> None:
    sweep = sweep_of(document)
    ends = np.array([0.3, 0.7, 1.0]) * sweep.duration_s
    for end in ends:
        nodes, weights = np.polynomial.legendre.leggauss(24)
        time = end / 2 * (nodes + 1)
        integral = 2 * math.pi * end / 2 * (weights @ sweep.frequency_hz(time))
        assert sweep.phase(end) == pytest.approx(integral, rel=1e-13)
    assert sweep.frequency_hz([0.0, sweep.duration_s]) == pytest.approx(
        [document["start_hz"], document["stop_hz"]]
    )
    middle = float(sweep.frequency_hz(sweep.duration_s / 2))
    start, stop = document["start_hz"], document["stop_hz"]
    mean = math.sqrt(start * stop) if "rate_octaves_per_minute" in document else (start + stop) / 2
    assert middle == pytest.approx(mean, rel=1e-12)


def test_a_duration_is_a_rate() -> None:
    lasting = without(UP, "rate_hz_per_s") | {"duration_s": 8.0}
    assert sweep_of(lasting) == sweep_of(UP)
    assert sweep_of(OCTAVES).duration_s == 6.0
    assert GENERATED["sweep"](lasting).digest == GENERATED["sweep"](UP).digest


@pytest.mark.parametrize(
    ("document", "field", "words"),
    [
        ([], "sweep", "must be a mapping"),
        (without(UP, "start_hz"), "sweep.start_hz", "missing"),
        (UP | {"start_hz": 0}, "sweep.start_hz", "0.02 to 1000"),
        (UP | {"stop_hz": 6}, "sweep.stop_hz", "the two must differ"),
        (UP | {"stop": 10}, "sweep.stop", "not a known key"),
        (without(UP, "rate_hz_per_s"), "sweep", "how fast the frequency changes"),
        (UP | {"duration_s": 8}, "sweep.duration_s", "`sweep.rate_hz_per_s` both state how fast"),
        (without(UP, "base_amplitude_m"), "sweep", "how far the base moves"),
        (
            UP | {"base_velocity_m_per_s": 1},
            "sweep.base_velocity_m_per_s",
            "both state how far the base moves",
        ),
        (UP | {"ramp_cycles": 1}, "sweep.ramp_cycles", "4 to 1000"),
        (UP | {"rate_hz_per_s": 5}, "sweep.rate_hz_per_s", "takes 1.067 s to rise and fall"),
        (UP | {"rate_hz_per_s": 0.005}, "sweep.rate_hz_per_s", "a record may have at most 400,000"),
        (UP | {"base_amplitude_m": 100}, "sweep", "at most 10000 m/s² is allowed"),
        (UP | {"name": 3}, "sweep.name", "short text"),
    ],
)
def test_what_is_no_sweep_is_refused_where_it_stands(document: object, field: str, words: str) -> None:
    with pytest.raises(StudyFaults, match=words) as caught:
        GENERATED["sweep"](document)
    assert [fault.field for fault in caught.value.faults] == [field]


def test_a_sweep_is_a_record_with_one_digest() -> None:
    source, motion = read_source({"sweep": UP}, Shelf.none())
    assert (source.id, source.sha256) == (f"u-{motion.digest}", motion.sha256)
    assert motion.name == source.called == "sweep from 6 to 10 Hz at 0.5 Hz/s"
    assert motion.source == "Swept from 6 to 10 Hz at 0.5 Hz/s with a base amplitude of 1 mm"
    # whatever it is called, however its numbers are written and in whatever order its keys stand
    other = dict(reversed([(key, float(value)) for key, value in UP.items()])) | {"name": "run-up"}
    assert GENERATED["sweep"](other).digest == motion.digest
    assert GENERATED["sweep"](DOWN).digest != motion.digest
    # and as a stored study has it: with its samples looked up, or without
    held = json.loads(json.dumps(source.document()))
    assert read_source(held, Shelf.none())[0] == read_source(held, None)[0] == source
    with pytest.raises(StudyFaults, match="have changed"):
        read_source(held | {"sha256": "0" * 64}, Shelf.none())
    with pytest.raises(StudyFaults, match="generated in one way"):
        read_source({"sweep": UP, "kanai_tajimi": {}}, Shelf.none())
