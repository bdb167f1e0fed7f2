"""What is said of how a study was understood: of what was left out, of its ratios, and of what is certainly a slip."""

from typing import Any

import numpy as np
import pytest
from tests.studies.documents import without

from damperlab.studies.definition import Study, parse_study
from damperlab.studies.specification.reading import parse_specification
from damperlab.studies.understood import ratios, understood, unusual_specification

FRAME: dict[str, Any] = {
    "mass_kg": 42,
    "natural_frequency_hz": 11.3,
    "base_amplitude_m": 8e-5,
    "particle_mass_kg": 3,
    "clearance_m": [0.0002, 0.002],
    "friction_force_n": [0, 16],
    "excitation_frequency_hz": [9, 11, 14],
}


def said(physical: dict[str, Any], **more: Any) -> str:
    return "\n".join(understood(parse_study({"physical": physical} | more)))


def test_what_was_left_out_is_said_with_the_value_that_it_has() -> None:
    assert said(FRAME).splitlines()[0] == (
        "Not given, and assumed: structural damping ratio ζ = 0.0038, coefficient of restitution e = 0.47, "
        "a lying, frictionless cavity."
    )
    assert "a frictionless cavity" in said(FRAME | {"tilt_deg": 90})
    rubbing = FRAME | {"particle_friction_coefficient": 0.1}
    assert "a lying cavity" in said(rubbing)
    assert "a lying cavity" in said(rubbing | {"base_amplitude_m": [4e-5, 8e-5]})
    ratio = parse_study({"axes": {"frequency_ratio": 1, "clearance_ratio": 3, "friction_ratio": 0.1}})
    (line,) = understood(ratio)
    assert "ζ = 0.0038" in line
    assert "β = 0.1" in line
    assert "γ_F" not in line
    (alone,) = understood(parse_study({"particle": False, "axes": {"frequency_ratio": 1}}))
    assert alone == "Not given, and assumed: structural damping ratio ζ = 0.0038, friction ratio γ_F = 0."
    stated = FRAME | {"particle_friction_coefficient": 0.1, "tilt_deg": 0}
    assert "assumed" not in said(stated, damping_ratio=0.011, axes={"restitution": 0.47})
    assert understood(parse_study(ratio.document())) == []
    assert parse_study(ratio.document()) == ratio


def test_the_ratios_of_a_physical_study_are_told_in_one_line() -> None:
    (line,) = [each for each in said(FRAME).splitlines() if each.startswith("In ratios")]
    assert line == "In ratios: β = 0.0714, d/Z = 2.5 to 25, γ_F = 0 to 0.945, r = 0.796 to 1.24."


def test_over_base_amplitudes_the_ratios_reach_from_corner_to_corner() -> None:
    study = parse_study({"physical": FRAME | {"base_amplitude_m": [4e-5, 8e-5], "constant": "acceleration"}})
    assert isinstance(study, Study)
    grids = np.meshgrid(*study.coordinates.values(), indexing="ij")
    every = study.ratios(dict(zip(study.coordinates, grids, strict=True)))
    for name, ends in ratios(study).items():
        assert ends == (every[name].min(), every[name].max())


SLIPPERY = {"particle_friction_coefficient": 2.0}
STUCK = {"particle_friction_coefficient": 30.0}
"""As large as no pair of materials has it."""
HEAVY, MOVES, WIDE, RUBS = "heavier", "10 times as far", "larger than any motion", "more than 100 times"


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"particle_mass_kg": 3000}, HEAVY),
        ({"base_amplitude_m": 0.08}, MOVES),
        ({"clearance_m": [0.2, 2.0]}, WIDE),
        ({"friction_force_n": [16e3, 32e3]}, RUBS),
        (STUCK, "μ_i = 30 or more"),
    ],
)
def test_what_is_certainly_unusual_is_remarked(changed: dict[str, Any], words: str) -> None:
    assert words in said(FRAME | changed)


@pytest.mark.parametrize("usual", [{}, SLIPPERY])
def test_what_is_usual_is_not_remarked(usual: dict[str, Any]) -> None:
    assert "check" not in said(FRAME | usual)
    assert "μ_i" not in said(FRAME | usual)


def test_a_band_far_from_the_natural_frequency_is_remarked() -> None:
    """11.3 Hz are 71 rad/s: written as Hz, the band of 9 to 14 Hz lies at r = 0.13 to 0.2."""
    words = said(FRAME | {"natural_frequency_hz": 71.0})
    assert "all far below the natural frequency 71 Hz" in words
    assert "71 rad/s are 11.3 Hz" in words
    assert "all far above the natural frequency 2 Hz" in said(FRAME | {"natural_frequency_hz": 2.0})
    assert "all far" not in said(FRAME)
    # a single frequency is no band
    assert "all far" not in said(FRAME | {"natural_frequency_hz": 71.0, "excitation_frequency_hz": 9.0})
    structure = {"mass_kg": 42, "damping_ratio": 0.011}
    for natural, told in ((71.0, True), (11.3, False)):
        asked = parse_specification(
            {
                "structure": structure | {"natural_frequency_hz": natural},
                "excitation": {"base_amplitude_m": 1e-4, "frequency_hz": {"start": 9, "stop": 14}},
                "choose": {"clearance_m": {"start": 0.0002, "stop": 0.002}},
                "friction_force_n": 10,
                "particle_mass_kg": 3,
                "restitution": 0.5,
            }
        )
        assert ("all far below" in "".join(unusual_specification(asked))) is told


def test_a_base_that_shakes_harder_than_anything_is_remarked() -> None:
    """Millimetres written as metres throughout keep every ratio."""
    metres = {"base_amplitude_m": 0.08, "clearance_m": [0.2, 2]}
    assert "The base shakes with at least 26.1 g: check the units of `base_amplitude_m`" in said(
        FRAME | metres
    )
    assert "shakes" not in said(FRAME)


def test_under_a_force_what_is_unusual_is_said_of_the_force() -> None:
    words = said(without(FRAME, "base_amplitude_m") | {"force_n": 17e3}, excitation="force")
    assert "The static displacement is more than 10 times the clearance (d/Z" in words
    assert "`clearance_m` and `force_n`" in words
    assert "base" not in words


@pytest.mark.parametrize(
    ("changed", "clearance", "base", "words"),
    [
        ({"particle_mass_kg": 3000}, 0.002, {}, HEAVY),
        ({}, 0.002, {"base_amplitude_m": 0.3}, MOVES),
        ({}, 0.002, {"base_acceleration_m_per_s2": 1e3}, "`clearance_m` and `base_acceleration_m_per_s2`"),
        ({}, 0.002, {"force_n": 17e4}, "The static displacement is more than 10 times the clearance"),
        ({}, [0.5, 2.0], {}, WIDE),
        ({}, [0.5, 2.0], {"base_amplitude_m": 0.3}, "check the units of `base_amplitude_m`"),
        ({"friction_force_n": 16e3}, 0.002, {}, RUBS),
        ({"limits": {"displacement_m": 2.0}}, 0.002, {}, "check the unit of `limits.displacement_m`"),
        ({"limits": {"displacement_m": 0.004}}, 0.002, {}, ""),
        (STUCK, 0.002, {}, "μ_i = 30 or more"),
        (SLIPPERY, 0.002, {}, ""),
        ({}, 2.0, {}, ""),
        ({}, 0.002, {}, ""),
    ],
)
def test_what_is_certainly_unusual_in_a_specification_is_remarked(
    changed: dict[str, Any], clearance: float | list[float], base: dict[str, Any], words: str
) -> None:
    start, stop = clearance if isinstance(clearance, list) else (0.0002, clearance)
    asked = parse_specification(
        {
            "structure": {"mass_kg": 42, "natural_frequency_hz": 11.3, "damping_ratio": 0.011},
            "excitation": (base or {"base_amplitude_m": 1e-4}) | {"frequency_hz": {"start": 9, "stop": 14}},
            "choose": {"clearance_m": {"start": start, "stop": stop}},
            "friction_force_n": 10,
            "particle_mass_kg": 3,
            "restitution": 0.5,
        }
        | changed
    )
    found = "".join(unusual_specification(asked))
    assert words in found
    assert bool(words) == bool(found)


@pytest.mark.parametrize(
    ("document", "told"),
    [
        ({"physical": FRAME | {"excitation_frequency_hz": [9, 14]}}, "{start: 9, stop: 14, num: 21}"),
        ({"axes": {"frequency_ratio": [0.9, 1.1], "clearance_ratio": 3}}, "{start: 0.9, stop: 1.1, num: 21}"),
        ({"axes": {"frequency_ratio": [0.9, 1, 1.1], "clearance_ratio": 3}}, ""),
        ({"axes": {"frequency_ratio": {"start": 1, "stop": 2, "num": 2}, "clearance_ratio": 3}}, ""),
    ],
)
def test_two_frequencies_are_said_to_be_two(document: dict[str, Any], told: str) -> None:
    lines = [each for each in understood(parse_study(document)) if each.startswith("Two ")]
    assert len(lines) == bool(told)
    assert told in "".join(lines)
