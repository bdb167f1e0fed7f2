"""Sentences, tables and figures name quantities by their terms, and have lengths of ground-motion suites in mm."""

import re

import numpy as np
import xarray as xr

from damperlab.service.cli.words import map_table, rows_table
from damperlab.service.figures.curves import draw_ranking
from damperlab.service.figures.resonance_map import draw_map
from damperlab.studies.answers.phrases import RATIOS, Phrases
from damperlab.studies.answers.resonance_map import resonance_map
from damperlab.studies.answers.suite import worst_case_designs
from damperlab.studies.ground.variables import DIMENSIONS, RECORD
from damperlab.studies.kinds import KINDS
from damperlab.studies.questions import Selection

PEAK = "peak_relative_displacement_m"
RAW = re.compile(r"\b[a-z]{2,}(?:_[a-z0-9]+)+\b")


def made() -> xr.Dataset:
    """A suite of two records, three clearances and two forces."""
    axes = dict.fromkeys(DIMENSIONS, np.array([0.5])) | {
        RECORD: np.array(["one", "two"]),
        "clearance_m": np.array([0.005, 0.01, 0.02]),
        "friction_force_n": np.array([1.0, 2.0]),
    }
    shape = tuple(axes[name].size for name in DIMENSIONS)
    values = np.linspace(0.011, 0.022, int(np.prod(shape))).reshape(shape)
    coords = {name: (name, axes[name], {"units": unit}) for name, (unit, _) in DIMENSIONS.items()}
    data = {PEAK: (DIMENSIONS, values, {"units": "m", "long_name": "peak relative displacement"})}
    return xr.Dataset({**data, "status": (DIMENSIONS, np.zeros(shape, np.int8))}, coords)


def test_no_sentence_names_a_raw_dimension_and_lengths_are_in_mm() -> None:
    cube = made()
    answer = resonance_map(cube, "clearance_m", "friction_force_n", Selection())
    note = answer.attrs["note"]
    assert not RAW.search(note)
    assert "natural frequency f_n = 0.5 Hz" in note
    assert "structural damping ratio ζ = 0.5" in note
    brief = worst_case_designs(cube).attrs["brief"]
    first = brief["sentences"][0]
    assert brief["damper"] == "hybrid"
    assert not RAW.search(" ".join(brief["sentences"]))
    assert all(each in first for each in ("d = 5 mm", "17 mm", "two"))


def test_tables_are_in_mm() -> None:
    cube = made()
    phrases = Phrases.of(cube)
    answer = resonance_map(cube, "clearance_m", "friction_force_n", Selection(at={RECORD: "one"}))
    head, rows = map_table(answer, PEAK, phrases)
    assert head == ("F_f [N] \\ d [mm]", "5", "10", "20")
    assert rows[-1] == ("1", "11", "13", "15")
    head, rows = rows_table(worst_case_designs(cube), phrases, {"value": PEAK})
    table = dict(zip(head, rows[0], strict=True))
    assert table["clearance d [mm]"] == "5"
    assert table["value [mm]"] == "17"


def test_figures_are_in_mm_and_the_answer_stays_as_it_is() -> None:
    answer = resonance_map(made(), "clearance_m", "friction_force_n", Selection(at={RECORD: "one"}))
    axes, bar = draw_map(answer, PEAK).axes
    assert axes.get_xlabel().endswith("[mm]")
    assert bar.get_ylabel() == "Peak relative displacement [mm]"
    assert axes.get_xlim()[1] > 20
    assert answer["clearance_m"].values.max() == 0.02
    (ranking,) = draw_ranking(worst_case_designs(made())).axes
    assert ranking.get_xlabel().endswith("[mm]")
    assert ranking.get_xlim()[1] > 17


def test_every_dimension_of_every_kind_has_a_term() -> None:
    for kind in KINDS:
        for name in kind.dimensions:
            assert not RAW.search(RATIOS.label(name)), name
