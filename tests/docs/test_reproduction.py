"""The page on the paper reproduced is the report of today: its sections, and every number of those that take seconds."""

from dataclasses import replace

import pytest
import xarray as xr
from docs.computed import is_of_here
from docs.console import Shown, difference
from docs.reproduced import KEY, PAGE, RECOMPUTED, section_in
from tests.studies.solving import LEAN

from damperlab.service.documents import plain
from damperlab.service.reproduction.prototype import (
    Prototype,
    computed_here,
    deviation,
    fitted,
    intervals,
    peaks_of,
)
from damperlab.service.reproduction.report import SECTIONS, in_markdown
from damperlab.studies.definition import Study, parse_harmonic
from damperlab.studies.paper import paper_numbers
from damperlab.studies.plan import Block
from damperlab.studies.variables import DIMENSIONS
from damperlab.worker.block import solve_block

REPORT = {"created": "", "version": "", "kernels": "", "quick": False, "seconds": 0.0, "paper": ""}


def solve(study: Study) -> xr.Dataset:
    values = solve_block(study, Block.whole(study.shape))
    return xr.Dataset({name: (DIMENSIONS, array) for name, array in values.items()}, study.coordinates)


@pytest.mark.parametrize("name", RECOMPUTED)
def test_sections_that_take_seconds_come_to_what_the_page_says(name: str) -> None:
    document = plain(SECTIONS[name](solve, False).document())
    found = section_in(in_markdown({**REPORT, "sections": [{**document, "figures": []}]}), document["title"])
    told = section_in(PAGE.read_text(encoding="utf-8"), document["title"])
    assert told.count("\n| ") >= len(document["rows"])
    assert difference(Shown("damperlab check paper", told + "\n"), found + "\n", is_of_here(KEY)) == ""


def test_the_page_has_every_section_of_the_paper() -> None:
    page = PAGE.read_text(encoding="utf-8")
    heads = [line for line in page.splitlines() if line.startswith("## ")]
    assert len(heads) == len(SECTIONS)
    for part in ("Figure 7", "Figure 8", "Figure 9", "Figures 10", "Figure 11", "Figure 12", "Figure 14", "Table 3",
                 "Table 4", "Table A1", "Figure A2"):  # fmt: skip
        assert any(part in head for head in heads), part


def test_a_particle_that_its_friction_carries_meets_no_wall() -> None:
    """Then the cavity's length is of no account, and the particle is mass: the peak of m(1 + β) on the same spring.

    No metric is an integral, and of friction there is next to none: the kernels of this scene are compiled already.
    """
    asked = Prototype(0.0001, 0.03, 0.2).study().document()
    asked["metrics"] = LEAN
    asked["axes"]["friction_ratio"][0] = 1e-13
    peaks = peaks_of(computed_here(parse_harmonic(asked)))
    assert peaks["particle_1"] == pytest.approx(peaks["particle_3"], rel=1e-12)
    beta = paper_numbers()["mass_ratio"].value
    ratios = [0.86 + 0.26 * i / 52 for i in range(53)]
    closed = [abs(complex(1, 0.06 * r) / complex(1 - (1 + beta) * r * r, 0.06 * r)) for r in ratios]
    assert peaks["particle_2"] == pytest.approx(max(closed), rel=1e-9)


def test_a_prototype_that_measures_what_is_printed_deviates_by_nothing() -> None:
    """One number twice as large, of six, deviates by ln 2/√6."""
    printed = {
        f"{kind}_{k}": paper_numbers()[f"{kind}_{k}"].value
        for kind in ("particle", "hybrid")
        for k in (1, 2, 3)
    }
    assert deviation(printed) == 0.0
    assert deviation({**printed, "hybrid_2": 2 * printed["hybrid_2"]}) == pytest.approx(
        0.6931471805599453 / 6**0.5
    )


@pytest.mark.night
def test_intervals_are_those_of_least_squares() -> None:
    """At either end of μ_i the best deviation is the threshold of the same confidence: F of 1 and 3 degrees of freedom."""
    best = Prototype(0.002118, 0.01262, 0.094)
    free = ("base_amplitude_m", "damping_ratio", "particle_friction")
    found = intervals(best, free)
    for name, (low, high) in found.items():
        assert low < getattr(best, name) < high
    least = deviation(peaks_of(computed_here(best.study())))
    threshold = least * (1.0 + 10.128 / 3.0) ** 0.5
    for end in found["particle_friction"]:
        there = fitted(replace(best, particle_friction=end), free[:2], quick=False)
        assert deviation(peaks_of(computed_here(there.study()))) == pytest.approx(threshold, rel=0.15)
