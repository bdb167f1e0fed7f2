import json
import subprocess
import sys
from pathlib import Path

import pytest
from tests.service.cli.commands import run

HEAVY = (
    "numba",
    "dask",
    "distributed",
    "xarray",
    "zarr",
    "matplotlib",
    "fastapi",
    "sqlalchemy",
    "pydantic",
    "numpy",
)


def test_help_loads_none_of_the_heavy_libraries() -> None:
    program = (
        f"import sys, damperlab.service.cli.main; print([name for name in {HEAVY!r} if name in sys.modules])"
    )
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert ended.stdout.strip() == "[]"


def test_help_names_every_command() -> None:
    text = run("--help").stdout
    commands = "run resume simulate map response optimum export studies show cancel delete serve doctor"
    assert [name for name in commands.split() if f" {name} " not in text] == []


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        (["frobnicate"], "frobnicate"),
        (["show"], "ID"),
        (["run", "figure-11", "--workers", "2", "--scheduler", "tcp://127.0.0.1:1"], "--scheduler"),
        (["run", "figure-11", "--workers", "0"], "--workers"),
        (["run", "no-such-study"], "no-such-study"),
        (["map", "x", "-o", "figure.docx"], ".png, .svg, .pdf, .csv"),
        (["map", "x", "--at", "clearance_ratio"], "dimension=value"),
        (["map", "x", "--at", "clearance_ratio=wide"], "finite number"),
        (["map", "x", "--at", "clearance=1"], "clearance_ratio"),
        (["optimum", "x", "--band", "1.1,0.9"], "lo not above hi"),
        (["optimum", "x", "--band", "1"], "lo,hi"),
        (["studies", "--state", "lost"], "queued, running, done, cancelled, failed"),
        (["export", "x", "--format", "xlsx", "-o", "x"], "netcdf"),
        (["simulate", "--restitution", "1.5"], "restitution"),
        (["simulate", "--friction-ratio", "nan"], "friction_ratio"),
        (["simulate", "--method", "rk4"], "cycles"),
        (["simulate", "--cycles", "0"], "cycles"),
    ],
)
def test_bad_usage_exits_2_and_says_what_is_allowed(arguments: list[str], part: str) -> None:
    ended = run(*arguments, status=2)
    assert part in ended.stderr
    assert ended.stdout == ""


def test_every_fault_of_a_study_is_one_line_and_nothing_is_stored(tmp_path: Path) -> None:
    study = tmp_path / "bad.json"
    study.write_text(
        '{"axes": {"clearance_ratio": -1, "friction_ratio": NaN, "speed": 3}, "steady": {"max_cycles": 0}}'
    )
    data_dir = tmp_path / "data"
    ended = run("run", study, "--data-dir", data_dir, status=2)
    fields = [line.split(": ")[1] for line in ended.stderr.splitlines()]
    expected = {
        "axes.clearance_ratio",
        "axes.friction_ratio",
        "axes.speed",
        "axes.frequency_ratio",
        "steady.max_cycles",
    }
    assert set(fields) == expected
    assert len(fields) == len(expected)
    document = json.loads(run("run", study, "--data-dir", data_dir, "--json", status=2).stdout)
    assert {error["field"] for error in document["errors"]} == expected
    assert all(error["found"] and error["allowed"] and error["advice"] for error in document["errors"])
    assert not data_dir.exists()


def test_wrong_usage_with_json_is_a_problem_document() -> None:
    document = json.loads(run("show", "x", "--json", "--frobnicate", status=2).stdout)
    assert document["exit_status"] == 2
    assert "--frobnicate" in document["detail"]


def test_a_study_that_is_not_there_exits_2(tmp_path: Path) -> None:
    document = json.loads(run("show", "nobody", "--data-dir", tmp_path, "--json", status=2).stdout)
    assert document["type"].endswith(":study-not-found")
    assert "nobody" in document["detail"]


def test_a_data_folder_that_cannot_be_made_exits_1(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    ended = run("studies", "--data-dir", tmp_path / "file" / "data", status=1)
    assert str(tmp_path / "file" / "data") in ended.stderr


def test_a_dry_run_says_the_size_and_stores_nothing(tmp_path: Path, linear_study: Path) -> None:
    data_dir = tmp_path / "data"
    size = json.loads(run("run", linear_study, "--dry-run", "--data-dir", data_dir, "--json").stdout)
    assert size["points"] == 22
    assert size["blocks"] >= 1
    assert size["bytes"] > 22 * 8
    assert "22 points" in run("run", linear_study, "--dry-run", "--data-dir", data_dir).stdout
    assert not data_dir.exists()
