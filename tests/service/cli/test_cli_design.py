"""The command `design` on a real store, and the report that it writes."""

import json
from pathlib import Path
from typing import Any

import pytest
from tests.service.cli.commands import run

from damperlab.studies.design.shelf import Shelf
from damperlab.studies.store.store import Store

SPECIFICATION: dict[str, Any] = {
    "name": "small <machine>",
    "structure": {"mass_kg": 40.0, "natural_frequency_hz": 8.0, "damping_ratio": 0.0038},
    "excitation": {"base_amplitude_m": 0.001, "frequency_hz": 8.8},
    "choose": {"friction_force_n": [30.0, 60.6]},
    "clearance_m": 0.002,
    "particle_mass_kg": 4.0,
    "restitution": 0.47,
    "tolerances": {"friction_force_n": "10%"},
    "limits": {"displacement_m": 0.005},
    "builds": 2,
}
"""Some 40 points of one frequency, other amplitudes and masses among them, and more than one response."""


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """A folder in which a design was made, and what it printed."""
    folder = tmp_path_factory.mktemp("design")
    (folder / "spec.json").write_text(json.dumps(SPECIFICATION | {"budget_points": 500}))
    ended = run(
        "design", folder / "spec.json", "--data-dir", folder / "data", "-o", folder / "report.html", "--json"
    )
    return folder, json.loads(ended.stdout)


def test_asked_again_nothing_is_computed_and_who_waits_is_told_the_best_damper_so_far(
    written: tuple[Path, dict[str, Any]],
) -> None:
    folder, document = written
    before = Store.open(folder / "data").page(200).records
    again = run("design", folder / "spec.json", "--data-dir", folder / "data", "--json")
    assert json.loads(again.stdout) == document
    assert Store.open(folder / "data").page(200).records == before
    first, *_, last = [line for line in again.stderr.splitlines() if " of at most " in line]
    assert first.startswith(f"0 of at most {document['budget_points']:,} points")
    assert "Now: " in first
    assert f"friction force {document['design']['friction_force_n']:.4g} N" in last


def test_what_the_command_finds_is_kept_as_what_a_service_finds_is(
    written: tuple[Path, dict[str, Any]],
) -> None:
    folder, document = written
    shelf = Shelf(folder / "data")
    (kept,) = shelf.every()
    assert (kept.name, kept.state, kept.round.studies) == ("small <machine>", "done", ())
    assert kept.round.known["worst"] == document["worst"]
    assert shelf.answer(kept.id) == document
    assert shelf.report(kept.id).decode() == (folder / "report.html").read_text()


def test_a_design_is_listed_renamed_put_into_the_trash_and_restored(
    written: tuple[Path, dict[str, Any]],
) -> None:
    data = ("--data-dir", written[0] / "data")

    def listed(*options: str) -> dict[str, str]:
        found = json.loads(run("designs", "list", *options, "--json", *data).stdout)["designs"]
        return {each["id"]: each["name"] for each in found}

    (design_id,) = listed()
    run("designs", "rename", "small <machine>", "pump", *data)
    assert listed() == {design_id: "pump"}
    assert run("designs", "list", *data).stdout.splitlines()[-1].split()[:3] == [design_id, "pump", "done"]
    run("designs", "delete", "pump", *data, status=1)  # nobody is there to answer
    run("designs", "delete", "pump", "--trash", *data)
    run("designs", "rename", design_id, "x", *data, status=2)
    assert (listed(), listed("--trash")) == ({}, {design_id: "pump"})
    run("designs", "undelete", design_id, *data)
    run("designs", "rename", design_id, SPECIFICATION["name"], *data)
    assert (listed(), listed("--trash")) == ({design_id: SPECIFICATION["name"]}, {})


def test_the_report_draws_what_the_answer_says(written: tuple[Path, dict[str, Any]]) -> None:
    folder, document = written
    page = (folder / "report.html").read_text()
    # over the frequency, over amplitudes, against mass
    assert page.count("data:image/svg+xml;base64,") == 3
    assert "<h2>Mass against response</h2>" in page
    assert document["starts"]["several"]
    assert "<h2>More than one response</h2>" in page
    assert "tuned mass damper, up to 2 % out of tune" in page


def test_a_dry_run_says_the_budget_and_stores_nothing(tmp_path: Path) -> None:
    said = run("design", "prototype", "--dry-run", "--json", "--data-dir", tmp_path / "data")
    assert json.loads(said.stdout)["budget_points"] > 1000
    assert not (tmp_path / "data").exists()
    told = SPECIFICATION | {"excitation": {"base_amplitude_m": 0.3, "frequency_hz": 8.0}}
    (tmp_path / "millimetres.json").write_text(json.dumps(told))
    asked = ("design", tmp_path / "millimetres.json", "--dry-run", "--data-dir", tmp_path / "data")
    assert "check the units of `clearance_m`" in run(*asked).stdout
