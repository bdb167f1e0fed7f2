"""The commands records and earthquake."""

import json
from pathlib import Path
from typing import Any

import pytest
from tests.service.cli.commands import run

from damperlab.service.cli.output import two_digits
from damperlab.studies.rounding import ROUNDING


def test_records_are_listed_kept_and_generated(tmp_path: Path) -> None:
    def records(*options: object) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(run("records", *options, "--data-dir", tmp_path, "--json").stdout)
        return found

    file = tmp_path / "mine.csv"
    file.write_text("time (s), acceleration (g)\n0, 0\n0.01, 0.1\n0.02, -0.05\n0.03, 0\n")
    kept = records(file)
    assert kept["name"] == "mine"
    listed = run("records", "--data-dir", tmp_path).stdout
    assert "loma-prieta-000" in listed
    assert kept["id"] in listed
    assert records("--kanai-tajimi", "4", "--duration-s", "15")["duration_s"] == pytest.approx(15.0, abs=0.1)
    sweep = "{sweep: {start_hz: 2, stop_hz: 3, rate_hz_per_s: 0.1, base_amplitude_m: 0.001}}"
    swept = records("--generate", sweep, "--name", "run-up")
    assert (swept["name"], swept["duration_s"]) == ("run-up", pytest.approx(10.0))
    definition = tmp_path / "drop.yaml"
    definition.write_text("shock: {shape: half_sine, peak_g: 5, duration_ms: 11, rest_s: 1}\n")
    shocked = records("--generate", definition)
    dampers = run("earthquake", "--generate", definition, "--data-dir", tmp_path, "--json").stdout
    assert json.loads(dampers)["record"]["digest"] == shocked["digest"]


def test_a_record_whose_base_drifts_away_is_stored_and_asked_about(tmp_path: Path) -> None:
    file = tmp_path / "offset.dat"
    rows = (f"{0.01 * k:.2f}, {0.02 + 0.1 * (-1) ** k}" for k in range(6001))
    file.write_text("\n".join(["time (s), acc (g)", *rows, ""]))
    stored, doubt = run("records", file, "--data-dir", tmp_path).stdout.splitlines()
    assert "6001 samples at 0.01 s" in stored
    # 0.02 g over 60 s
    assert "moves its base by 353 m" in doubt


def test_a_suite_is_run_and_told_like_any_study(tmp_path: Path) -> None:
    file = tmp_path / "suite.yaml"
    file.write_text(
        "name: dampers\nrecords: [northridge]\naxes: {clearance_m: [0.001, 0.004], friction_force_n: [0.05, 0.2]}\n"
    )
    data = ("--data-dir", tmp_path)
    record = json.loads(run("run", file, "--json", *data).stdout)
    assert (record["state"], record["points_done"]) == ("done", 4)
    assert "northridge-090" in run("show", "dampers", *data).stdout
    best = json.loads(run("optimum", "dampers", "--json", *data).stdout)["designs"]
    assert f"d = {best[0]['clearance_m'] * 1e3:g} mm" in run("optimum", "dampers", *data).stdout
    assert "d [mm]" in run("map", "dampers", "--at", "record=northridge", "--details", *data).stdout
    for question in ("optimum", "map"):
        run(question, "dampers", "-o", tmp_path / f"{question}.png", *data)
        assert (tmp_path / f"{question}.png").read_bytes().startswith(b"\x89PNG")
    # what it cannot be asked is refused under the option's name
    assert "--metric" in run("optimum", "dampers", "--exclude-locked", *data, status=2).stderr


def test_what_is_printed_of_a_comparison_is_its_answer_in_millimetres(tmp_path: Path) -> None:
    asked = ("earthquake", "el-centro", "--case", "pid", "--starts", "4", "--data-dir", tmp_path)
    answer = json.loads(run(*asked, "--json").stdout)
    short, _, detailed = run(*asked, "--details").stdout.partition("\n\n")
    assert len(short.splitlines()) <= 12
    _, structure, _, row, sensitive, _ = detailed.splitlines()
    assert f"d = {1e3 * answer['design']['clearance_m']:g} mm" in structure
    case = answer["cases"]["pid"]
    lengths = [case[f"{each}_displacement_m"] for each in ("peak_relative", "rms_relative", "peak_absolute")]
    assert row.split()[1:4] == [f"{1e3 * each:.4g}" for each in lengths]
    over = case["spread"]
    assert over["sensitive"]
    assert f"{1e3 * over['peak_relative_displacement_m']['highest']:.6g} mm" in sensitive
    assert case["energy_residual"] < ROUNDING
    run(*asked, "-o", tmp_path / "histories.png")
    assert (tmp_path / "histories.png").read_bytes().startswith(b"\x89PNG")
    run(*asked, "-o", tmp_path / "table.csv")
    names, values = (row.split(",") for row in (tmp_path / "table.csv").read_text().splitlines())
    peak = float(values[names.index("peak_relative_displacement_m")])
    assert peak == pytest.approx(case["peak_relative_displacement_m"], rel=1e-15)


def test_a_large_number_of_two_digits_has_no_exponent() -> None:
    assert [two_digits(each) for each in (0.123, 8.77, 877.0, 8.77e9)] == [
        "0.12",
        "8.8",
        "880",
        "8,800,000,000",
    ]


def test_a_fragility_curve_is_printed_in_the_units_of_its_result(tmp_path: Path) -> None:
    (tmp_path / "suite.yaml").write_text(
        "name: cavity\nrecords: [northridge]\naxes: {scale: [0.5, 2], clearance_m: 0.005, friction_force_n: 0.2}\n"
    )
    data = ("--data-dir", tmp_path / "data")
    run("run", tmp_path / "suite.yaml", *data)
    asked = ("fragility", "cavity", "--threshold", "0.005", *data)
    short, _, detailed = run(*asked, "--details").stdout.partition("\n\n")
    _, head, *rows = detailed.splitlines()
    assert "5 mm" in short
    assert all(f"{name} [mm]" in head for name in ("mean", "rms", "quantile", "highest"))
    highest = json.loads(run(*asked, "--json").stdout)["highest"]
    printed = [row.split() for row in rows]
    assert [(row[0], row[-1]) for row in printed] == [
        (scale, f"{1e3 * each:.6g}") for scale, each in zip(("0.5", "2"), highest, strict=True)
    ]
