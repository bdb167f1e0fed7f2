"""The page on the paper reproduced is the report of today: its sections, and every number of those that take seconds."""

import pytest
import xarray as xr
from docs.computed import is_of_here
from docs.console import Shown, difference
from docs.reproduced import KEY, PAGE, RECOMPUTED, page_of, section_in

from damperlab.service.documents import plain
from damperlab.service.reproduction.report import SECTIONS, in_markdown
from damperlab.studies.definition import Study
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
    assert difference(Shown("damperlab reproduce", told + "\n"), found + "\n", is_of_here(KEY)) == ""


def test_the_page_has_every_section_of_the_paper() -> None:
    page = PAGE.read_text(encoding="utf-8")
    heads = [line for line in page.splitlines() if line.startswith("## ")]
    assert len(heads) == len(SECTIONS)
    for part in ("Figure 7", "Figure 8", "Figure 9", "Figures 10", "Figure 11", "Figure 12", "Figure 14", "Table 3",
                 "Table 4", "Table A1", "Figure A2"):  # fmt: skip
        assert any(part in head for head in heads), part


def test_a_short_form_is_no_page() -> None:
    with pytest.raises(ValueError, match="short form"):
        page_of({**REPORT, "quick": True, "sections": []})
