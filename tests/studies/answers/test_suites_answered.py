"""Answers about ground-motion suites: quantities by their terms, lengths in mm, and whether the best lies where axes end."""

import json
import re

import numpy as np
import pytest
import xarray as xr

from damperlab.service.cli.words import map_table, rows_table
from damperlab.studies.answers.phrases import RATIOS, Phrases
from damperlab.studies.answers.resonance_map import resonance_map
from damperlab.studies.answers.suite import worst_case_designs
from damperlab.studies.ground.builtin import builtin_record
from damperlab.studies.ground.variables import DIMENSIONS, RECORD
from damperlab.studies.kinds import KINDS
from damperlab.studies.questions import Judging, Ranking, Selection
from damperlab.studies.tmd.minimax import minimax
from damperlab.studies.variables import Status
from damperlab.worker.ground.absorber import absorber_response
from damperlab.worker.ground.design import Structure

PEAK = "peak_relative_displacement_m"
RAW = re.compile(r"\b[a-z]{2,}(?:_[a-z0-9]+)+\b")


CLEARANCE, FRICTION = np.array([0.005, 0.01, 0.02]), np.array([0.0, 1.0, 2.0])


def made(values: object = None) -> xr.Dataset:
    """A suite of two records: results over clearance and friction, of the second record half as much."""
    axes = dict.fromkeys(DIMENSIONS, np.array([0.5])) | {
        RECORD: np.array(["one", "two"]),
        "clearance_m": CLEARANCE,
        "friction_force_n": FRICTION,
    }
    shape = tuple(axes[name].size for name in DIMENSIONS)
    given = np.linspace(0.022, 0.014, 9).reshape(3, 3) if values is None else np.asarray(values)
    order = sorted((RECORD, "clearance_m", "friction_force_n"), key=list(DIMENSIONS).index)
    assert order == [RECORD, "clearance_m", "friction_force_n"]
    placed = (np.array([1.0, 0.5])[:, None, None] * given).reshape(shape)
    coords = {name: (name, axes[name], {"units": unit}) for name, (unit, _) in DIMENSIONS.items()}
    data = {PEAK: (DIMENSIONS, placed, {"units": "m", "long_name": "peak relative displacement"})}
    return xr.Dataset({**data, "status": (DIMENSIONS, np.zeros(shape, np.int8))}, coords)


def test_no_sentence_names_a_raw_dimension_and_lengths_are_in_mm() -> None:
    cube = made()
    answer = resonance_map(cube, "clearance_m", "friction_force_n", Selection())
    note = answer.attrs["note"]
    assert not RAW.search(note)
    brief = worst_case_designs(cube).attrs["brief"]
    first = brief["sentences"][0]
    assert brief["damper"] == "hybrid"
    assert not RAW.search(" ".join(brief["sentences"]))
    assert all(each in first for each in ("d = 20 mm", "14 mm", "one"))


def test_a_suite_of_which_a_part_is_computed_recommends_no_damper() -> None:
    cube = made()
    cube["status"][{"clearance_m": 0}] = Status.NOT_COMPUTED
    brief = worst_case_designs(cube).attrs["brief"]
    assert brief["damper"] is None
    cube["status"][...] = Status.NOT_COMPUTED
    (told,) = worst_case_designs(cube).attrs["brief"]["sentences"]
    assert told == "No damper qualifies. Left out of 9 dampers: 9 not computed yet."


def test_a_map_is_of_the_worst_record_and_names_it_or_of_the_one_that_is_named() -> None:
    cube = made()
    cube[PEAK].loc[{RECORD: "two", "clearance_m": 0.02}] *= 4.0
    axes = ("clearance_m", "friction_force_n")
    both = cube[PEAK].squeeze().transpose(RECORD, *axes[::-1])
    worst = resonance_map(cube, *axes)
    np.testing.assert_array_equal(worst[PEAK], both.max(RECORD))
    np.testing.assert_array_equal(worst[f"{RECORD}_at"], [["one", "one", "two"]] * 3)
    for name in ("one", "two"):
        alone = resonance_map(cube, *axes, Selection(at={RECORD: name}))
        np.testing.assert_array_equal(alone[PEAK], both.sel({RECORD: name}))
        ranked = worst_case_designs(cube, ranking=Ranking(records=(name,)))
        np.testing.assert_array_equal(ranked["value"], np.sort(both.sel({RECORD: name}), axis=None))
        assert set(ranked[RECORD].values) == {name}


def test_a_map_is_of_the_scale_and_structure_that_are_worst_for_the_best_damper() -> None:
    """The least of the map is what `optimum` states, not the response at the first, smallest scale."""
    parts = [
        made().assign_coords(scale=[scale], natural_frequency_hz=[f])
        for scale in (0.5, 1.0)
        for f in (2.0, 3.0)
    ]
    for part, factor in zip(parts, (0.5, 0.4, 1.0, 0.8), strict=True):
        part[PEAK] = part[PEAK] * factor
    cube = xr.combine_by_coords(parts, combine_attrs="override")
    shown = resonance_map(cube, "clearance_m", "friction_force_n")
    assert (shown["scale"], shown["natural_frequency_hz"]) == (1.0, 2.0)
    assert float(shown[PEAK].min()) == worst_case_designs(cube)["value"][0]
    assert "factor on the record = 1 (the worst of 2 for the best design)" in shown.attrs["note"]
    named = resonance_map(
        cube, "clearance_m", "friction_force_n", Selection(at={"natural_frequency_hz": 3.0})
    )
    assert (named["scale"], named["natural_frequency_hz"]) == (1.0, 3.0)


def test_dampers_are_ranked_alike_in_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = worst_case_designs(made())
    monkeypatch.setattr("damperlab.studies.answers.slab.BUDGET", 1)
    assert worst_case_designs(made()).identical(whole)


def test_friction_that_holds_the_structure_in_every_case_is_said_first() -> None:
    """The stored shares may be below 1 by rounding."""
    cube = made()
    cube["stick_fraction"] = cube[PEAK] * 0 + 1 - 4e-14
    cube["stick_fraction"][{"friction_force_n": 0}] = 0.0
    answer = worst_case_designs(cube)
    brief = answer.attrs["brief"]
    assert brief["next"] == "friction force F_f below 2 N."
    assert [note["kind"] for note in answer.attrs["notes"]] == ["clamped"]
    cube["stick_fraction"][{RECORD: 1}] = 0.9
    assert "clamps" not in worst_case_designs(cube).attrs["brief"]["sentences"][0]


def test_tables_are_in_mm() -> None:
    cube = made()
    phrases = Phrases.of(cube)
    answer = resonance_map(cube, "clearance_m", "friction_force_n", Selection(at={RECORD: "one"}))
    head, rows = map_table(answer, PEAK, phrases)
    assert head == ("F_f [N] \\ d [mm]", "5", "10", "20")
    assert rows[-1] == ("0", "22", "19", "16")
    head, rows = rows_table(worst_case_designs(cube), phrases, {"value": PEAK})
    table = dict(zip(head, rows[0], strict=True))
    assert table["clearance d [mm]"] == "20"
    assert table["value [mm]"] == "14"


@pytest.mark.parametrize("height", [1e-6, 10.0])
def test_a_tuned_mass_damper_is_named_under_records_too(height: float) -> None:
    """Its worst case is the larger of those of comparisons under the two records, at the suite's scale."""
    motions = {name: builtin_record(name) for name in ("el-centro-180", "loma-prieta-000")}
    cube = made(np.full((3, 3), height)).assign_coords({RECORD: (RECORD, list(motions))})
    cube.attrs["study"] = json.dumps({"mass_kg": 5.0, "tail_s": 2.0})
    structure, tuned = Structure(5.0, 0.5, 0.5), minimax(0.1, 0.5)
    worst, bare = (
        max(
            absorber_response(structure, each, motion, 0.5, 2.0).peak_relative_displacement_m
            for motion in motions.values()
        )
        for each in (tuned, None)
    )
    answer = worst_case_designs(cube, motions=lambda: motions)
    brief = answer.attrs["brief"]
    rows = {row[0]: row[1] for row in brief["rows"]}
    assert rows["without damper"] == f"{1e3 * bare:.3g} mm"
    if height < worst:
        assert (brief["damper"], rows["tuned mass damper"]) == ("particle_alone", f"{1e3 * worst:.3g} mm")
    else:
        assert brief["damper"] == "tuned_mass_damper"
        said = f"A tuned mass damper of m = 0.5 kg does better: at worst {1e3 * worst:.3g} mm."
        assert brief["sentences"][0].startswith(said)
        assert answer.attrs["notes"][0]["values"]["value"] == pytest.approx(worst, rel=1e-12)


def test_every_dimension_of_every_kind_has_a_term() -> None:
    for kind in KINDS:
        for name in kind.dimensions:
            assert not RAW.search(RATIOS.label(name)), name


def ends(
    values: list[list[float]], judging: Judging = Judging(), ranking: Ranking = Ranking()
) -> dict[str, list[object]]:
    notes = worst_case_designs(made(values), judging, ranking).attrs["notes"]
    return notes[0]["values"] if notes else {}


def test_the_best_damper_at_the_end_of_an_axis_is_said_to_be():
    rises = [[3.0, 2.5, 2.2], [2.0, 1.6, 1.3], [1.5, 1.1, 0.9]]
    both = {"clearance_m": ["upper", 0.02], "friction_force_n": ["upper", 2.0]}
    assert ends(rises) == ends(rises, ranking=Ranking(records=("two",))) == both
    # a range that was asked for ends before the axis does, and says nothing of what lies beyond
    assert ends(rises, Judging(ranges={"friction_force_n": (0.0, 1.0)})).keys() == {"clearance_m"}


@pytest.mark.parametrize(
    "values",
    [
        [[3.0, 2.0, 3.0], [2.0, 1.0, 2.0], [3.0, 2.0, 3.0]],  # inside
        [[3.0, 3.5, 4.0], [1.0, 1.2, 1.5], [3.0, 3.5, 4.0]],  # friction is never less than none
        [[1.00, 1.05, 1.08], [1.01, 1.06, 1.09], [1.02, 1.07, 1.09]],  # as good all along
    ],
)
def test_a_best_damper_elsewhere_is_not_said_to_lie_at_an_end(values: list[list[float]]):
    assert ends(values) == {}
