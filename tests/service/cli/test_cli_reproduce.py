"""damperlab check paper, the short form, run for real: its links, its completeness, and Table A1.

Numbers of the other sections are held against the page on the paper by `tests/docs/test_reproduction.py`.
"""

import json
import re
from pathlib import Path
from typing import Any

import pytest
from tests.service.cli.commands import END_SECONDS, run, run_apart

from damperlab.studies.paper import paper_numbers

pytestmark = pytest.mark.night

PNG = b"\x89PNG\r\n\x1a\n"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    folder = tmp_path_factory.mktemp("reproduction")
    asked = ["check", "paper", "--quick", "-o", folder / "out", "--data-dir", folder / "data"]
    # many kernels, where none is compiled yet
    ended = run_apart(*asked, "--workers", "1", "--json", seconds=3 * END_SECONDS)
    return folder, json.loads(ended.stdout)


def rows(report: dict[str, Any], title: str, quantity: str, assumption: str = "") -> list[dict[str, Any]]:
    found = [
        row
        for section in report["sections"]
        if section["title"].startswith(title)
        for row in section["rows"]
        if row["quantity"].startswith(quantity) and assumption in row["assumption"]
    ]
    assert found, f"no row {quantity} {assumption} in {title}"
    return found


def test_the_report_is_complete_and_its_links_lead_somewhere(made: tuple[Path, dict[str, Any]]) -> None:
    folder, report = made
    out = folder / "out"
    words = (out / "reproduction.md").read_text(encoding="utf-8")
    assert json.loads((out / "reproduction.json").read_text(encoding="utf-8")) == report
    linked = re.findall(r"!\[[^]]*\]\(([^)]+)\)", words)
    assert sorted(linked) == sorted(path.name for path in out.glob("*.png"))
    assert len(linked) == 10
    for name in linked:
        assert (out / name).read_bytes().startswith(PNG)
    printed = {number.value for number in paper_numbers().values()}
    for section in report["sections"]:
        assert section["rows"], section["title"]
        for row in section["rows"]:
            assert row["quantity"] in words
            assert row["ours"] is not None, row
            if row["paper"] is not None:
                assert row["place"]
                # as printed, or what follows from it by the spring's law or a ratio
                assert row["paper"] in printed or "F_N" in row["place"] or row["place"].startswith("from ")
    # all nine entries of Table 3 beside ours
    entries = {
        (row["quantity"], row["paper"])
        for row in rows(report, "Table 3", "")
        if row["place"] == "Table 3" and ", d = " in row["quantity"]
    }
    assert len(entries) == 6
    assert {row["paper"] for row in rows(report, "Table 3", "friction alone")} == {16.22}


def test_table_a1_has_every_damper_and_the_bare_structure_is_scaled_to_the_paper(
    made: tuple[Path, dict[str, Any]],
) -> None:
    _, report = made
    for name in ("no damper", "tuned mass damper", "particle", "friction", "particle and friction"):
        assert len({row["paper"] for row in rows(report, "Table A1", f"{name}, ")}) == 2  # peak and rms
    (bare,) = rows(report, "Table A1", "no damper, peak")
    # a linear structure, so the factor that was found gives the paper's peak but for rounding
    assert bare["ours"] == pytest.approx(0.1671, rel=1e-12)
    peaks = {
        name: min(row["ours"] for row in rows(report, "Table A1", f"{name}, peak"))
        for name in ("tuned mass damper", "particle and friction")
    }
    (less,) = rows(report, "Table A1", "relative reduction of the peak, best hybrid")
    expected = 1 - peaks["particle and friction"] / peaks["tuned mass damper"]
    assert less["ours"] == pytest.approx(expected, rel=1e-12)


def test_a_second_run_computes_nothing_and_says_the_same(made: tuple[Path, dict[str, Any]]) -> None:
    folder, report = made
    ended = run("check", "paper", "--quick", "-o", folder / "again", "--data-dir", folder / "data", "--json")
    again = json.loads(ended.stdout)
    assert again["sections"] == report["sections"]
    assert " points, " not in ended.stderr  # the progress of a study
