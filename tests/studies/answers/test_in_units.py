"""A study in SI units: asked in units it answers as in ratios, and says in units what it says in ratios."""

import json
import re
from collections.abc import Callable

import numpy as np
import pytest
import xarray as xr

from damperlab.service.cli.words import rows_table
from damperlab.studies.answers.frequency_response import frequency_response
from damperlab.studies.answers.optimal_designs import optimal_designs
from damperlab.studies.answers.pareto import pareto_front
from damperlab.studies.answers.phrases import RATIOS, Phrases, first_said
from damperlab.studies.answers.quantities import with_quantities
from damperlab.studies.answers.query_fault import QueryFault
from damperlab.studies.answers.resonance_map import resonance_map
from damperlab.studies.answers.selection import NO_LEAD, say
from damperlab.studies.answers.tmd_comparison import tmd_comparison
from damperlab.studies.faults import nearest
from damperlab.studies.questions import Judging, Selection, Tuning
from damperlab.studies.rounding import is_rounding
from damperlab.studies.unit_names import COORDINATE_SOURCES
from damperlab.studies.variables import DIMENSIONS, ResponseClass

MASS, HERTZ, BASE = 2.0, 4.0, 0.003
FORCE = MASS * (2 * np.pi * HERTZ) ** 2 * BASE
FACTORS = {"clearance_m": BASE, "friction_force_n": FORCE, "particle_mass_kg": MASS, "frequency_hz": HERTZ}
RATIO = re.compile(r"d/Z|γ_F|β|\br = |X/Z|(?<!damping)_ratio = |μ|γ =|amplitude ratio|_ratio_at")
"""What a sentence in units has none of."""


@pytest.fixture
def cube() -> xr.Dataset:
    axes = {
        "damping_ratio": [0.0038],
        "restitution": [0.5],
        "mass_ratio": [0.05, 0.1],
        "clearance_ratio": [2.0, 5.0, 10.0],
        "friction_ratio": [0.1, 0.2, 0.4],
        "frequency_ratio": [0.8, 0.9, 1.0, 1.1],
    }
    shape = [len(axis) for axis in axes.values()]
    rng = np.random.default_rng(7)
    values = {
        "amplitude_ratio": rng.uniform(1, 9, shape),
        "amplitude_error": rng.uniform(0.01, 0.1, shape),
        "impact_speed_max": rng.uniform(0, 4, shape),
        "dissipation_per_cycle": rng.uniform(0, 4, shape),
        "response_class": np.full(shape, ResponseClass.CHAOTIC, np.int8),
        "status": np.zeros(shape, np.int8),
    }
    study = {"physical": {"mass_kg": MASS, "natural_frequency_hz": HERTZ, "base_amplitude_m": BASE}}
    return xr.Dataset(
        {name: (DIMENSIONS, array) for name, array in values.items()}, axes, {"study": json.dumps(study)}
    )


def test_points_ranges_and_results_in_units_are_those_in_ratios(cube: xr.Dataset) -> None:
    ratios = {"clearance_ratio": 5.0, "friction_ratio": 0.2, "mass_ratio": 0.1}
    units = {"clearance_m": 5 * BASE, "friction_force_n": 0.2 * FORCE, "particle_mass_kg": 0.1 * MASS}
    curve = frequency_response(cube, Selection(at=ratios))
    same = frequency_response(cube, Selection(at=units))
    xr.testing.assert_identical(curve, same)
    length = frequency_response(cube, Selection("amplitude_m", units))
    np.testing.assert_allclose(length["amplitude_m"], curve["amplitude_ratio"] * BASE, rtol=1e-15)
    np.testing.assert_allclose(length["amplitude_error_m"], curve["amplitude_error"] * BASE, rtol=1e-15)
    assert length["amplitude_m"].attrs["units"] == "m"
    energy = frequency_response(cube, Selection("dissipation_per_cycle_j", units))
    lost = frequency_response(cube, Selection("dissipation_per_cycle", ratios))["dissipation_per_cycle"]
    np.testing.assert_allclose(energy["dissipation_per_cycle_j"], lost * (FORCE * BASE), rtol=1e-15)
    assert energy["dissipation_per_cycle_j"].attrs["units"] == "J"
    moving = cube.assign(acceleration_ratio=cube["amplitude_ratio"] ** 2)
    felt = frequency_response(moving, Selection("acceleration_m_per_s2", units))["acceleration_m_per_s2"]
    square = (2 * np.pi * HERTZ) ** 2 * BASE
    np.testing.assert_allclose(felt, curve["amplitude_ratio"] ** 2 * square, rtol=1e-14)
    assert felt.attrs["units"] == "m s-2"

    xr.testing.assert_identical(tmd_comparison(cube, at=ratios), tmd_comparison(cube, at=units))

    speed = 2 * np.pi * HERTZ * BASE
    in_ratios = Judging(band=(0.85, 1.05), ranges={"clearance_ratio": (1, 6), "impact_speed_max": (0, 3.9)})
    in_units = Judging(
        ranges={
            "frequency_hz": (0.85 * HERTZ, 1.05 * HERTZ),
            "clearance_m": (1 * BASE, 6 * BASE),
            "impact_speed_max_m_per_s": (0, 3.9 * speed),
        }
    )
    xr.testing.assert_identical(optimal_designs(cube, in_ratios), optimal_designs(cube, in_units))

    plane = resonance_map(cube, "clearance_ratio", "mass_ratio", Selection(at={"friction_ratio": 0.2}))
    friction = {"friction_force_n": 0.2 * FORCE}
    lengths = resonance_map(cube, "clearance_m", "particle_mass_kg", Selection("amplitude_m", friction))
    assert lengths["amplitude_m"].dims == ("particle_mass_kg", "clearance_m")
    np.testing.assert_allclose(
        lengths["amplitude_m"].values, plane["amplitude_ratio"].values * BASE, rtol=1e-15
    )
    for name in ("clearance_m", "particle_mass_kg"):
        source = name.replace("clearance_m", "clearance_ratio").replace("particle_mass_kg", "mass_ratio")
        np.testing.assert_allclose(lengths[name], cube[source] * FACTORS[name], rtol=1e-15)


TWICE = {"clearance_ratio": 5.0, "clearance_m": 5 * BASE}
ON_THE_MAP = Selection(at={"clearance_m": 5 * BASE})


@pytest.mark.parametrize(
    ("field", "told", "ask"),
    [
        ("clearance_m", "0.0075", lambda c: frequency_response(c, Selection(at={"clearance_m": 7.5}))),
        ("clearance_m", "axis", lambda c: resonance_map(c, "clearance_ratio", "friction_ratio", ON_THE_MAP)),
        ("frequency_hz", "along", lambda c: frequency_response(c, Selection(at={"frequency_hz": HERTZ}))),
        ("band", "frequency_hz=3.2,4", lambda c: optimal_designs(c, Judging(band=(3.2, 4.0)))),
        # of 3 values the nearest is named in metres
        (
            "clearance_m",
            "nearest value is 0.03",
            lambda c: optimal_designs(c, Judging(ranges={"clearance_m": (1.0, 12.0)})),
        ),
        # one dimension that is given twice
        ("clearance", "", lambda c: frequency_response(c, Selection(at=TWICE))),
        ("clearance", "", lambda c: tmd_comparison(c, at=TWICE)),
        (
            "",
            "band",
            lambda c: optimal_designs(c, Judging(band=(0.8, 1.0), ranges={"frequency_hz": (3.2, 4.0)})),
        ),
    ],
)
def test_what_is_refused_is_named_as_it_was_asked(
    cube: xr.Dataset, field: str, told: str, ask: Callable[[xr.Dataset], object]
) -> None:
    with pytest.raises(QueryFault) as caught:
        ask(cube)
    assert field in caught.value.fault.field
    assert told in str(caught.value)


def test_the_name_of_a_frequency_in_a_study_means_the_one_in_a_question_and_back() -> None:
    assert nearest("excitation_frequency_hz", ("natural_frequency_hz", "frequency_hz")) == "frequency_hz"
    assert (
        nearest("frequency_hz", ("natural_frequency_hz", "excitation_frequency_hz"))
        == "excitation_frequency_hz"
    )


def test_words_in_units_hold_no_ratio_and_the_numbers_of_the_cube(cube: xr.Dataset) -> None:
    alone = cube.isel(frequency_ratio=[2])
    answers = [
        optimal_designs(cube),
        optimal_designs(alone),
        optimal_designs(cube, Judging("resonance")),
        resonance_map(cube, "clearance_ratio", "friction_ratio"),
        resonance_map(cube, "clearance_ratio", "friction_ratio", Selection(at={"frequency_ratio": 0.93})),
        frequency_response(cube, Selection(at={"clearance_ratio": 3.0})),
        tmd_comparison(cube, Tuning(mass_ratio=0.07)),
        tmd_comparison(alone),
        pareto_front(cube, ("amplitude", "-mass", "clearance")),
        pareto_front(cube.isel(frequency_ratio=[1]), ("amplitude", "impact_speed")),
    ]
    for answer in answers:
        words = answer.attrs["in_units"]
        assert words.keys() == answer.attrs.keys() & {"verdict", "doubts", "note", "brief"}
        doubts = [doubt["sentence"] for doubt in words.get("doubts", ())]
        rows = [" ".join(row) for row in words.get("brief", {}).get("rows", ())]
        for sentence in (*words.get("verdict", ()), *doubts, *rows, words["note"]):
            assert RATIO.search(sentence) is None, sentence
    best = answers[0].isel(rank=0)
    said = " ".join(answers[0].attrs["in_units"]["verdict"])
    for name, factor, symbol, unit in (
        ("clearance_ratio", BASE * 1e3, "d", "mm"),
        ("friction_ratio", FORCE, "F_f", "N"),
    ):
        assert f"{symbol} = {float(best[name]) * factor:.3g} {unit}" in said
    assert f"{float(best['value']) * BASE * 1e3:.3g}" in said
    following = answers[1].attrs["in_units"]["brief"]["next"]
    assert "`excitation_frequency_hz: {start: 3.2, stop: 5, num: 19}`" in following
    ratios = cube.copy()
    ratios.attrs = {}
    for answer in (optimal_designs(ratios), tmd_comparison(ratios)):
        assert "in_units" not in answer.attrs


def test_an_amplitude_or_its_error_below_a_micrometre_is_in_nanometres(cube: xr.Dataset) -> None:
    phrases = Phrases.of(cube)
    for amplitude_m, error_m, written in (
        (8e-9, 1e-9, "8 ± 1 nm"),
        (1.5e-3, 1e-5, "1.5 ± 0.01 mm"),
        (1.5e-3, 8e-7, "1.5 ± 0.0008 mm"),
        (1.5e-3, 8e-9, "1.5 mm ± 8 nm"),
    ):
        assert phrases.measured(amplitude_m / BASE, error_m / BASE, ".6g") == written
    assert phrases.value("amplitude_ratio", 8e-9 / BASE, ".3g") == "8 nm"
    assert RATIOS.measured(1.5, 0.01) == "1.5 ± 0.01"
    assert phrases.span("amplitude_ratio", 8e-9 / BASE, 1.5e-3 / BASE, ".3g") == "X = 8 nm to 1.5 mm"
    assert phrases.span("amplitude_ratio", 8e-9 / BASE, 9e-9 / BASE, ".3g") == "X = 8 nm to 9 nm"


def test_a_result_in_another_unit_is_refused_with_its_name_in_si_units(cube: xr.Dataset) -> None:
    with pytest.raises(QueryFault, match=r"amplitude_m.*Did you mean amplitude_m\?"):
        resonance_map(cube, "clearance_ratio", "friction_ratio", Selection("amplitude_mm"))


def test_limits_on_results_are_told_as_ratios_and_in_units(cube: xr.Dataset) -> None:
    asked = Judging(
        max_impact_speed=3.5, ranges={"amplitude_ratio": (0.0, 8.0), "impact_speed_max": (0.0, 3.9)}
    )
    answer = optimal_designs(cube, asked)
    speed, length = 2 * np.pi * HERTZ * BASE, BASE * 1e3
    for told in ("at most 3.5 Z·ω_n", "from 0 to 8", "from 0 to 3.9 Z·ω_n"):
        assert told in answer.attrs["note"]
    told = answer.attrs["in_units"]["note"]
    for number in (f"{3.5 * speed:.6g} m/s", f"{8 * length:.6g} mm", f"{3.9 * speed:.6g} m/s"):
        assert number in told
    # what was asked in m/s is the same question, and is told so
    in_units = Judging(
        max_impact_speed=3.5,
        ranges={"amplitude_m": (0.0, 8 * BASE), "impact_speed_max_m_per_s": (0.0, 3.9 * speed)},
    )
    assert optimal_designs(cube, in_units).attrs["in_units"]["note"] == told
    front = pareto_front(cube, ("amplitude", "-mass"), Judging(max_impact_speed=3.9))
    assert f"{3.9 * speed:.6g} m/s" in front.attrs["in_units"]["note"]


def test_an_answer_holds_its_ratios_in_units_too(cube: xr.Dataset) -> None:
    definition = json.loads(cube.attrs["study"])
    speed, place = BASE * 2 * np.pi * HERTZ, {"clearance_ratio": 5.0}
    for answer, pairs in (
        (
            frequency_response(cube, Selection("impact_speed_max", place)),
            {"impact_speed_max_m_per_s": speed, "amplitude_error_m": BASE} | FACTORS,
        ),
        (
            resonance_map(cube, "clearance_ratio", "friction_ratio"),
            {"amplitude_m": BASE, "clearance_m": BASE},
        ),
        (optimal_designs(cube), {"value_m": BASE, "error_m": BASE, "friction_force_n": FORCE}),
        (tmd_comparison(cube), {"hybrid_m": BASE, "tmd_m": BASE, "no_damper_m": BASE, "frequency_hz": HERTZ}),
    ):
        found = with_quantities(answer, definition)
        sources = {**COORDINATE_SOURCES, "impact_speed_max_m_per_s": "impact_speed_max"}
        for name, factor in pairs.items():
            ratio = answer[
                sources.get(name) or next(s for s in (name[:-2], f"{name[:-2]}_ratio") if s in answer)
            ]
            assert found[name].dims == ratio.dims
            np.testing.assert_allclose(found[name], factor * ratio, rtol=1e-12)
            assert found[name].attrs["units"] != "1"
        assert next(iter(found.data_vars)) == next(iter(answer.data_vars))
        assert with_quantities(found, definition).identical(found)
        assert with_quantities(answer, {"axes": {}}) is answer


@pytest.mark.parametrize("tilt", [30.0, 90.0, 0.0])
def test_the_tilt_of_a_study_is_named_in_degrees(cube: xr.Dataset, tilt: float) -> None:
    study = json.loads(cube.attrs["study"])
    study["physical"]["tilt_deg"] = tilt
    gravity = 9.80665 / ((2 * np.pi * HERTZ) ** 2 * BASE) * np.sin(np.radians(tilt))
    tilted = cube.expand_dims(gravity_ratio=[gravity]).assign_attrs(study=json.dumps(study))
    curve = frequency_response(tilted, Selection("amplitude_m", {"tilt_deg": tilt}))
    assert curve["tilt_deg"].item() == pytest.approx(tilt)
    place = dict.fromkeys(tilted.sizes, 0)
    assert f"tilt of the cavity α = {tilt:g}°," in say(tilted, place, {}, Phrases.of(tilted), NO_LEAD)
    study["physical"]["tilt_deg"] = [0.0, tilt]
    several = tilted.assign_attrs(study=json.dumps(study))
    assert "tilt_deg" not in frequency_response(several, Selection("amplitude_m")).coords


def test_a_doubt_about_the_units_of_a_study_is_said_first_everywhere() -> None:
    words = {"verdict": ["Best."], "brief": {"sentences": ["Best."], "rows": []}}
    said = first_said({**words, "complete": 1.0, "in_units": words}, ["Check the units."])
    for each in (said, said["in_units"]):
        assert each["verdict"] == each["brief"]["sentences"] == ["Check the units.", "Best."]
        assert each["brief"]["rows"] == []
    assert said["complete"] == 1.0
    assert first_said({"note": ""}, ["Check the units."]) == {"note": ""}


@pytest.mark.parametrize(
    ("value", "error", "words"),
    [
        (2.78743, 6.8e-15, "2.78743"),
        (2.78743, 0.0, "2.78743"),
        (0.0, 0.0, "0"),
        (-2.0, 1e-12, "-2"),
        (2.0, 1e-6, "2 ± 1e-06"),
        (1.84424, 0.033, "1.84424 ± 0.033"),
        (2.0, float("nan"), "2 (error not known)"),
    ],
)
def test_a_value_known_to_rounding_has_no_error_beside_it(value: float, error: float, words: str) -> None:
    assert RATIOS.measured(value, error) == words
    # an error of nothing is not rounding
    assert not is_rounding(0.0 * value, 1e-20)


@pytest.mark.parametrize(
    ("value", "error"),
    [("value", "error"), ("amplitude_ratio", "amplitude_error"), ("hybrid", "amplitude_error")],
)
def test_a_table_says_rounding_and_keeps_the_other_errors(value: str, error: str) -> None:
    answer = xr.Dataset(
        {value: ("rank", [1.5, 1.6, np.nan]), error: ("rank", [2e-16, 0.03, np.nan])}, {"rank": [1, 2, 3]}
    )
    head, rows = rows_table(answer, RATIOS)
    place = [column.split()[0] for column in head].index(error)
    assert [row[place] for row in rows] == ["rounding", "0.03", "—"]
