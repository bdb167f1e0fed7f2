"""What is advised and remarked: a refused study leads to the one that was meant, an odd one is told how it was understood."""

import math
from typing import Any

import numpy as np
import pytest
from tests.studies.documents import faults_of, without

from damperlab.studies.definition import Study, parse_study
from damperlab.studies.faults import Fault
from damperlab.studies.reading import parse_study_text
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


def frame(**changes: Any) -> dict[str, Any]:
    return {"physical": {name: value for name, value in (FRAME | changes).items() if value is not None}}


def faults(document: dict[str, Any]) -> tuple[Fault, ...]:
    return faults_of(parse_study, document)


@pytest.mark.parametrize(
    ("key", "constant", "law"),
    [
        ("base_acceleration_m_per_s2", "acceleration", lambda level, rate: level / rate**2),
        ("base_velocity_m_per_s", "velocity", lambda level, rate: level / rate),
    ],
)
@pytest.mark.parametrize("more", [{}, {"constant": True}, {"base_amplitude_m": 8e-5}])
def test_a_key_of_designs_for_the_base_leads_to_the_study_that_keeps_it(
    key: str, constant: str, law: Any, more: dict[str, Any]
) -> None:
    given: dict[str, Any] = {"base_amplitude_m": None, key: 0.196} | more
    if "constant" in more:
        given["constant"] = constant
    (fault,) = faults(frame(**given))
    amplitude = law(0.196, 2 * math.pi * 11.3)
    assert fault.field == f"physical.{key}"
    assert f"`constant: {constant}` and `base_amplitude_m: [{amplitude:.10g}]`" in fault.advice
    written = parse_study(frame(constant=constant, base_amplitude_m=[float(f"{amplitude:.10g}")]))
    assert isinstance(written, Study)
    assert written.over_amplitudes


def test_a_key_of_designs_for_the_base_is_removed_where_a_force_excites_the_structure() -> None:
    document = frame(base_amplitude_m=None, force_n=3.0, base_acceleration_m_per_s2=0.196) | {
        "excitation": "force"
    }
    (fault,) = faults(document)
    assert fault.field == "physical.base_acceleration_m_per_s2"
    assert fault.advice == "remove it"
    del document["physical"]["base_acceleration_m_per_s2"]
    assert parse_study(document)


def test_the_amplitude_of_a_constant_acceleration_is_a_list_also_where_it_is_one() -> None:
    (fault,) = faults(frame(constant="acceleration"))
    assert fault.field == "physical.constant"
    assert "`base_amplitude_m: [8e-05]`" in fault.advice
    assert parse_study(frame(constant="acceleration", base_amplitude_m=[8e-5]))


@pytest.mark.parametrize(
    ("field", "text", "advised"),
    [
        ("damping_ratio", "1.1 %", "1.1 % is 0.011"),
        ("damping_ratio", "0,011", "use a decimal point, as in 0.011; a number has no commas"),
        ("damping_ratio", "0.011", "without quotation marks"),
        ("physical.friction_force_n", "1,000", "as in 1.000, or write 1000 if thousands are meant"),
        ("physical.base_amplitude_m", "0.08 mm", "write the number alone, in m"),
        ("physical.friction_force_n", "5 %", "write the number alone, in N"),
        ("physical.excitation_frequency_hz", "9-14", "{start: 9, stop: 14, num: 11}"),
        ("physical.excitation_frequency_hz", "9 to 14", "{start: 9, stop: 14, num: 11}"),
    ],
)
def test_a_text_in_place_of_a_number_is_answered_with_the_number_that_is_meant(
    field: str, text: str, advised: str
) -> None:
    name = field.removeprefix("physical.")
    document = frame() | {name: text} if name == field else frame(**{name: text})
    (fault,) = faults(document)
    assert fault.field == field
    assert advised in fault.advice
    assert ("quotation" in fault.advice) == (text == "0.011")


@pytest.mark.parametrize(
    ("more", "advised"),
    [
        ({"step": 0.25}, "`num: 21`"),
        ({"step": 0.3}, "`num`"),
        ({"steps": 21}, "`num`"),
        ({"steps": 21, "num": 21}, "remove it"),
        ({"numb": 21}, "`num`"),
    ],
)
def test_a_step_of_a_range_becomes_the_number_of_its_values(more: dict[str, Any], advised: str) -> None:
    found = faults(frame(excitation_frequency_hz={"start": 9, "stop": 14} | more))
    (key,) = (name for name in more if name != "num")
    (fault,) = (each for each in found if each.field.endswith(f".{key}"))
    assert advised in fault.advice
    assert "stop" not in fault.advice


def test_a_key_that_stands_there_is_not_advised_again() -> None:
    def advice(document: dict[str, Any], key: str) -> str:
        (found,) = (each.advice for each in faults(document) if each.field.endswith(key))
        return found

    assert "excitation_frequency_hz" in advice(
        frame(excitation_frequency_hz=None, frequency_hz=10), ".frequency_hz"
    )
    assert advice(frame(mass_k=42), "mass_k") == "remove it"
    assert "mass_kg" in advice(frame(mass_kg=None, mass_k=42), "mass_k")
    assert advice(frame() | {"solvr": {}, "solver": {"method": "event"}}, "solvr") == "remove it"
    contact = {"model": "dwell", "contact_time": 0.1, "contact_tim": 0.1}
    assert advice(frame() | {"contact": contact}, "contact_tim") == "remove it"


@pytest.mark.parametrize(
    ("key", "said"),
    [
        ("double_amplitude_m", "half of a peak-to-peak value"),
        ("peak_to_peak_amplitude_m", "half of a peak-to-peak value"),
        ("base_amplitude_rms_m", "not an rms"),
        ("base_ampiltude_m", "`base_amplitude_m`?"),
    ],
)
def test_a_key_of_another_value_of_a_motion_is_not_taken_for_a_misspelled_amplitude(
    key: str, said: str
) -> None:
    found = faults(frame(base_amplitude_m=None, **{key: 8e-5}))
    (fault,) = (each for each in found if each.field.endswith(key))
    assert "did you mean `base_amplitude_m`" in fault.advice
    assert said in fault.advice


@pytest.mark.parametrize(
    "text",
    [
        "axes:\n\tfrequency_ratio: 1",
        "axes:\n  clearance_ratio:\t1\n\tfrequency_ratio: 1",
        "axes:\n  clearance_ratio: 1\n\t  frequency_ratio: 1",
    ],
)
def test_a_tab_before_a_key_is_called_a_tab(text: str) -> None:
    (fault,) = faults_of(parse_study_text, text, "yaml")
    assert f"at line {text.count(chr(10)) + 1}, column 1: a tab" in fault.sentence


NO_WORD = "choose one of these"


SCENE = {"axes": {"clearance_ratio": 3, "frequency_ratio": 1}}


@pytest.mark.parametrize(
    ("part", "advice"),
    [
        ({"contact": {"model": "dwel"}}, "write dwell"),
        ({"contact": {"model": "sandstone"}}, NO_WORD),
        ({"start": "rset"}, "write rest"),
        ({"start": {"kind": "continuatoin"}}, "write continuation"),
        ({"start": {"kind": "elsewhere"}}, NO_WORD),
        ({"solver": {"method": "evnt"}}, "write event"),
        ({"excitation": "bas"}, "write base"),
        ({"excitation": "moon"}, NO_WORD),
    ],
)
def test_a_word_is_advised_where_one_is_near(part: dict[str, Any], advice: str) -> None:
    (fault,) = faults(SCENE | part)
    assert fault.advice == advice


def test_a_start_from_rest_may_be_written_as_those_with_settings_are() -> None:
    assert parse_study(SCENE | {"start": {"kind": "rest"}}) == parse_study(SCENE | {"start": "rest"})
    assert parse_study(SCENE | {"start": "rest"}) == parse_study(SCENE)


def test_a_start_without_its_kind_is_told_so_and_what_of_it_is_unknown() -> None:
    missing, unknown = faults(SCENE | {"start": {"ensemble": {"n": 4}}})
    assert (missing.field, missing.found) == ("start.kind", "nothing")
    assert "`kind: ensemble`" in missing.advice
    assert unknown.field == "start.ensemble"
    assert "kind, n, seed, direction" in unknown.allowed
    (alone,) = faults(SCENE | {"start": {"n": 4}})
    assert (alone.field, alone.found) == ("start.kind", "nothing")


@pytest.mark.parametrize(
    ("document", "field"),
    [
        (frame(clearance_m=None, clearence_m=0.001), "physical.clearence_m"),
        (frame(clearance_m=None, clearance_mm=1), "physical.clearance_mm"),
        (frame(base_amplitude_m=None, base_amplitud_m=8e-5), "physical.base_amplitud_m"),
        ({"axes": {"clearance_ratioo": 5, "frequency_ratio": 1}}, "axes.clearance_ratioo"),
        ({"clearance_ratio": 5, "axes": {"frequency_ratio": 1}}, "clearance_ratio"),
    ],
)
def test_an_unknown_key_that_stands_for_a_missing_one_is_one_mistake(
    document: dict[str, Any], field: str
) -> None:
    (fault,) = faults(document)
    assert fault.field == field


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
SLOW = {"mass_kg": 42, "natural_frequency_hz": 71.0, "damping_ratio": 0.011}
HEAVY, MOVES, WIDE, RUBS = "heavier", "10 times as far", "larger than any motion", "more than 100 times"


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"particle_mass_kg": 3000}, HEAVY),
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
        ({"structure": SLOW}, 0.002, {}, "all far below the natural frequency 71 Hz"),
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
