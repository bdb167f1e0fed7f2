"""The commands records and earthquake."""

import json
from pathlib import Path

import pytest

from tests.service.cli.commands import run


def test_records_are_listed_and_kept(tmp_path: Path) -> None:
    listed = run("records", "--data-dir", tmp_path)
    assert "loma-prieta-000" in listed.stdout
    file = tmp_path / "mine.csv"
    file.write_text("time (s), acceleration (g)\n0, 0\n0.01, 0.1\n0.02, -0.05\n0.03, 0\n")
    kept = json.loads(run("records", file, "--data-dir", tmp_path, "--json").stdout)
    assert kept["name"] == "mine"
    assert kept["id"] in run("records", "--data-dir", tmp_path).stdout
    file.write_text("time (s), acceleration (g)\n0, 0\n0.01, oops\n")
    refused = run("records", file, "--data-dir", tmp_path, status=2)
    assert "line 3" in refused.stderr
    made = run("records", "--kanai-tajimi", "4", "--duration-s", "15", "--data-dir", tmp_path)
    assert "Kept" in made.stdout


def test_a_comparison_prints_its_table_and_draws_it(tmp_path: Path) -> None:
    arguments = ("earthquake", "northridge", "--starts", "1", "--data-dir", tmp_path)
    table = run(*arguments)
    assert "tuned mass damper" in table.stdout
    assert "Energy balances" in table.stdout
    answer = json.loads(run(*arguments, "--json").stdout)
    assert answer["record"]["id"] == "northridge-090"
    assert answer["cases"]["none"]["energy_residual"] < 1e-9
    figure, csv = tmp_path / "histories.png", tmp_path / "table.csv"
    run(*arguments, "-o", figure)
    assert figure.read_bytes().startswith(b"\x89PNG")
    run(*arguments, "-o", csv)
    header, *rows = csv.read_text().splitlines()
    assert [row.split(",")[0] for row in rows] == ["none", "tmd", "pid", "fd", "hybrid"]
    place = header.split(",").index("peak_relative_displacement_m")
    assert float(rows[0].split(",")[place]) == pytest.approx(
        answer["cases"]["none"]["peak_relative_displacement_m"], rel=1e-15
    )


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (("nowhere",), "loma-prieta"),
        (("missing.at2",), "cannot be read"),
        (("--restitution", "2"), "restitution"),
        (("-o", "x.gif"), ".png"),
    ],
)
def test_bad_usage_says_what_to_do(tmp_path: Path, arguments: tuple[str, ...], word: str) -> None:
    assert word in run("earthquake", *arguments, "--data-dir", tmp_path, status=2).stderr


def test_a_survey_ranks_and_is_written(tmp_path: Path) -> None:
    file = tmp_path / "survey.yaml"
    file.write_text("records: [northridge]\nclearance_m: [0.001, 0.004]\nfriction_force_n: [0.05, 0.2]\n")
    out = tmp_path / "all.nc"
    best = json.loads(run("survey", file, "-o", out, "--data-dir", tmp_path, "--json").stdout)
    assert best["points"] == 4
    worst = [row["worst"] for row in best["best"]]
    assert worst == sorted(worst)
    assert out.stat().st_size > 1000
    assert "Worst over records" in run("survey", file, "--data-dir", tmp_path).stdout
    file.write_text("records: [northridge]\nclearance: 1\n")
    assert "clearance_m" in run("survey", file, "--data-dir", tmp_path, status=2).stderr
