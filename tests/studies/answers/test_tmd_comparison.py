"""The comparison with a tuned mass damper: what is known in closed form comes out of it."""

import json
import math
from collections.abc import Sequence

import numpy as np
import pytest
import xarray as xr
from tests.oracles import transmissibility, tuned_mass
from tests.studies.solving import solved

from damperlab.studies.answers.optimal_designs import optimal_designs
from damperlab.studies.answers.query_fault import QueryFault
from damperlab.studies.answers.tmd_comparison import tmd_comparison
from damperlab.studies.definition import parse_study
from damperlab.studies.questions import Tuning
from damperlab.studies.variables import ResponseClass, Status


def test_curves_peaks_and_ratio_are_those_of_the_oracle(cube, whole):
    at = {"clearance_ratio": 5.0, "restitution": 0.5, "friction_ratio": 0.2}
    answer = tmd_comparison(cube, Tuning("hinf"), at=at)
    r = whole["frequency_ratio"].values
    tuning, damping, _ = tuned_mass.exact_optimum(0.1)
    assert answer.attrs["tmd_tuning"] == pytest.approx(tuning, rel=1e-13)
    assert answer.attrs["tmd_damping_over_structure"] == pytest.approx(damping * tuning, rel=1e-12)
    np.testing.assert_allclose(
        answer["tmd"], tuned_mass.amplitude_ratio(r, 0.1, tuning, damping, 0.0038), rtol=1e-11
    )
    np.testing.assert_allclose(
        answer["no_damper"], [transmissibility.absolute_amplitude(0.0038, x) for x in r], rtol=1e-12
    )
    curve = whole["amplitude_ratio"].sel(at, method="nearest").values.ravel()
    np.testing.assert_array_equal(answer["hybrid"], curve)
    assert answer.attrs["hybrid_peak"] == np.nanmax(curve)
    # both humps of this absorber lie in the band 0.7 to 1.25
    peak = tuned_mass.peak(0.1, tuning, damping, 0.0038)
    assert answer.attrs["tmd_peak"] == pytest.approx(peak, rel=1e-11)
    assert answer.attrs["ratio"] == pytest.approx(np.nanmax(curve) / peak, rel=1e-11)
    error = whole["amplitude_error"].sel(at, method="nearest").values.ravel()
    better = curve + error < answer["tmd"].values
    inside = [any(low <= x <= high for low, high in answer.attrs["hybrid_better"]) for x in r]
    np.testing.assert_array_equal(inside, better)


def test_a_damper_that_clamps_the_structure_is_said_to_do_so_first() -> None:
    """Far above γ_F = r² the mass hardly slips: it moves with its base, at every frequency but little more than Z."""
    axes = {"frequency_ratio": [0.9, 1.0, 1.1], "friction_ratio": [3.0], "mass_ratio": [0.1]}
    cube = solved(parse_study({"damping_ratio": 0.02, "axes": axes | {"clearance_ratio": [3.0]}}))
    answer = tmd_comparison(cube)
    assert answer.attrs["ratio"] < 1.0
    assert answer.attrs["verdict"][0].startswith(
        "Friction of the study's damper clamps the structure to its base"
    )
    note = next(each for each in answer.attrs["notes"] if each["kind"] == "clamped")
    assert note["severity"] == "danger"


def test_the_peak_without_a_damper_is_that_of_the_band_and_not_of_the_grid(cube):
    between = cube.isel(frequency_ratio=np.abs(cube["frequency_ratio"].values - 1.0) > 1e-3)
    peak = transmissibility.absolute_amplitude(0.0038, 1.0)
    for answer in (tmd_comparison(between), optimal_designs(between)):
        rows = {row[0]: row[1] for row in answer.attrs["brief"]["rows"]}
        assert float(rows["without damper"]) == pytest.approx(peak, rel=5e-3)


def test_h2_follows_the_excitation_and_is_refused_where_it_has_no_optimum(cube):
    tunings = {
        how: tmd_comparison(cube, Tuning("h2", excitation=how)).attrs["tmd_tuning"]
        for how in (None, "base", "force")
    }
    mass = float(cube["mass_ratio"].values[0])
    shaken, pushed = np.sqrt(1 - mass / 2) / (1 + mass), np.sqrt(1 + mass / 2) / (1 + mass)
    assert list(tunings.values()) == pytest.approx([shaken, shaken, pushed], rel=1e-14)
    with pytest.raises(QueryFault, match="below 2 for h2"):
        tmd_comparison(cube, Tuning("h2", mass_ratio=2.0))
    assert tmd_comparison(cube, Tuning("h2", mass_ratio=2.0, excitation="force")).attrs["tmd_tuning"] > 0


def test_a_force_has_its_own_transfer_function_and_a_study_of_one_is_compared_under_it(cube, whole):
    answer = tmd_comparison(cube, Tuning("hinf", excitation="force"))
    r = whole["frequency_ratio"].values
    tuning, damping, _ = tuned_mass.exact_optimum(0.1)
    # a shaken base acts through the structure's spring and dashpot: |1 + 2iζr| times a force over the stiffness
    base = tuned_mass.amplitude_ratio(r, 0.1, tuning, damping, 0.0038)
    np.testing.assert_allclose(answer["tmd"], base / np.hypot(1, 2 * 0.0038 * r), rtol=1e-11)
    assert "a force excites the structure" in answer.attrs["note"]
    assert "force" not in tmd_comparison(cube, Tuning("hinf")).attrs["note"]
    forced = cube.copy()
    forced.attrs["study"] = json.dumps(json.loads(cube.attrs["study"]) | {"excitation": "force"})
    under_it = tmd_comparison(forced, Tuning("hinf"))
    assert under_it.attrs["excitation"] == "force"
    np.testing.assert_array_equal(answer["tmd"], under_it["tmd"])
    assert "In the study the base is shaken" not in under_it.attrs["note"]
    with pytest.raises(QueryFault, match="force, the excitation of the study"):
        tmd_comparison(forced, Tuning(excitation="base"))


def test_masses_are_equal_unless_told_otherwise_and_then_it_is_said(cube):
    bare = cube.assign_coords(mass_ratio=[0.0])
    assert tmd_comparison(bare, Tuning(mass_ratio=0.1)).attrs["tmd_mass_ratio"] == 0.1
    assert tmd_comparison(cube).attrs["tmd_mass_ratio"] == 0.1
    other = tmd_comparison(cube, Tuning(mass_ratio=0.05))
    assert other.attrs["tmd_mass_ratio"] == 0.05
    assert ["the masses differ", "0.1"] in [row[:2] for row in other.attrs["brief"]["rows"]]


def test_a_curve_that_is_not_computed_has_no_peak_and_no_ratio(whole):
    whole["amplitude_ratio"][:] = np.nan
    whole["status"][:] = -1
    answer = tmd_comparison(whole, Tuning("hinf"))
    assert math.isnan(answer.attrs["ratio"])
    assert answer.attrs["complete"] == 0
    assert "6 of 6 frequencies have no value (6 not computed yet)" in answer.attrs["verdict"][0]
    assert answer.attrs["brief"]["damper"] is None


def linear(r: Sequence[float], damping: float, **axes: float | list[float]) -> xr.Dataset:
    """The cube of a structure without a particle, solved here: without friction every value has a closed form."""
    given = {"clearance_ratio": 1.0, "friction_ratio": 0.0, "restitution": 0.5, "mass_ratio": 0.0} | axes
    study = parse_study({"damping_ratio": damping, "axes": given | {"frequency_ratio": list(r)}})
    return solved(study)


def test_that_a_peak_is_lower_is_said_only_where_the_frequencies_are_close_enough_to_know():
    """The structure alone, whose peak 1/(2ζ) = 25 lies between two of three frequencies."""
    tuning = Tuning("hinf", mass_ratio=0.1)
    coarse = tmd_comparison(linear([0.8, 1.2, 1.6], 0.02), tuning)
    assert coarse.attrs["ratio"] < 1
    assert not coarse.attrs["judged"]
    assert coarse.attrs["brief"]["damper"] is None
    assert len(coarse.attrs["verdict"]) == 1
    # the bandwidth is 2ζ = 0.04; of intervals of 0.4 each the fortieth part is a quarter of it
    assert "`frequency_ratio: {start: 0.8, stop: 1.6, num: 81}`" in coarse.attrs["brief"]["next"]
    fine = tmd_comparison(linear(np.linspace(0.8, 1.6, 161), 0.02), tuning)
    assert fine.attrs["judged"]
    assert fine.attrs["brief"]["damper"] == "tuned_mass_damper"
    assert len(fine.attrs["verdict"]) == 1
    # friction of 0.8 of the spring's amplitude leaves no resonance, and 33 frequencies would not hide one
    rubbed = tmd_comparison(
        linear(np.linspace(0.8, 1.6, 33), 0.02, friction_ratio=0.8), Tuning("hinf", mass_ratio=0.01)
    )
    assert rubbed.attrs["judged"]
    assert rubbed.attrs["brief"]["damper"] == "friction_alone"


def test_a_flank_at_which_the_particle_begins_to_strike_may_change_the_winner():
    """Five frequencies 0.05 apart: next to a jump, the flank of X = 3.52 may rise to 5.9, above the absorber's 4.46."""
    cube = linear(np.linspace(0.9, 1.1, 5), 0.02, friction_ratio=0.8, mass_ratio=0.1)
    cube["amplitude_ratio"].values[...] = [3.5, 3.52, 3.4, 3.0, 2.0]
    kinds = [ResponseClass.NO_IMPACT, *[ResponseClass.CHAOTIC] * 4]
    cube["response_class"].values[...] = kinds
    answer = tmd_comparison(cube, Tuning("hinf", mass_ratio=0.1))
    assert answer.attrs["ratio"] < 1
    assert not answer.attrs["judged"]
    brief = answer.attrs["brief"]
    assert brief["damper"] is None
    assert "num: " in brief["next"]
    # a flank that high cannot reach the peak of an absorber of a hundredth of the mass
    assert tmd_comparison(cube, Tuning("hinf", mass_ratio=0.01)).attrs["judged"]


def test_the_next_step_asks_for_no_less_detuning_than_was_asked():
    cube = linear(np.linspace(0.8, 1.6, 161), 0.02)
    for detuning, named in (
        (0.0, "--detuning 0.02"),
        (0.05, "damperlab report"),
        (-0.05, "damperlab report"),
    ):
        answer = tmd_comparison(cube, Tuning("hinf", mass_ratio=0.1, detuning=detuning))
        assert named in answer.attrs["brief"]["next"]


def test_an_unbounded_response_has_no_lower_peak():
    """Without damping the structure alone is unbounded at r = 1, whatever it is beside."""
    answer = tmd_comparison(linear([0.5, 1.0, 1.6], 0.0), Tuning("hinf", mass_ratio=0.1))
    assert answer["status"].values.tolist() == [0, Status.UNBOUNDED, 0]
    assert math.isinf(answer.attrs["hybrid_peak"])
    assert answer.attrs["hybrid_peak_at"] == 1.0
    assert answer.attrs["judged"]
    # where nothing moves without bound the structure alone is the better one
    assert answer.attrs["hybrid_better_share"] == pytest.approx(2 / 3)
    (sentence,) = answer.attrs["verdict"]
    assert "grows without bound at r = 1" in sentence
    assert answer.attrs["brief"]["damper"] == "tuned_mass_damper"
    assert ["without damper", "grows without bound", ""] in answer.attrs["brief"]["rows"]
    assert not any(low <= 1.0 <= high for low, high in answer.attrs["hybrid_better"])


def test_part_of_a_curve_can_show_a_higher_peak_but_no_lower_one():
    r = np.linspace(0.8, 1.6, 161)
    tuning = Tuning("hinf", mass_ratio=0.1)
    for above, judged in ((1.2, False), (0.9, True)):
        cube = linear(r, 0.02)
        waiting = r < above
        cube["amplitude_ratio"].values[..., waiting] = np.nan
        cube["status"].values[..., waiting] = Status.NOT_COMPUTED
        answer = tmd_comparison(cube, tuning)
        assert answer.attrs["judged"] is judged
        (sentence,) = answer.attrs["verdict"]
        assert ("at least" in sentence) is judged
        missing = f"{waiting.sum()} of 161 frequencies have no value ({waiting.sum()} not computed yet)"
        assert (missing in sentence) is not judged
        assert answer.attrs["brief"]["damper"] == ("tuned_mass_damper" if judged else None)


def test_what_is_not_named_of_a_design_is_that_of_the_best_and_it_is_said():
    cube = linear(np.linspace(0.8, 1.6, 161), 0.02, friction_ratio=[0.0, 0.2, 0.4], mass_ratio=[0.05, 0.1])
    tuning = Tuning("hinf")
    # without a stop the least friction of these is the worst; a particle in a cavity as long as this adds to it
    best = optimal_designs(cube, top=1)
    active = best.attrs["best_with_impacts"]  # which is the best of all
    assert active["value"] == float(best["value"][0])
    names = ("friction_ratio", "mass_ratio")
    lead = {name: active[name] for name in names}
    answer = tmd_comparison(cube, tuning)
    assert {name: float(answer[name]) for name in names} == lead
    assert answer.attrs["hybrid_peak"] == active["value"]
    chosen = (
        f"of the study, as no design was named: β = {lead['mass_ratio']:g}, γ_F = {lead['friction_ratio']:g}."
    )
    assert chosen in answer.attrs["note"]
    xr.testing.assert_equal(answer, tmd_comparison(cube, tuning, lead))
    assert "The compared design" not in tmd_comparison(cube, tuning, lead).attrs["note"]
    lighter = tmd_comparison(cube, Tuning("hinf", tmd_mass_ratio=0.02))
    assert lighter.attrs["tmd_mass_ratio"] == 0.02
    xr.testing.assert_equal(lighter["hybrid"], answer["hybrid"])
    both = tmd_comparison(cube, Tuning("hinf", mass_ratio=0.05, tmd_mass_ratio=0.02))
    assert (both.attrs["tmd_mass_ratio"], float(both["mass_ratio"])) == (0.02, 0.05)
    partly = tmd_comparison(cube, tuning, {"mass_ratio": 0.06})
    assert float(partly["mass_ratio"]) == 0.05
    among = [tmd_comparison(cube, tuning, {"mass_ratio": 0.05, "friction_ratio": g}) for g in (0.0, 0.2, 0.4)]
    assert partly.attrs["hybrid_peak"] == min(each.attrs["hybrid_peak"] for each in among)
    assert "among those with the named values: γ_F = " in partly.attrs["note"]


def test_of_a_study_of_which_a_part_is_computed_neither_damper_is_recommended(cube):
    brief = tmd_comparison(cube).attrs["brief"]
    assert brief["damper"] is None
    assert brief["next"] == "damperlab run answers"


def test_at_one_frequency_nothing_is_said_to_be_better(finished):
    cube = finished
    computed = np.flatnonzero(np.isfinite(tmd_comparison(cube)["hybrid"].values))
    alone = tmd_comparison(cube.isel(frequency_ratio=computed[:1])).attrs
    assert alone["next_frequencies"] == {"start": 0.8, "stop": 1.25, "num": 19}
    assert alone["brief"]["damper"] is None
    assert alone["brief"]["rows"] == []  # two peaks beside each other would be read as a verdict
    assert "{start: 0.8, stop: 1.25, num: 19}" in alone["brief"]["next"]
    band = tmd_comparison(cube).attrs
    assert "next_frequencies" not in band
    assert (band["brief"]["damper"] == "tuned_mass_damper") is (band["ratio"] > 1)
    lower = 1 - min(band["ratio"], 1 / band["ratio"])
    assert f"{100 * lower:.2g} % lower" in " ".join(band["verdict"])
