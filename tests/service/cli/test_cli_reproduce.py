"""damperlab check paper, the short form, run for real: its numbers beside closed forms, its links, its completeness."""

import json
import math
import re
from pathlib import Path
from typing import Any

import pytest
from tests.oracles import forced_friction, transmissibility, tuned_mass
from tests.service.cli.commands import END_SECONDS, run, run_apart

from damperlab.studies.paper import paper_numbers

pytestmark = pytest.mark.night

PNG = b"\x89PNG\r\n\x1a\n"
DAMPING = 0.0038


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


def test_friction_alone_is_that_of_the_closed_forms(made: tuple[Path, dict[str, Any]]) -> None:
    _, report = made
    exact = forced_friction.non_stop(DAMPING, 1.0, 0.6)
    assert exact is not None
    (relative,) = rows(report, "Figure 9", "γ_F = 0.6, r = 1, relative")
    assert relative["ours"] == pytest.approx(exact.relative_amplitude_ratio, rel=1e-11)
    (steady,) = rows(report, "Figure 9", "γ_F = 0.6, peak", "steady")
    assert steady["ours"] == pytest.approx(exact.amplitude_ratio, rel=1e-11)
    assert steady["difference"] == pytest.approx(exact.amplitude_ratio / 20 - 1, rel=1e-10)
    (bare,) = rows(report, "Figure 9", "no damper", "steady")
    assert bare["ours"] == pytest.approx(transmissibility.absolute_amplitude(DAMPING, 1.0), rel=1e-9)
    (stopped,) = rows(report, "Figure 9", "γ_F = 0.8, r = 1")
    once = forced_friction.one_stop(DAMPING, 1.0, 0.8)
    assert once is not None
    assert stopped["ours"] == pytest.approx(once.amplitude_ratio, rel=1e-9)
    # A(γ) = (1 − 4γ/π)/(2ζ) + O(ζ): the line through two of them ends at π/4 to about ζ²
    (limit,) = rows(report, "Figure 9", "γ_F above which")
    assert limit["ours"] == pytest.approx(math.pi / 4, abs=1e-6)


def test_the_cycle_at_which_the_peak_is_reached_is_the_first(made: tuple[Path, dict[str, Any]]) -> None:
    _, report = made
    (row,) = rows(report, "Figure 9", "γ_F = 0.6, peak", "first cycle")
    cycles = int(re.search(r"in (\d+) cycles", row["assumption"])[1])
    # the envelope of friction below π/4 grows as (1 − 4γ/π)(1 − e^(−2πζN))/(2ζ), a cycle's rounding up or down
    height = (1 - 4 * 0.6 / math.pi) / (2 * DAMPING)
    assert cycles == pytest.approx(-math.log(1 - 20 / height) / (2 * math.pi * DAMPING), abs=1.5)
    assert 20 <= row["ours"] < 20.5
    # in either reading 16.22 needs a friction ratio far below the 0.8 of the spring's law
    steady, finite = rows(report, "Figures 10", "γ_F of Δs = 4 mm")
    assert steady["ours"] == pytest.approx(
        math.pi / 4 * (1 - 2 * DAMPING * math.sqrt(16.22**2 - 1)), abs=1e-4
    )
    assert finite["ours"] < steady["ours"] < 0.7


def test_the_tuned_mass_damper_has_its_closed_form_in_both_conventions(
    made: tuple[Path, dict[str, Any]],
) -> None:
    _, report = made
    own, over = rows(report, "Table 4", "ζ_opt")
    assert own["ours"] == pytest.approx(tuned_mass.den_hartog(0.1)[1], rel=1e-14)
    assert over["ours"] == pytest.approx(math.sqrt(0.3 / (8 * 1.1**3)), rel=1e-14)
    assert over["paper"] == 0.1679
    right, mixed, least = rows(report, "Table 4", "peak of (13)")
    assert right["ours"] == pytest.approx(4.5902, abs=5e-5)
    assert mixed["ours"] == pytest.approx(4.6765, abs=5e-5)
    assert least["ours"] == pytest.approx(tuned_mass.exact_optimum(0.1)[2], rel=1e-10)


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
