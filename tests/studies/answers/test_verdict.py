"""What a ranking means: ties, chances, folded responses, ends of axes and single frequencies, on cubes made by hand."""

import json

import numpy as np
import pytest
import xarray as xr
from scipy import integrate, special

from damperlab.studies.answers.comparing import chance_of_another, contend, limits
from damperlab.studies.answers.leading import leading
from damperlab.studies.answers.optimal_designs import merged_designs, optimal_designs
from damperlab.studies.brief import DOUBTS, lines_of
from damperlab.studies.questions import Judging
from damperlab.studies.variables import DIMENSIONS, ResponseClass, Status


def made(values, errors=0.0, kinds=ResponseClass.CHAOTIC, frequencies=(0.9, 1.0, 1.1)) -> xr.Dataset:
    """A study of friction ratios 0, 0.1, ...: values of shape (friction, frequency) or (friction,)."""
    values = np.asarray(values, float)
    values = np.broadcast_to(values.reshape(values.shape[0], -1), (values.shape[0], len(frequencies)))
    shape = (1, 1, 1, 1, *values.shape)

    def full(given, dtype=float):
        given = np.asarray(given, dtype)
        return np.broadcast_to(
            given.reshape(given.shape[0], -1) if given.ndim else given, values.shape
        ).reshape(shape)

    columns = {
        "amplitude_ratio": values.reshape(shape),
        "amplitude_error": full(errors),
        "response_class": full(kinds, np.int8),
        "status": np.zeros(shape, np.int8),
    }
    coordinates = dict.fromkeys(DIMENSIONS[:4], np.array([0.5]))
    coordinates |= {
        "friction_ratio": np.arange(values.shape[0]) * 0.1,
        "frequency_ratio": np.array(frequencies),
    }
    return xr.Dataset({name: (DIMENSIONS, array.copy()) for name, array in columns.items()}, coordinates)


def kinds(answer: xr.Dataset) -> set[str]:
    """What the notes are about; the doubts are some of them, and every answer is short."""
    brief, notes = answer.attrs["brief"], {note["kind"]: note["values"] for note in answer.attrs["notes"]}
    lines = lines_of(brief)
    assert len(lines) <= 12
    assert len(brief["sentences"][0].split()) <= 60
    assert answer.attrs["verdict"] == brief["sentences"]
    assert {doubt["kind"] for doubt in answer.attrs["doubts"]} == notes.keys() & set(DOUBTS)
    return set(notes)


def test_a_design_equal_to_the_best_up_to_rounding_is_not_another() -> None:
    value = np.array([1.0, 1.0 + 1e-14, 1.0 - 1e-14, 1.5])
    error = np.array([1e-15, 2e-15, 1e-15, 0.01])
    # only the last is another, fifty of its errors away
    assert chance_of_another(value, error, 0) == pytest.approx(special.stdtr(4, -50.0), rel=1e-6)


def test_the_chance_of_another_is_that_of_drawn_values():
    value, error = np.array([1.0, 1.02, 1.05, 1.0, 2.0]), np.array([0.02, 0.03, 0.01, 0.05, 0.1])
    draws = value + error * np.random.default_rng(1).standard_t(4, (200_000, 5))
    expected = (draws.argmin(axis=1) != 0).mean()
    # four standard deviations of a share of 200,000 draws
    assert chance_of_another(value, error, 0) == pytest.approx(expected, abs=4 * 0.5 / 200_000**0.5)
    two = chance_of_another(np.array([1.0, 1.1]), np.array([0.03, 0.04]), 0)
    # the density of Student's t with 4 degrees is 3/8·(1 + t²/4)^(−5/2)
    expected, _ = integrate.quad(
        lambda t: 0.375 * (1 + t**2 / 4) ** -2.5 * special.stdtr(4, (0.03 * t - 0.1) / 0.04), -np.inf, np.inf
    )
    assert two == pytest.approx(expected, abs=1e-4)
    assert chance_of_another(np.array([1.0, 1.0]), np.zeros(2), 0) == 0
    assert chance_of_another(np.array([1.0, 0.9]), np.zeros(2), 0) == 1
    assert np.isnan(chance_of_another(np.array([1.0, 2.0]), np.array([np.nan, 0.1]), 0))


def test_the_limits_of_an_amplitude_hold_as_often_as_stated():
    amplitude, error = np.array([3.0, 2.0, 0.1, 1.0]), np.array([0.1, 0.0, 0.2, np.nan])
    low, high = limits(amplitude, error)
    # 95 % of Student's t with 4 degrees, by each amplitude itself; no amplitude is below 0
    width = special.stdtrit(4, 0.975)
    np.testing.assert_allclose(low, [3.0 - 0.1 * width, 2.0, 0.0, 0.0], rtol=1e-7)
    np.testing.assert_allclose(high, [3.0 + 0.1 * width, 2.0, 0.1 + 0.2 * width, np.inf], rtol=1e-7)
    # whose error is not known may be the best, and rules nobody out
    assert contend(low, high).tolist() == [False, False, True, True]


def test_designs_within_the_errors_are_counted_and_the_clearly_worse_are_not():
    answer = optimal_designs(made([1.0, 1.03, 1.5, 1.04], errors=[0.02, 0.02, 0.02, 0.02]))
    assert answer.attrs["as_good"] == 2
    assert 0 < answer.attrs["chance_of_another"] < 0.5
    assert (answer["lowest"] < answer["value"]).all()
    exact = optimal_designs(made([1.0, 1.03, 1.5, 1.04], errors=1e-9))
    assert (exact.attrs["as_good"], exact.attrs["chance_of_another"]) == (0, 0.0)


def test_one_unknown_error_is_said_and_rules_nobody_out():
    answer = optimal_designs(made([1.0, 1.5, 9.0], errors=[1e-3, 1e-3, np.nan]))
    assert answer.attrs["as_good"] == 1
    assert "chance_of_another" not in answer.attrs
    unknown = optimal_designs(made([1.0, 1.5]).drop_vars("amplitude_error"))
    assert "chance_of_another" not in unknown.attrs
    assert "error not known" in unknown.attrs["verdict"][0]


def test_designs_without_impacts_are_folded_named_and_set_beside_the_best_with_impacts():
    locked, still, chaos = ResponseClass.LOCKED, ResponseClass.NO_IMPACT, ResponseClass.CHAOTIC
    cube = made([1.0, 1.0, 1.0, 1.2, 1.4], errors=1e-9, kinds=[locked, locked, locked, still, chaos])
    answer = optimal_designs(cube)
    assert answer.sizes["rank"] == 3
    assert answer["alike"].values.tolist() == [2, 0, 0]
    assert answer["impact_share"].values.tolist() == [0, 0, 1]
    assert answer.attrs["best_with_impacts"]["value"] == 1.4
    assert "clamped" in kinds(answer)
    assert ["clamped to its base", "1"] in [row[:2] for row in answer.attrs["brief"]["rows"]]
    # two chaotic responses of one value are two responses
    assert optimal_designs(made([1.0, 1.0, 2.0])).sizes["rank"] == 3
    none = optimal_designs(made([1.0, 2.0], kinds=locked))
    assert none.attrs["brief"]["damper"] == "no_damper"  # its friction ratio is 0
    assert "clamped" in kinds(none)
    assert "best_with_impacts" not in none.attrs


def test_friction_alone_that_does_not_clamp_the_structure_is_recommended_before_a_damper_with_impacts():
    still, chaos = ResponseClass.NO_IMPACT, ResponseClass.CHAOTIC
    cube = made([1.5, 1.05, 1.07], errors=1e-9, kinds=[chaos, still, still])
    answer = optimal_designs(cube)
    assert answer.attrs["brief"]["damper"] == "friction_alone"
    assert "1.05 at γ_F = 0.1" in answer.attrs["verdict"][0]
    assert ["third", "1.5", "γ_F = 0"] in answer.attrs["brief"]["rows"]
    assert "clamped" not in answer.attrs
    lead = leading(answer)
    assert lead["value"] == 1.05
    # of a ranking of many such, the best with impacts is named too
    cube = made([1.5, 1.05, 1.07, 1.08], errors=1e-9, kinds=[chaos, still, still, still])
    assert ["best with impacts", "1.5", "γ_F = 0"] in optimal_designs(cube).attrs["brief"]["rows"]


def test_a_peak_that_may_hide_counts_for_the_recommended_design_alone():
    r = np.linspace(0.9, 1.1, 5)
    cube = made([[1.0] * 5, [1.0, 2.0, 9.0, 2.0, 1.0]], errors=1e-9, frequencies=r)
    cube = cube.assign_coords(damping_ratio=[0.001])
    answer = optimal_designs(cube)
    (note,) = (note for note in answer.attrs["notes"] if note["kind"] == "hidden_peak")
    assert (note["values"]["best"], note["values"]["recommended"]) == (False, False)
    assert not any("a peak may be" in sentence for sentence in answer.attrs["verdict"])
    assert optimal_designs(cube, top=1).attrs["brief"] == answer.attrs["brief"]


def test_a_hidden_peak_that_may_exceed_the_next_damper_is_said_before_the_best():
    """A resonance between values of 1.9 that are 0.2 apart may reach 2.31, above the second design and the absorber."""
    r = (0.9, 1.1)
    near = optimal_designs(
        made([[1.9, 1.9], [2.0, 2.0]], errors=1e-9, frequencies=r).assign_coords(damping_ratio=[0.001])
    )
    first = near.attrs["verdict"][0]
    num = next(n for n in near.attrs["notes"] if n["kind"] == "hidden_peak")["values"]["num"]
    assert f"compute {num:,} frequencies" in first
    assert near.attrs["brief"]["damper"] is None


def test_friction_that_nearly_clamps_a_structure_whose_particle_strikes_is_said():
    kinds_of = [[ResponseClass.LOCKED, ResponseClass.CHAOTIC, ResponseClass.CHAOTIC]]
    for value, said in ((1.2, True), (1.6, False)):
        answer = optimal_designs(made([[1.0, value, 1.0]], kinds=kinds_of, frequencies=(0.9, 0.901, 0.902)))
        assert ("nearly_clamped" in kinds(answer)) is said
        assert any("nearly clamps" in sentence for sentence in answer.attrs["verdict"]) is said
        # the value holds on the grid alone, which is named with it
        assert ("within 1.2 at 3 frequencies, r = 0.9 to 0.902." in answer.attrs["verdict"][0]) is said


def test_friction_alone_that_does_almost_as_well_as_impacts_is_said():
    """The first design has impacts; the second has none, and is 4 % worse. One that clamps the structure is no such damper."""
    chaos, still, locked = ResponseClass.CHAOTIC, ResponseClass.NO_IMPACT, ResponseClass.LOCKED
    for value, kind, said in ((1.04, still, True), (1.2, still, False), (1.04, locked, False)):
        # friction_ratio is 0.1 of the best and 0.2 of the other
        answer = optimal_designs(
            made([[9.0] * 3, [1.0] * 3, [value] * 3], kinds=[[chaos] * 3, [chaos] * 3, [kind] * 3])
        )
        assert ("friction_alone" in kinds(answer)) is said
        told = f"Friction alone does almost as well: {value:g} at γ_F = 0.2."
        assert (told in answer.attrs["verdict"]) is said


def test_the_end_of_a_level_axis_is_named_if_the_design_depends_on_it():
    """Along the axis all designs are equally good; only without impacts does the particle not matter."""
    chaos = made([[1.0], [1.05]], frequencies=(1.0, 1.001, 1.002)).rename(friction_ratio="x")
    chaos = chaos.rename(clearance_ratio="friction_ratio", x="clearance_ratio").assign_coords(
        clearance_ratio=[1.0, 2.0]
    )
    answer = optimal_designs(chaos)
    assert "clearance_ratio" in answer.attrs["brief"]["next"] or "below 1" in answer.attrs["brief"]["next"]
    assert "end_of_range" in kinds(answer)
    chaos["response_class"].values[...] = ResponseClass.NO_IMPACT
    assert "end_of_range" not in kinds(optimal_designs(chaos))


def test_a_design_is_clamped_where_friction_holds_it_at_some_frequencies_and_its_particle_strikes_at_none():
    locked, still, chaos = ResponseClass.LOCKED, ResponseClass.NO_IMPACT, ResponseClass.CHAOTIC
    # the first is largest where it is locked, the second where its particle does not strike
    values = [[1.2, 1.1, 1.0], [1.3, 1.2, 1.4]]
    answer = optimal_designs(made(values, errors=1e-9, kinds=[[locked, still, still], [chaos, chaos, still]]))
    assert "clamped" in kinds(answer)
    assert answer.attrs["notes"][0]["values"]["locked_share"] == pytest.approx(1 / 3)
    assert "1.4" in answer.attrs["verdict"][0]  # not the 1.2 of the clamped one
    alone = optimal_designs(made(values[1:], errors=1e-9, kinds=[[chaos, chaos, still]]))
    assert "clamped" not in kinds(alone)
    # nor is a mass that moves far, though friction holds it at times
    far = optimal_designs(made([[1.0, 9.0, 1.0]], errors=1e-9, kinds=[[locked, still, still]]))
    assert "clamped" not in kinds(far)


def test_a_tuned_mass_damper_that_is_better_is_the_verdict():
    wide = np.linspace(0.8, 1.2, 5)
    high, low = (
        optimal_designs(made([[1.0, 1.0, value, 1.0, 1.0]], errors=1e-9, frequencies=wide))
        for value in (9.0, 1.1)
    )
    assert high.attrs["brief"]["damper"] == "tuned_mass_damper"
    assert "tuned_mass_damper" in kinds(high)
    assert "acceleration" not in {
        row[0] for row in high.attrs["brief"]["rows"]
    }  # in ratios nothing determines it
    assert low.attrs["brief"]["damper"] == "particle_alone"


def test_a_response_without_bound_is_the_first_thing_said():
    cube = made([np.nan, np.nan])
    cube["status"].values[...] = Status.UNBOUNDED
    answer = optimal_designs(cube)
    assert answer.attrs["brief"]["damper"] is None
    assert "without bound" in answer.attrs["verdict"][0]
    cube["status"].values[...] = Status.NOT_COMPUTED
    assert "damperlab run" in optimal_designs(cube).attrs["brief"]["next"]


def test_limits_that_leave_no_design_are_named_with_the_remedy():
    cube = made([1.0, 2.0, np.nan])
    cube["impact_speed_max"] = cube["amplitude_ratio"].fillna(0.0)
    cube["status"].values[..., 2, :] = Status.TOO_MANY_EVENTS
    answer = optimal_designs(cube, Judging(max_impact_speed=0.5))
    why = "1 failed at a judged frequency, 2 impact faster than allowed"
    assert answer.attrs["verdict"] == [f"None of the 3 designs qualifies: {why}."]
    assert answer.attrs["brief"]["next"] == "allow faster impacts."


def test_a_response_that_is_not_resolved_has_impacts_only_where_the_particle_strikes():
    modulated = ResponseClass.MODULATED
    cube = made([1.0, 1.2, 1.4], errors=1e-9, kinds=modulated)
    assert optimal_designs(cube).attrs["best_with_impacts"]["value"] == 1.0
    counted = cube["amplitude_ratio"].copy(data=np.zeros(cube["amplitude_ratio"].shape))
    counted[..., 2, 1] = 0.5  # of the third design, at one frequency of three
    answer = optimal_designs(cube.assign(impacts_per_cycle=counted))
    assert answer["impact_share"].values.tolist() == pytest.approx([0, 0, 1 / 3])
    assert answer.attrs["best_with_impacts"]["value"] == 1.4


def test_a_study_without_a_particle_or_of_one_without_mass_has_no_best_with_impacts():
    locked, modulated = ResponseClass.LOCKED, ResponseClass.MODULATED
    massless = made([1.0, 2.0], kinds=modulated).assign_coords(mass_ratio=[0.0])
    answer = optimal_designs(massless)
    assert "best_with_impacts" not in answer.attrs
    without = made([1.0, 2.0], kinds=[locked, modulated]).assign_coords(mass_ratio=[0.0])
    without.attrs["study"] = json.dumps({"particle": False})
    answer = optimal_designs(without)
    assert "best_with_impacts" not in answer.attrs
    assert "impacts" not in " ".join(answer.attrs["verdict"])


def test_the_best_with_impacts_is_found_however_low_it_ranks(monkeypatch):
    import damperlab.studies.answers.optimal_designs as module

    monkeypatch.setattr(module, "MOST_DESIGNS", 3)
    monkeypatch.setattr("damperlab.studies.answers.slab.BUDGET", 1)
    kinds = [ResponseClass.NO_IMPACT] * 9 + [ResponseClass.CHAOTIC]
    answer = optimal_designs(made(np.arange(1.0, 11.0), kinds=kinds), top=2)
    assert answer.sizes["rank"] == 2
    assert answer.attrs["best_with_impacts"]["value"] == 10.0


def test_the_end_of_an_axis_a_rugged_neighbourhood_and_a_large_error_are_noted():
    assert kinds(optimal_designs(made([2.0, 1.05, 1.0]))) >= {"end_of_range"}
    # friction is never less than none
    assert "end_of_range" not in kinds(optimal_designs(made([1.0, 1.05, 2.0])))
    rugged = kinds(optimal_designs(made([2.0, 1.0, 2.0])))
    assert "rugged" in rugged
    assert "end_of_range" not in rugged
    assert "rugged" not in kinds(optimal_designs(made([1.02, 1.0, 1.02])))
    (note,) = [
        n for n in optimal_designs(made([2.0, 1.0], errors=0.05)).attrs["notes"] if n["kind"] == "error"
    ]
    assert note["values"]["share"] == pytest.approx(0.05)


@pytest.mark.parametrize("gone", [Status.NOT_COMPUTED, Status.TOO_MANY_EVENTS, None])
def test_a_neighbour_without_a_value_is_not_known_to_be_worse(gone):
    """The next design up is as good, the next one down was not computed, failed, or is left out by a limit."""
    cube = made([1.05, 1.0, 1.05])
    speeds = np.zeros(cube["status"].shape)
    if gone is None:
        speeds[..., 0, 1] = 9.0
    else:
        cube["status"].values[..., 0, 1] = gone
    answer = optimal_designs(
        cube.assign(impact_speed_max=(DIMENSIONS, speeds)), Judging(max_impact_speed=1.0)
    )
    (flat,) = answer.attrs["flatness"]
    assert (flat["resolved"], flat["worse"], flat["unknown"]) == (False, False, True)
    assert "rugged" not in kinds(answer)
    assert "neighbourhood_unknown" in kinds(answer)
    # known to be worse on the other side, it is said too
    cube["amplitude_ratio"].values[..., 2, :] = 2.0
    both = optimal_designs(cube.assign(impact_speed_max=(DIMENSIONS, speeds)), Judging(max_impact_speed=1.0))
    assert both.attrs["flatness"][0]["worse"]
    assert both.attrs["flatness"][0]["unknown"]
    assert kinds(both) >= {"rugged", "neighbourhood_unknown"}


def test_an_optimum_whose_run_was_cut_off_is_doubted():
    cube = made([[2.0, 3.0, 2.0], [1.0, 2.0, 1.0]])
    assert "cut_off" not in {doubt["kind"] for doubt in optimal_designs(cube).attrs["doubts"]}
    for friction, of_the_optimum in ((0, False), (1, True)):
        cut = cube.copy(deep=True)
        cut["status"].values[0, 0, 0, 0, friction, 1] = Status.MAX_CYCLES
        answer = optimal_designs(cut)
        told = [note["values"] for note in answer.attrs["notes"] if note["kind"] == "cut_off"]
        assert told == ([{"responses": 1, "of": 3}] if of_the_optimum else [])


def test_a_design_whose_run_was_cut_off_is_never_ruled_out_by_its_stated_error():
    cube = made([[2.0, 9.0, 2.0], [1.0, 2.5, 1.0]], errors=0.01)
    assert optimal_designs(cube).attrs["as_good"] == 0
    cube["status"].values[0, 0, 0, 0, 0, 1] = Status.MAX_CYCLES
    answer = optimal_designs(cube)
    assert answer.attrs["as_good"] == 1
    assert "chance_of_another" not in answer.attrs
    assert merged_designs({"a": cube}).attrs["as_good"] == 1


def test_a_design_in_two_studies_has_the_value_of_the_longer_run():
    lucky, long = made([1.0, 1.2], errors=0.1), made([1.3, 1.2], errors=[0.01, 0.1])
    merged = merged_designs({"a": lucky, "b": long})
    assert merged["value"].values.tolist() == [1.2, 1.3]
    assert merged["study"].values.tolist() == ["a", "b"]
    assert "1.2" in merged.attrs["verdict"][0]
    long["status"].values[0, 0, 0, 0, 1] = Status.NOT_COMPUTED
    merged = merged_designs({"a": lucky, "b": long})
    assert merged.attrs["complete"] == 0.75
    assert any(note["kind"] == "incomplete" for note in merged.attrs["notes"])


@pytest.mark.parametrize(
    ("definition", "expected"),
    [
        ({}, True),
        ({"excitation": "force"}, False),
        ({"contact": {"model": "dwell"}}, False),
        ({"physical": {"mass_kg": 40}}, False),
    ],
)
def test_the_largest_acceleration_is_told_in_g_where_a_closed_form_tells_it(definition, expected) -> None:
    cube = made([[1.3, 1.2, 1.4], [1.2, 1.1, 1.0]], errors=1e-9)
    cube["relative_amplitude_ratio"] = cube["amplitude_ratio"] + 0.5
    physical = {"mass_kg": 40, "natural_frequency_hz": 5, "base_amplitude_m": 0.002}
    cube.attrs["study"] = json.dumps({"physical": physical} | definition)
    answer = optimal_designs(cube)
    assert ("acceleration" in {row[0] for row in answer.attrs["brief"]["rows"]}) is expected
    if expected:
        # the best has γ_F = 0.1, ζ = 0.5, and |v| of 1.7 at its largest, at r = 0.9
        most = 1.7 * np.hypot(1.0, 0.9) + 0.1
        assert answer.attrs["acceleration_g"] == pytest.approx(most * (10 * np.pi) ** 2 * 0.002 / 9.80665)
        of_part = optimal_designs(cube, Judging(band=(1.0, 1.1)))
        assert of_part.attrs["acceleration_g"] < answer.attrs["acceleration_g"]
        alone = optimal_designs(cube.isel(frequency_ratio=[0]))
        assert "acceleration" in {row[0] for row in alone.attrs["brief"]["rows"]}
        cube["acceleration_ratio"] = 3.0 * xr.ones_like(cube["amplitude_ratio"])
        measured = optimal_designs(cube).attrs["acceleration_g"]
        assert measured == pytest.approx(3.0 * (10 * np.pi) ** 2 * 0.002 / 9.80665)
    else:
        assert "acceleration_g" not in answer.attrs


def test_a_structure_that_friction_holds_accelerates_as_its_base_does() -> None:
    cube = made([[1.0, 1.0, 1.0]], errors=1e-9, kinds=ResponseClass.LOCKED)
    cube = cube.assign_coords(friction_ratio=[40.0])
    cube["relative_amplitude_ratio"] = 0.0 * cube["amplitude_ratio"]
    physical = {"mass_kg": 40, "natural_frequency_hz": 5, "base_amplitude_m": 0.002}
    cube.attrs["study"] = json.dumps({"physical": physical})
    found = optimal_designs(cube).attrs["acceleration_g"]
    assert found == pytest.approx(1.1**2 * (10 * np.pi) ** 2 * 0.002 / 9.80665)


def test_studies_are_merged_where_the_best_does_not_strike_and_another_does() -> None:
    still, chaos = ResponseClass.NO_IMPACT, ResponseClass.CHAOTIC
    first = made([1.0, 1.4], errors=1e-9, kinds=[[still], [chaos]])
    second = made([1.1, 1.3], errors=1e-9, kinds=[[still], [chaos]])
    for cube in (first, second):
        cube["relative_amplitude_ratio"] = cube["amplitude_ratio"]
    answer = merged_designs({"a": first, "b": second.assign_coords(friction_ratio=[0.05, 0.15])}, Judging())
    assert answer.attrs["best_with_impacts"]["value"] == 1.3
    assert answer.attrs["best_with_impacts"]["study"] == "b"
