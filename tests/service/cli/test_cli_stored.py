import csv
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.service.cli.commands import run

from damperlab.studies.store.store import Store
from damperlab.studies.variables import DIMENSIONS, STANDARD

Stored = tuple[Path, dict[str, Any]]
PNG = b"\x89PNG\r\n\x1a\n"


def transmissibility(r: float, zeta: float = 0.0038) -> float:
    """X/Z of the bare structure, model equation; exact."""
    return math.sqrt((1 + (2 * zeta * r) ** 2) / ((1 - r**2) ** 2 + (2 * zeta * r) ** 2))


def test_run_prints_the_record_that_the_store_holds(stored: Stored) -> None:
    data_dir, record = stored
    store = Store.open(data_dir)
    assert record == store.find(record["id"]).document()
    store.close()
    assert record["state"] == "done"
    assert record["points_done"] == record["points_total"] == 22


def test_a_study_that_is_done_is_not_computed_again(stored: Stored, linear_study: Path) -> None:
    data_dir, record = stored
    again = run("run", linear_study, "--data-dir", data_dir, "--json", "--scheduler", "tcp://127.0.0.1:1")
    # No scheduler answers at that address: had a cluster been wanted, the run would have failed.
    assert json.loads(again.stdout) == record
    assert "nothing was computed" in again.stderr


def test_a_study_is_found_by_the_start_of_its_id_and_by_its_name(stored: Stored) -> None:
    data_dir, record = stored
    for name in (record["id"][:5], "bare structure"):
        assert json.loads(run("show", name, "--data-dir", data_dir, "--json").stdout) == record
    listed = json.loads(run("studies", "--data-dir", data_dir, "--json").stdout)
    assert [entry["id"] for entry in listed["studies"]] == [record["id"]]
    assert listed["cursor"] is None
    assert record["id"] in run("studies", "--data-dir", data_dir).stdout
    text = run("show", record["id"], "--data-dir", data_dir).stdout
    assert "22 of 22" in text
    assert "0.5 to 1.5, 11 values" in text


def test_tables_of_a_study_in_units_are_in_millimetres_and_hertz(tmp_path: Path) -> None:
    base, hertz = 0.002, 8.0
    study = {
        "name": "in units",
        "damping_ratio": 0.05,
        "axes": {
            "clearance_ratio": [3.0],
            "friction_ratio": [0.0],
            "restitution": [0.5],
            "mass_ratio": [0.0],
        },
        "physical": {
            "natural_frequency_hz": hertz,
            "base_amplitude_m": base,
            "excitation_frequency_hz": [6.0, 9.0],
        },
    }
    file = tmp_path / "study.json"
    file.write_text(json.dumps(study))
    data = ("--data-dir", tmp_path / "data")
    run("run", file, *data)
    amplitudes = {f: 1e3 * base * transmissibility(f / hertz, 0.05) for f in (6.0, 9.0)}
    said, head, *rows = run("response", "in units", *data).stdout.splitlines()
    assert "amplitude X in mm." in said
    assert "X/Z" not in said + head
    assert head.startswith("excitation frequency f [Hz]  amplitude [mm]")
    for row, (f, amplitude) in zip(rows, amplitudes.items(), strict=True):
        assert row.split()[:2] == [f"{f:g}", f"{amplitude:.6g}"]
    map_ = (
        run("map", "in units", "--x", "clearance_ratio", "--y", "frequency_ratio", "--details", *data)
        .stdout.partition("\n\n")[2]
        .splitlines()
    )
    assert map_[1].split() == ["f", "[Hz]", "\\", "d", "[mm]", "6"]
    assert [line.split() for line in map_[2:]] == [
        [f"{f:g}", f"{amplitudes[f]:.6g}"] for f in (9.0, 6.0)
    ]  # upwards
    tmd = (
        run("tmd", "in units", "--mass-ratio", "0.1", "--details", *data)
        .stdout.partition("\n\n")[2]
        .splitlines()
    )
    assert tmd[1].split("  ")[:2] == ["excitation frequency f [Hz]", "hybrid [mm]"]
    for row, (f, amplitude) in zip(tmd[2:], amplitudes.items(), strict=True):
        assert row.split()[:2] == [f"{f:g}", f"{amplitude:.6g}"]


def test_a_response_is_the_transmissibility(stored: Stored, tmp_path: Path) -> None:
    data_dir, record = stored
    asked = ["response", record["id"], "--at", "friction_ratio=0.1", "--data-dir", data_dir]
    document = json.loads(run(*asked, "--json").stdout)
    assert document["at"]["friction_ratio"] == 0.0
    assert "nearest" in document["note"]
    expected = [transmissibility(r) for r in document["frequency_ratio"]]
    np.testing.assert_allclose(document["values"], expected, rtol=1e-9)
    assert "131.583" in run(*asked).stdout
    table = tmp_path / "new folder" / "response.csv"
    run(*asked, "-o", table)
    with table.open(newline="") as file:
        found = [float(row["amplitude_ratio"]) for row in csv.DictReader(file)]
    assert found == document["values"]


def test_a_map_has_a_row_for_each_y(stored: Stored) -> None:
    data_dir, record = stored
    document = json.loads(run("map", record["id"], "--data-dir", data_dir, "--json").stdout)
    assert (document["x_dimension"], document["y_dimension"]) == ("friction_ratio", "frequency_ratio")
    assert len(document["values"]) == len(document["y"]) == 11
    resonance = document["y"].index(1.0)
    assert document["values"][resonance][0] == pytest.approx(transmissibility(1.0), rel=1e-9)
    kinds = [
        document["meanings"]["response_class"][str(code)] for code in document["response_class"][resonance]
    ]
    assert kinds == ["linear", "locked"]
    short, _, detailed = run("map", record["id"], "--details", "--data-dir", data_dir).stdout.partition(
        "\n\n"
    )
    assert f"{transmissibility(1.0):.3g}" in short
    text = detailed.splitlines()
    # y runs upwards, as in a figure: its largest value is the first row below the head.
    assert text[1].split() == ["r", "\\", "γ_F", "0", "2"]
    assert text[2].split()[0] == "1.5"
    assert text[-1].split()[0] == "0.5"


def test_the_optimum_in_words_leaves_locked_designs_out_on_request(stored: Stored) -> None:
    data_dir, record = stored
    asked = ["optimum", record["id"], "--data-dir", data_dir, "--objective", "resonance"]
    assert "γ_F = 2" in run(*asked).stdout
    free = run(*asked, "--exclude-locked").stdout
    assert "γ_F = 0" in free
    assert "132" in free
    designs = json.loads(run(*asked, "--json", "--top", "1").stdout)["designs"]
    assert [design["friction_ratio"] for design in designs] == [2.0]


@pytest.mark.parametrize("question", ["map", "response", "optimum"])
def test_a_question_is_answered_with_a_figure(stored: Stored, tmp_path: Path, question: str) -> None:
    data_dir, record = stored
    figure = tmp_path / "figure.png"
    ended = run(question, record["id"], "--data-dir", data_dir, "-o", figure)
    assert figure.read_bytes().startswith(PNG)
    assert ended.stdout == ""
    drawing = tmp_path / "figure.svg"
    run(question, record["id"], "--data-dir", data_dir, "-o", drawing)
    assert "<svg" in drawing.read_text()


def test_what_cannot_be_asked_exits_2(stored: Stored) -> None:
    data_dir, record = stored
    ended = run("map", record["id"], "--metric", "amplitude", "--data-dir", data_dir, status=2)
    assert "amplitude_ratio" in ended.stderr


def test_exports_hold_the_cube(stored: Stored, tmp_path: Path) -> None:
    data_dir, record = stored
    store = Store.open(data_dir)
    cube = store.cube(record["id"]).load()
    store.close()
    table, netcdf = tmp_path / "cube.csv", tmp_path / "cube.nc"
    run("export", record["id"], "--format", "csv", "-o", table, "--data-dir", data_dir)
    run("export", record["id"], "--format", "netcdf", "-o", netcdf, "--data-dir", data_dir)
    with table.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == [*DIMENSIONS, *STANDARD]
    np.testing.assert_array_equal(
        [float(row["amplitude_ratio"]) for row in rows], cube.amplitude_ratio.values.ravel()
    )
    with xr.open_dataset(netcdf, engine="h5netcdf") as opened:
        np.testing.assert_array_equal(opened.amplitude_ratio.values, cube.amplitude_ratio.values)
    assert {path.name for path in tmp_path.iterdir()} == {"cube.csv", "cube.nc"}


def test_a_study_that_is_done_cannot_be_cancelled(stored: Stored) -> None:
    data_dir, record = stored
    assert "done" in run("cancel", record["id"], "--data-dir", data_dir, status=1).stderr


def test_delete_asks_first(stored: Stored, tmp_path: Path) -> None:
    study = tmp_path / "other.yaml"
    study.write_text("{name: other, particle: false, axes: {friction_ratio: 0, frequency_ratio: [0.5, 2]}}")
    run("run", study, "--data-dir", tmp_path)
    run("delete", "other", "--data-dir", tmp_path, status=1)  # nobody is there to answer
    run("show", "other", "--data-dir", tmp_path)
    run("delete", "other", "--yes", "--data-dir", tmp_path)
    run("show", "other", "--data-dir", tmp_path, status=2)
    assert [left.name for left in (tmp_path / "cubes").iterdir()] == ["damperlab.json"]  # the owner marker


def test_what_is_said_of_dampers_over_base_amplitudes_is_in_units(tmp_path: Path) -> None:
    study = {
        "name": "ray",
        "physical": {
            "mass_kg": 2.0,
            "natural_frequency_hz": 2.5,
            "base_amplitude_m": [0.001, 0.002],
            "particle_mass_kg": 0.2,
            "clearance_m": [0.005, 0.01],
            "friction_force_n": 0.3,
            "excitation_frequency_hz": [2.4, 2.5],
        },
    }
    (tmp_path / "ray.json").write_text(json.dumps(study))
    run("run", tmp_path / "ray.json", "--data-dir", tmp_path)

    def printed(*question: str) -> str:
        return run(*question, "--data-dir", tmp_path).stdout

    best = json.loads(printed("optimum", "ray", "--json"))["designs"][0]
    said = printed("optimum", "ray")
    assert f"d = {1e3 * best['clearance_m']:g} mm" in said
    assert f"At worst {1e3 * best['value']:.3g} mm" in said
    assert f"Z = {1e3 * best['base_amplitude_m']:g} mm" in said
    assert f"f = {2.5 * best['frequency_ratio']:.3g} Hz" in said
    curve = printed("response", "ray", "--clearance-m", "0.005", "--base-amplitude-m", "0.002")
    assert "excitation frequency f [Hz]  amplitude [mm]  amplitude_error [mm]" in curve
    shown = printed("map", "ray", "--x", "clearance_m", "--y", "base_amplitude_m", "--details")
    assert "Z [mm] \\ d [mm]" in shown
    everything = said + curve + shown + printed("importance", "ray")
    ratios = (
        "X/Z",
        "mass_ratio",
        "clearance_ratio",
        "friction_ratio",
        "frequency_ratio =",
        "amplitude_ratio",
    )
    assert not [ratio for ratio in ratios if ratio in everything]


@pytest.mark.parametrize("names", [False, True])
def test_a_file_names_user_and_host_where_that_is_asked_for(
    stored: Stored, tmp_path: Path, names: bool
) -> None:
    data_dir, record = stored
    file = tmp_path / "cube.nc"
    run("export", record["id"], "-o", file, "--data-dir", data_dir, *(["--names"] if names else []))
    told = json.loads(xr.open_dataset(file, engine="h5netcdf").attrs["provenance"])
    assert {"host", "user"} & told.keys() == ({"host", "user"} if names else set())
    assert told["solver_version"] == record["provenance"]["solver_version"]
