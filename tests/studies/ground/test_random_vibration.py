"""Random vibration: the table's integral, the spectrum and the scatter of what is drawn; what is refused."""

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.signal import welch
from tests.studies.documents import faults_of, fields_of, without

from damperlab.studies.faults import StudyFaults
from damperlab.studies.ground.generated import GENERATED
from damperlab.studies.ground.motion import STANDARD_GRAVITY
from damperlab.studies.ground.random_vibration import RandomVibration, random_vibration_of
from damperlab.studies.ground.shelf import Shelf
from damperlab.studies.ground.source import read_source, read_sources
from damperlab.studies.ground.suite_reading import read_suite

TRUCK: dict[str, Any] = {
    "frequency_hz": [5, 20, 80, 200],
    "psd_g2_per_hz": [0.001, 0.01, 0.01, 0.0005],
    "duration_s": 20,
    "seed": 1,
}
"""A table with a slope of more than 6 dB per octave up and down, and a plateau."""
FALLING = RandomVibration((1.0, 8.0, 60.0), (8.0, 1.0, 1.0), 60.0, 0)
"""Its first piece falls as 1/f, where the integral is a logarithm."""


def density(vibration: RandomVibration, frequency_hz: np.ndarray) -> np.ndarray:
    """The table, interpolated in logarithms as NumPy does it."""
    points = np.log(vibration.frequency_hz), np.log(vibration.psd_m2_per_s3)
    return np.exp(np.interp(np.log(frequency_hz), *points))


def at_full_level(vibration: RandomVibration) -> tuple[np.ndarray, float]:
    """The samples between the ramps, and their step [s]."""
    motion = vibration.motion()
    edge = math.ceil(vibration.ramp_s / motion.step_s)
    return motion.acceleration_m_s2[edge:-edge], motion.step_s


@pytest.mark.parametrize("vibration", [random_vibration_of(TRUCK), FALLING])
def test_the_power_is_the_integral_of_the_table(vibration: RandomVibration) -> None:
    for end in (*vibration.frequency_hz[1:], 7.3, 41.0):
        edges = [*(f for f in vibration.frequency_hz if f < end), end]
        truth = sum(
            quad(lambda f: float(density(vibration, np.array(f))), low, high, epsrel=1e-12)[0]
            for low, high in pairwise(edges)
        )
        assert float(vibration.power(end)) == pytest.approx(truth, rel=1e-11)
    assert float(vibration.power(vibration.frequency_hz[0])) == 0.0
    assert float(vibration.power(1e4)) == pytest.approx(vibration.rms_m_s2**2, rel=1e-14)


def test_levels_in_g_are_those_in_units() -> None:
    units = [STANDARD_GRAVITY**2 * each for each in TRUCK["psd_g2_per_hz"]]
    other = without(TRUCK, "psd_g2_per_hz") | {"psd_m2_per_s3": units}
    assert random_vibration_of(other) == random_vibration_of(TRUCK)


@pytest.mark.parametrize("document", [TRUCK, TRUCK | {"frequency_hz": [5, 6, 7, 200]}])
def test_the_spectrum_of_draws_is_the_table(document: dict[str, Any]) -> None:
    """By Welch's method over segments that do not overlap, so that a bin of n segments scatters by 1/√n of its mean.

    Straight lines between the samples weaken a line by sinc²(fh), so the samples are stronger by as much. Hann's window mixes
    bins that are 1.5 Hz apart: half the second derivative of the table times its variance of 4/3 squared bins. Beside a corner,
    where that says nothing, bins are left out.
    """
    found, segments = [], 0
    for seed in range(12):
        vibration = random_vibration_of(document | {"seed": seed})
        samples, step = at_full_level(vibration)
        size = round(2.0 / step)
        frequency, level = welch(samples, 1 / step, nperseg=size, noverlap=0, detrend=False)
        found.append(level)
        segments += samples.size // size
    kept = np.all([abs(frequency - corner) > 3.0 for corner in vibration.frequency_hz], axis=0)
    kept &= (frequency > vibration.frequency_hz[0]) & (frequency < vibration.frequency_hz[-1])
    ratio = (
        np.mean(found, axis=0)[kept]
        * np.sinc(frequency[kept] * step) ** 4
        / density(vibration, frequency[kept])
    )
    # neighbouring bins share two thirds of their window: about a third of them are independent
    assert abs(ratio.mean() - 1.0) < 4.0 / math.sqrt(segments * ratio.size / 3) + 1e-3
    assert np.abs(ratio - 1.0).max() < 5.0 / math.sqrt(segments)
    assert ratio.std() == pytest.approx(1.0 / math.sqrt(segments), rel=0.25)


def test_the_mean_square_of_draws_scatters_about_the_integral_as_of_gaussian_noise() -> None:
    """Of a Gaussian process over T it has the variance (1/T)·∫S² df, with S one-sided (Bendat and Piersol, Random Data)."""
    squares = []
    for seed in range(60):
        samples, step = at_full_level(RandomVibration((10.0, 60.0), (1.0, 1.0), 20.0, seed))
        squares.append(float(np.mean(samples**2)))
    # samples are stronger than the lines between them, by the mean of 1/sinc⁴ over the band
    stronger = np.mean(np.sinc(np.linspace(10.0, 60.0, 1001) * step) ** -4.0)
    deviation = math.sqrt(50.0 / 20.0) * stronger
    assert np.mean(squares) == pytest.approx(50.0 * stronger, abs=4.0 * deviation / math.sqrt(60))
    # a standard deviation of 60 draws is known to 1/√120
    assert np.std(squares, ddof=1) == pytest.approx(deviation, rel=4.0 / math.sqrt(120))


@pytest.mark.parametrize("frequency_hz", np.linspace(10.0, 10.05, 7).tolist())
def test_a_band_narrower_than_a_step_of_frequency_is_a_sine_within_half_a_step(frequency_hz: float) -> None:
    """By its zeros, each known to what straight lines leave of a sample; over 20 s that is a hundredth of a step."""
    vibration = RandomVibration((frequency_hz, frequency_hz + 1e-4), (1.0, 1.0), 20.0, 2)
    samples, step = at_full_level(vibration)
    at = np.flatnonzero(samples[:-1] * samples[1:] < 0.0)
    zeros = at + samples[at] / (samples[at] - samples[at + 1])
    found = (zeros.size - 1) / (2.0 * step * (zeros[-1] - zeros[0]))
    assert abs(found - frequency_hz) < 0.51 / vibration.whole_s


@pytest.mark.parametrize("vibration", [random_vibration_of(TRUCK), FALLING])
def test_the_base_begins_and_ends_at_rest_where_it_was(vibration: RandomVibration) -> None:
    motion = vibration.motion()
    velocity, displacement = motion.base_motion()
    assert abs(velocity[-1]) < 1e-7 * np.abs(velocity).max()
    assert abs(displacement[-1]) < 1e-5 * np.abs(displacement).max()
    assert motion.acceleration_m_s2[0] == motion.acceleration_m_s2[-1] == 0.0
    assert motion.duration_s == pytest.approx(vibration.duration_s + 2 * vibration.ramp_s, rel=1e-12)


def test_a_definition_is_one_record_bit_for_bit() -> None:
    motion = GENERATED["random_vibration"](TRUCK)
    assert motion.digest == GENERATED["random_vibration"](TRUCK | {"name": "truck", "seed": 1.0}).digest
    assert motion.digest != GENERATED["random_vibration"](TRUCK | {"seed": 2}).digest
    source, _ = read_source({"random_vibration": TRUCK}, Shelf.none())
    assert source.called == motion.name == "random vibration from 5 to 200 Hz, seed 1"
    words = source.generated.words_at(0.5)
    assert words == "under random vibration from 5 to 200 Hz with an rms of 4.858 m/s² (0.495 g), seed 1"
    assert read_source(source.document(), None)[0] == source


def test_seeds_are_as_many_records() -> None:
    several = read_sources({"random_vibration": TRUCK | {"seeds": 3}}, Shelf.none())
    single = [read_source({"random_vibration": TRUCK | {"seed": seed}}, Shelf.none()) for seed in (1, 2, 3)]
    assert [source for source, _ in several] == [source for source, _ in single]
    suite = read_suite(
        {"records": ["el-centro", {"random_vibration": TRUCK | {"seeds": 3}}, {"kanai_tajimi": {"seeds": 2}}]}
    )
    assert len(suite.records) == 6
    assert read_suite(suite.document()).digest == suite.digest


@pytest.mark.parametrize(
    ("change", "fields"),
    [
        ({"seeds": 0}, ["seeds"]),
        ({"seeds": 101, "duration_s": 0}, ["seeds", "duration_s"]),
        ({"seeds": 3, "seed": "a"}, ["seed"]),
        ({"seeds": 3, "duration_s": -1}, ["duration_s"]),
        ({"frequency_hz": [5, 20, 20, 200]}, ["frequency_hz[2]"]),
        ({"frequency_hz": [5, 20, 80, 2e4]}, ["frequency_hz[3]"]),
        ({"frequency_hz": [5, 20, 80]}, ["psd_g2_per_hz"]),
        ({"frequency_hz": 5}, ["frequency_hz"]),
        ({"psd_g2_per_hz": [0, 1, 1, 1], "duration_s": "long"}, ["duration_s", "psd_g2_per_hz[0]"]),
        ({"psd_m2_per_s3": [1, 1, 1, 1]}, ["psd_g2_per_hz"]),
        ({"duration_s": 1000}, ["duration_s"]),
        ({"levels": 1, "name": 3}, ["levels", "name"]),
    ],
)
def test_every_fault_is_said_at_once_where_it_stands(change: dict[str, Any], fields: list[str]) -> None:
    faults = faults_of(read_sources, {"random_vibration": TRUCK | change}, Shelf.none())
    assert [fault.field for fault in faults] == [f"random_vibration.{field}" for field in fields]
    assert all(fault.found and fault.allowed and fault.advice for fault in faults)


def test_what_is_missing_is_said() -> None:
    missing = {field.rpartition(".")[2] for field in fields_of(random_vibration_of, {})}
    assert missing == {"duration_s", "random_vibration", "frequency_hz"}
    with pytest.raises(StudyFaults, match="must be a mapping"):
        random_vibration_of([])
