import json
from pathlib import Path
from typing import Any

import pytest
import xarray as xr
from tests.oracles.transmissibility import absolute_amplitude
from tests.service.cli.commands import run

from damperlab.studies.store.store import Store

Stored = tuple[Path, dict[str, Any]]


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
    amplitudes = {f: 1e3 * base * absolute_amplitude(0.05, f / hertz) for f in (6.0, 9.0)}
    said, head, *rows = (
        run("response", "in units", "--details", *data).stdout.partition("\n\n")[2].splitlines()
    )
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


def test_a_printed_map_has_a_row_for_each_y_upwards(stored: Stored) -> None:
    """As in a figure: the largest y is the first row below the head."""
    data_dir, record = stored
    printed = run("map", record["id"], "--details", "--data-dir", data_dir).stdout
    text = printed.partition("\n\n")[2].splitlines()
    assert text[1].split() == ["r", "\\", "γ_F", "0", "2"]
    assert (text[2].split()[0], text[-1].split()[0]) == ("1.5", "0.5")


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
