"""Specifications as documents: one reading of every spelling, every fault at once, and what is refused with its reason."""

import copy
import json
import math
from pathlib import Path
from typing import Any

import pytest
from tests.studies.documents import told_of, without

from damperlab.studies.design.spelling import transients, under_records
from damperlab.studies.faults import StudyFaults
from damperlab.studies.ground.builtin import builtin_record
from damperlab.studies.ground.shelf import Shelf
from damperlab.studies.named import named_specifications
from damperlab.studies.specification.excitation import Amplitude
from damperlab.studies.specification.reading import (
    parse_specification,
    read_specification,
)
from damperlab.studies.specification.specification import Choice

PROTOTYPE: dict[str, Any] = {
    "name": "prototype",
    "structure": {"mass_kg": 1.605, "natural_frequency_hz": 2.5, "damping_ratio": 0.0038},
    "excitation": {"base_amplitude_m": 0.0015, "frequency_hz": {"start": 2.0, "stop": 3.125}},
    "choose": {
        "clearance_m": {"start": 0.0015, "stop": 0.03},
        "friction_force_n": {"start": 0, "stop": 0.42},
    },
    "particle_mass_kg": 0.1605,
    "restitution": 0.47,
    "tolerances": {"clearance_m": 0.0005, "friction_force_n": "10%"},
    "limits": {"impact_speed_m_per_s": 1.0, "cavity_length_m": 0.05},
    "measure": "worst_displacement",
    "confidence": 0.9,
    "budget_minutes": 8,
}
RATIOS: dict[str, Any] = {
    "structure": {"damping_ratio": 0.0038},
    "excitation": {"frequency_ratio": {"start": 0.8, "stop": 1.25}},
    "choose": {
        "clearance_ratio": {"start": 1.0, "stop": 20.0},
        "friction_ratio": {"start": 0.0, "stop": 0.8},
    },
    "mass_ratio": 0.1,
    "restitution": 0.47,
}


def changed(path: str, value: object) -> dict[str, Any]:
    document = copy.deepcopy(PROTOTYPE)
    *parents, last = path.split(".")
    held = document
    for key in parents:
        held = held.setdefault(key, {})
    held[last] = value
    return document


def faults_of(document: object) -> dict[str, str]:
    return told_of(parse_specification, document)


def test_ratios_say_the_same_as_units() -> None:
    asked = parse_specification(PROTOTYPE | {"limits": {}})
    force_n = asked.structure.stiffness_n_per_m * 0.0015
    choose = RATIOS["choose"] | {"friction_ratio": {"start": 0.0, "stop": 0.42 / force_n}}
    ratios = parse_specification(RATIOS | {"choose": choose})
    assert not ratios.in_units
    # with k = 1 N/m and Z = 1 m a ratio is its quantity
    assert ratios.structure.stiffness_n_per_m == pytest.approx(1.0, rel=1e-15)
    for name, scale in (
        ("clearance_m", 0.0015),
        ("friction_force_n", force_n),
        ("particle_mass_kg", 1.605),
        ("restitution", 1.0),
    ):
        assert ratios.choices[name].stop * scale == pytest.approx(asked.choices[name].stop, rel=1e-14)


def test_a_force_makes_its_static_displacement() -> None:
    document = PROTOTYPE | {"excitation": {"force_n": {"start": 0.2, "stop": 0.6}, "frequency_hz": 2.5}}
    asked = parse_specification(document)
    (one,) = asked.excitations
    assert one.motion.force
    stiffness = asked.structure.stiffness_n_per_m
    assert (one.lowest_m, one.highest_m) == pytest.approx((0.2 / stiffness, 0.6 / stiffness), rel=1e-14)
    assert asked.level(one.largest) == pytest.approx(0.6, rel=1e-14)


def choice_of(*materials: dict[str, Any]) -> Choice:
    """Read a specification that chooses among materials; give the choice."""
    document = without(changed("choose.restitution", list(materials)), "restitution")
    return parse_specification(document).choices["restitution"]


def test_every_fault_is_named_at_once() -> None:
    document = PROTOTYPE | {
        "structure": {"mass_kg": -1, "natural_frequency_hz": 2.5, "damping_ratio": 2},
        "excitation": {"base_amplitude_m": "1.5 mm", "frequency_hz": {"start": 3, "stop": 2}},
        "choose": {"clearence_m": {"start": 1, "stop": 2}},
        "mesure": "worst_displacement",
        "confidence": 2,
        "builds": 1.5,
    }
    del document["measure"]  # a key that is there is not advised again
    found = faults_of(document)
    assert found.keys() >= {
        "structure.mass_kg",
        "structure.damping_ratio",
        "excitation.base_amplitude_m",
        "excitation.frequency_hz.stop",
        "choose.clearence_m",
        "mesure",
        "confidence",
        "builds",
        "friction_force_n",
    }
    assert "clearance_m" not in found  # the misspelt key stands for it
    assert "did you mean `measure`" in found["mesure"].lower()


@pytest.mark.parametrize(
    ("path", "value", "field", "words"),
    [
        ("excitation.force_n", 3.0, "excitation.force_n", "both given"),
        ("excitation.base_velocity_m_per_s", {"start": 2, "stop": 1}, "excitation.base_velocity_m_per_s", "both given"),
        ("excitation.sweep", 0.1, "excitation.sweep", "must be a mapping"),
        ("excitation.records", [], "excitation.records", "a list of 1 to 50 records"),
        ("measure", 3, "measure", "one of worst_displacement"),
        ("judge", "often", "judge", "one of rest, worst"),
        ("judge", "worst", "judge", "the displacement of the structure alone"),
        ("limits.cavity_length_m", 0.002, "limits.cavity_length_m", "relax it to at least 0.004"),
        ("tolerances.clearance_m", 0.001, "tolerances.clearance_m", "more than half of the smallest specified value, 0.0015"),
        ("tolerances.mass_kg", "60%", "tolerances.mass_kg", "from 0% to 50%, not the text \"60%\""),
        ("tolerances.mass_kg", "5 %%", "tolerances.mass_kg", "Write 10% for a tenth"),
        ("budget_points", 5000, "budget_points", "both given"),
        ("structure.stiffness_n_per_m", 4.0, "structure.stiffness_n_per_m", "state the same quantity"),
        ("choose.restitution", 0.5, "choose.restitution", "outside `choose"),
        ("choose.restitution", {"start": 0.1, "stop": 0.5}, "restitution", "twice"),
        ("choose", 3, "choose", "a mapping"),
        ("choose.clearance_m", [0.004], "choose.clearance_m", "another value"),
    ],
)  # fmt: skip
def test_what_a_design_does_not_know_is_refused_with_its_reason(
    path: str, value: object, field: str, words: str
) -> None:
    found = faults_of(changed(path, value))
    assert words.lower() in found[field].lower()


def test_what_is_missing_is_named_and_anything_else_is_refused() -> None:
    for key in ("structure", "excitation", "choose", "restitution", "particle_mass_kg"):
        assert key in faults_of(without(PROTOTYPE, key))
    for document in (None, [], 3, "text", {}, {"structure": 3, "excitation": []}):
        assert faults_of(document)


def test_a_file_is_read_by_its_suffix_and_a_named_specification_by_its_name(tmp_path: Path) -> None:
    path = tmp_path / "spec.json"
    path.write_text(json.dumps(PROTOTYPE))
    assert read_specification(str(path)).digest == parse_specification(PROTOTYPE).digest
    for name in ("spec.txt", "missing.yaml"):
        with pytest.raises(StudyFaults):
            read_specification(str(tmp_path / name))
    assert all(read_specification(name).name == name for name in named_specifications())
    with pytest.raises(StudyFaults, match="Did you mean prototype"):
        read_specification("prototyp")


def test_a_name_and_keys_without_a_value_are_no_part_of_what_is_asked() -> None:
    digest = parse_specification(PROTOTYPE).digest
    assert parse_specification(PROTOTYPE | {"name": "other"}).digest == digest
    assert parse_specification(PROTOTYPE | {"confidence": 0.8}).digest != digest
    keys = ("limits", "tolerances", "name")
    empty = PROTOTYPE | dict.fromkeys(keys)
    assert parse_specification(empty).digest == parse_specification(without(PROTOTYPE, *keys)).digest
    assert "structure" in faults_of(PROTOTYPE | {"structure": None})


@pytest.mark.parametrize(
    ("order", "key"), [(0, "amplitude_m"), (1, "velocity_m_per_s"), (2, "acceleration_m_per_s2")]
)
def test_a_base_motion_makes_the_displacement_that_its_derivative_has(order: int, key: str) -> None:
    document = changed("excitation", {f"base_{key}": {"start": 0.02, "stop": 0.05}, "frequency_hz": 3.0})
    asked = parse_specification(document)
    omega = 2 * math.pi * 3.0
    for told, reference_m in ((0.02, asked.excitations[0].lowest_m), (0.05, asked.excitations[0].highest_m)):
        # z = Z sin ωt has derivatives of the amplitudes ωZ and ω²Z
        amplitude_m = asked.excitations[0].base_m(reference_m, asked.excitations[0].low)
        assert omega**order * amplitude_m == pytest.approx(told, rel=1e-14)
        assert asked.level(Amplitude(asked.excitations[0], reference_m)) == pytest.approx(told, rel=1e-14)
    assert asked.in_units


SWEEP = {"start_hz": 2, "stop_hz": 3, "rate_hz_per_s": 0.1, "base_amplitude_m": 0.001}
DOWN = SWEEP | {"start_hz": 3, "stop_hz": 2}
ONE = {"name": "idle", "base_amplitude_m": 0.001, "frequency_hz": {"start": 2.0, "stop": 3.0}}


def test_several_excitations_are_read_with_their_names_and_ratios_are_over_the_largest() -> None:
    other = {"base_acceleration_m_per_s2": {"start": 0.2, "stop": 1.0}, "frequency_ratio": 1.1}
    asked = parse_specification(PROTOTYPE | {"excitation": [ONE, other]})
    assert [each.name for each in asked.excitations] == ["idle", "excitation 2"]
    assert [(each.low, each.high) for each in asked.excitations] == [(0.8, 1.2), (1.1, 1.1)]
    assert asked.largest_m == pytest.approx(1.0 / (2 * math.pi * 2.5) ** 2)
    assert asked.largest_m > 0.001


SHAKEN = without(PROTOTYPE, "limits", "measure") | {
    "excitation": {"records": ["el-centro", "loma-prieta-090"], "scales": [1, 0.5], "tail_s": 5},
}


def test_records_with_scales_are_read_with_the_digest_of_their_samples() -> None:
    asked = parse_specification(SHAKEN)
    assert asked.excitations == ()
    assert [each.name for each in asked.records[0].cases] == [
        "el-centro-180 × 0.5",
        "el-centro-180 × 1",
        "loma-prieta-090 × 0.5",
        "loma-prieta-090 × 1",
    ]
    assert asked.records[0].tail_s == 5.0
    assert asked.measure.name == "worst_relative_displacement"
    held = asked.document["excitation"]["records"]
    assert held[0]["sha256"] == builtin_record("el-centro-180").sha256
    # what is kept reads back as the same, and as other records where samples are others
    assert parse_specification(asked.document).digest == asked.digest
    other = json.loads(json.dumps(asked.document))
    other["excitation"]["records"][0]["sha256"] = "0" * 64
    assert parse_specification(other).digest != asked.digest
    with pytest.raises(StudyFaults, match=r"samples of record el-centro-180 have changed"):
        parse_specification(other, Shelf.none())


def test_records_are_one_of_a_list_of_excitations() -> None:
    document = PROTOTYPE | {"excitation": [ONE, {"records": ["el-centro"], "scales": 0.5, "name": "quake"}]}
    asked = parse_specification(document)
    assert (len(asked.excitations), asked.records[0].name) == (1, "quake")
    assert [each.name for each in asked.cases] == ["el-centro-180 × 0.5"]
    assert asked.measure.name == "worst_displacement"
    held = asked.document["excitation"][1]
    assert (held["name"], held["records"][0]["id"]) == ("quake", "el-centro-180")
    assert parse_specification(asked.document).digest == asked.digest
    # a ratio is over the largest base amplitude, which the band has
    ratios = {"clearance_ratio": {"start": 2, "stop": 8}, "friction_force_n": {"start": 0, "stop": 2}}
    assert (
        parse_specification(document | {"choose": ratios}).choices["clearance_m"].stop == 8 * asked.largest_m
    )
    # in a list of its own it is what it is alone, but for its name
    alone = parse_specification(SHAKEN | {"excitation": [SHAKEN["excitation"]]})
    assert (alone.excitations, alone.cases) == ((), parse_specification(SHAKEN).cases)


def test_a_sweep_reads_as_records_that_are_it_alone() -> None:
    asked = parse_specification(SHAKEN | {"excitation": {"sweep": SWEEP, "scales": [1, 0.5], "tail_s": 2}})
    listed = {"records": [{"sweep": SWEEP}], "scales": [0.5, 1], "tail_s": 2}
    assert asked.records == parse_specification(SHAKEN | {"excitation": listed}).records
    assert asked.excitations == ()
    (records,) = asked.records
    assert [each.name for each in records.cases] == [
        "sweep from 2 to 3 Hz at 0.1 Hz/s × 0.5",
        "sweep from 2 to 3 Hz at 0.1 Hz/s × 1",
    ]
    assert records.alone.words_at(1.0).endswith("of 1 mm")
    # what is kept reads back as the same
    assert asked.document["excitation"] == {"sweep": SWEEP, "scales": [0.5, 1.0], "tail_s": 2.0}
    kept = json.loads(json.dumps(asked.document))
    assert parse_specification(kept).digest == parse_specification(kept, Shelf.none()).digest == asked.digest
    assert parse_specification(kept).records == asked.records
    assert under_records(records).endswith("1 mm, at 2 scales")


def test_vibration_and_shocks_read_as_records_and_each_seed_is_one() -> None:
    shock = {"shape": "half_sine", "peak_g": 3, "duration_ms": 20}
    random = {"frequency_hz": [1, 20], "psd_m2_per_s3": [0.2, 0.2], "duration_s": 20, "seeds": 3}
    document = SHAKEN | {
        "excitation": [{"random_vibration": random}, {"name": "drop", "shock": shock, "tail_s": 1}]
    }
    asked = parse_specification(document)
    assert [under_records(each) for each in asked.records] == [
        "under 3 random vibration records",
        "under a half-sine shock of 3 g and 20 ms",
    ]
    assert transients(asked) == "random vibration records and shocks"
    assert [case.name for case in asked.cases if "seed 2" in case.name] == [
        "random vibration from 1 to 20 Hz, seed 2 × 1"
    ]
    kept = json.loads(json.dumps(asked.document))
    assert parse_specification(kept, Shelf.none()).digest == asked.digest
    (one,) = parse_specification(SHAKEN | {"excitation": {"random_vibration": random | {"seeds": 1}}}).records
    assert (
        under_records(one)
        == "under random vibration from 1 to 20 Hz with an rms of 1.949 m/s² (0.199 g), seed 0"
    )
    both = {"random_vibration": random | {"duration_s": 0}, "shock": shock}
    assert set(faults_of(SHAKEN | {"excitation": both})) == {"excitation.shock"}
    long = random | {"seeds": 51, "duration_s": 30}
    assert (
        "51 cases"
        in faults_of(SHAKEN | {"excitation": {"random_vibration": long}})["excitation.random_vibration"]
    )


QUAKE = {"records": ["el-centro"]}
SCALES = [scale + 1 for scale in range(26)]


@pytest.mark.parametrize(
    ("excitation", "field"),
    [
        ([], "excitation"),
        ([ONE] * 9, "excitation"),
        ([ONE, ONE], "excitation[1].name"),
        ([ONE, {"frequency_ratio": 1.0}], "excitation[1]"),
        ([ONE, 3], "excitation[1]"),
        ([ONE, ONE | {"name": ""}], "excitation[1].name"),
        ([ONE, {"base_amplitude_m": -1, "frequency_hz": 2.5}], "excitation[1].base_amplitude_m"),
        ([ONE, {"base_amplitude_m": 0.001}], "excitation[1].frequency_hz"),
        ({"records": ["el-centro", "nowhere"]}, "excitation.records[1]"),
        ({"records": ["el-centro", "el-centro-180"]}, "excitation.records[1]"),
        (QUAKE | {"scales": [1, 0]}, "excitation.scales[1]"),
        (QUAKE | {"scales": [1, 1]}, "excitation.scales[1]"),
        ({"records": ["el-centro", "loma-prieta"], "scales": SCALES}, "excitation.records"),
        (QUAKE | {"tail_s": -1}, "excitation.tail_s"),
        (QUAKE | {"frequency_hz": 2.5}, "excitation.frequency_hz"),
        ([QUAKE, {"records": "el-centro-180"}], "excitation[1].records[0]"),
        ([{"frequency_hz": 2}, QUAKE], "excitation[0]"),
        ({"sweep": SWEEP | {"stop_hz": 2}}, "excitation.sweep.stop_hz"),
        (QUAKE | {"sweep": SWEEP}, "excitation.sweep"),
        ([{"sweep": SWEEP}, {"sweep": SWEEP}], "excitation[1].sweep"),
        ({"sweep": SWEEP | {"rate_hz_per_s": 0.001}}, "excitation.sweep"),
        ([{"sweep": SWEEP, "scales": SCALES}, {"sweep": DOWN, "scales": SCALES}], "excitation[0].sweep"),
    ],
)
def test_faults_of_an_excitation_are_named_where_they_stand(excitation: Any, field: str) -> None:
    structure = {"mass_kg": 40, "natural_frequency_hz": 25, "damping_ratio": 0.02}
    found = faults_of(PROTOTYPE | {"excitation": excitation, "structure": structure})
    assert [told for told in found if told.startswith("excitation")] == [field]


RUBBER = {"name": "rubber", "restitution": 0.3, "contact_time_s": 0.004}


NOISE = {"limits": {"impact_noise_m_per_s2": 3.0}}


def test_limits_hold_over_bands_and_under_records() -> None:
    limits = {"stick_fraction": 0.5, "acceleration_m_per_s2": 3.0, "rms_acceleration_m_per_s2": 2.0}
    for document in (PROTOTYPE, SHAKEN):
        assert parse_specification(document | {"limits": limits}).limits == limits
        for wrong in (0, 1.5):
            assert "limits.stick_fraction" in faults_of(document | {"limits": {"stick_fraction": wrong}})
    # over bands alone
    assert parse_specification(PROTOTYPE | NOISE).limits == NOISE["limits"]
    assert parse_specification(SHAKEN | {"judge": "rest"}).judge == "rest"


UNSCALED = {"structure": {"damping_ratio": 0.01}}
BAND = {"frequency_ratio": {"start": 0.9, "stop": 1.1}}
LONG = [0.003, {"clearance_m": 0.004, "contact_time_s": 0.1}]


@pytest.mark.parametrize(
    ("document", "fields"),
    [
        # what a force, a velocity and units need of the structure
        (
            UNSCALED | {"excitation": {"force_n": 1.0} | BAND},
            "structure.mass_kg structure.natural_frequency_hz",
        ),
        (UNSCALED | {"excitation": {"base_velocity_m_per_s": 0.01} | BAND}, "structure.natural_frequency_hz"),
        (
            UNSCALED | {"excitation": BAND},
            "choose.clearance_m choose.friction_force_n particle_mass_kg limits",
        ),
        # what does not go with records
        (SHAKEN | {"measure": "rms_acceleration"}, "measure"),
        (SHAKEN | {"structure": UNSCALED["structure"] | {"natural_frequency_hz": 2.5}}, "structure.mass_kg"),
        (SHAKEN | {"friction_ratio": 0.5}, "friction_ratio"),
        (SHAKEN | {"tolerances": {"clearance_ratio": 0.1}}, "tolerances.clearance_ratio"),
        (SHAKEN | {"excitation": [ONE, QUAKE], "measure": "worst_rms_relative_displacement"}, "measure"),
        (SHAKEN | NOISE, "limits.impact_noise_m_per_s2"),
        (SHAKEN | {"judge": "worst"}, "judge"),
        (SHAKEN | {"judge": "likely"}, "judge"),
        ({"limits": {"displacement_ratio": 5.0}}, "limits.displacement_ratio"),
        # contact times: milliseconds taken for seconds, twice, and beside ratios
        ({"contact_time_s": 5.0}, "contact_time_s"),
        ({"contact_time_s": -0.001}, "contact_time_s"),
        (changed("choose.clearance_m", LONG), "choose.clearance_m[1].contact_time_s"),
        (changed("choose.restitution", [0.8, RUBBER]) | {"contact_time_s": 0.004}, "contact_time_s"),
    ],
)
def test_what_does_not_go_together_is_named(document: dict[str, Any], fields: str) -> None:
    found = faults_of(PROTOTYPE | document)
    assert set(fields.split()) <= found.keys()


def test_a_contact_time_is_in_seconds_where_everything_else_is_in_ratios() -> None:
    parse_specification(RATIOS)
    assert "contact_time_s" in faults_of(RATIOS | {"contact_time_s": 0.004})


def test_materials_are_sorted_by_their_restitution_and_have_contact_times() -> None:
    choice = choice_of({"name": "steel", "restitution": 0.8}, RUBBER)
    assert choice == Choice(0.3, 0.8, (0.3, 0.8), ("rubber", "steel"), (0.004, 0.0))
    assert [choice.contact_time_s(share) for share in (0.0, 1.0)] == [0.004, 0.0]
    # one for all of a range
    document = PROTOTYPE | {"contact_time_s": 0.002}
    assert parse_specification(document).choices["restitution"].contact_time_s(0.0) == 0.002
    assert parse_specification(PROTOTYPE).choices["restitution"].contact_time_s(0.0) == 0.0


def test_materials_may_differ_by_their_contact_time_alone() -> None:
    hard = {"name": "hard rubber", "restitution": 0.3, "contact_time_s": 0.002}
    choice = choice_of(RUBBER, hard)
    assert (choice.values, choice.free) == ((0.3, 0.3), True)
    assert [choice.contact_time_s(share) for share in (0.0, 1.0)] == [0.002, 0.004]
    assert [choice.called(0.3, each) for each in (0.002, 0.004, 0.0)] == ["hard rubber", "rubber", ""]
    again = changed("choose.restitution", [RUBBER, {**RUBBER, "name": "another"}])
    assert "choose.restitution[1].restitution" in faults_of(again)


@pytest.mark.parametrize("choose", [{}, None])
def test_a_damper_may_be_given_whole(choose: dict[str, Any] | None) -> None:
    document = without(PROTOTYPE, "choose") | {"clearance_m": 0.006, "friction_force_n": 0.2}
    assert parse_specification(document if choose is None else document | {"choose": choose}).free == ()
