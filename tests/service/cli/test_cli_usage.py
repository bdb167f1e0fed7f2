import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

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


def test_the_service_begins_without_the_library_of_figures() -> None:
    program = "import sys, damperlab.service.app; print([name for name in ('matplotlib', 'weasyprint') if name in sys.modules])"
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert ended.stdout.strip() == "[]"


COMPUTING = ("numba", "dask.array", "distributed", "fastapi", "matplotlib", "xarray")


@pytest.mark.parametrize(
    ("commands", "needed"),
    [
        (["studies", "show 'bare structure'"], set()),
        (
            [
                "map 'bare structure'",
                "response 'bare structure' --at friction_ratio=0",
                "optimum 'bare structure'",
                "tmd 'bare structure' --mass-ratio 0.1",
                "precision 'bare structure'",
            ],
            {"xarray", "dask.array"},
        ),
        (["simulate --cycles 2"], {"numba"}),
        (["run STUDY"], {"numba"}),
    ],
    ids=["catalogue", "questions", "point", "study"],
)
def test_commands_load_what_they_need_alone(
    stored: tuple[Path, dict[str, Any]], linear_study: Path, commands: list[str], needed: set[str]
) -> None:
    """Commands that ask a store need no compiler, those that compute here no cluster, and none of them the service.

    xarray itself looks for Dask's arrays as soon as it is handed one.
    """
    asked = [shlex.split(each.replace("STUDY", str(linear_study))) for each in commands]
    program = (
        "import os, sys\nfrom damperlab.__main__ import main\n"
        f"os.environ['DAMPERLAB_DATA_DIR'] = {str(stored[0])!r}\n"
        f"for arguments in {asked!r}:\n"
        "    sys.argv[1:] = arguments\n"
        "    try:\n        main()\n"
        "    except SystemExit as ended:\n        assert not ended.code, (arguments, ended.code)\n"
        f"print('loaded', *(name for name in {COMPUTING!r} if name in sys.modules), file=sys.stderr)"
    )
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    _, *loaded = ended.stderr.splitlines()[-1].split()
    assert set(loaded) <= needed


def test_a_command_ends_without_looking_through_what_it_loaded() -> None:
    program = (
        "import atexit, gc, sys\nfrom damperlab.__main__ import main\n"
        "atexit.register(lambda: print(gc.get_freeze_count(), len(gc.get_objects())))\n"
        "sys.argv[1:] = ['--version']\nmain()"
    )
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    kept, left = map(int, ended.stdout.splitlines()[-1].split())
    assert kept > 10 * left


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
        (
            ["run", "figure-11", "--scheduler", "foo"],
            "`--scheduler` must be an address such as tcp://HOST:8786",
        ),
        (["run", "figure-11", "--scheduler", "tcp://host"], "Name the host and its port."),
        (
            ["serve", "--scheduler", "tcp://host:99999"],
            "`--scheduler` must be an address such as tcp://HOST:8786",
        ),
        (["worker", "foo"], "`ADDRESS` must be an address such as tcp://HOST:8786 or tls://HOST:8786"),
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
        (["simulate", "--friction-ratio", "nan"], "--friction-ratio"),
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
    fields = [line.split("`")[1] for line in ended.stderr.splitlines()]
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
    # every line is made of sentences, and what programs get is what people read
    for line, error in zip(ended.stderr.splitlines(), document["errors"], strict=True):
        assert line.startswith(f"damperlab: {error['message']} ")
        assert re.fullmatch(r"damperlab: `[\w.]+` (is|must) .+\. [A-Z].*[.?]", line), line
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


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        (["optimun", "x"], "Did you mean 'optimum'?"),
        (["simulate", "--clerance-ratio", "3"], "--clearance-ratio"),
        (["map", "x", "--at", "clearence_ratio=3"], "Did you mean clearance_ratio?"),
        (["studies", "--state", "dne"], "Did you mean done?"),
        (["optimum", "x", "--objective", "peek"], "Did you mean peak?"),
        (["export", "x", "--format", "cvs", "-o", "x"], "Did you mean csv?"),
        (["run", "figur-11"], "Did you mean figure-11?"),
        (["earthquake", "--at", "clearanc_m=1"], "Did you mean clearance_m?"),
    ],
)
def test_a_mistyped_name_is_answered_with_the_nearest_one(arguments: list[str], part: str) -> None:
    assert part in run(*arguments, status=2).stderr


def test_a_mistyped_study_is_answered_with_the_nearest_stored_name(
    stored: tuple[Path, dict[str, Any]],
) -> None:
    data_dir, _ = stored
    ended = run("show", "bare structur", "--data-dir", data_dir, status=2)
    assert "Did you mean bare structure?" in ended.stderr


def test_a_design_is_named_in_two_ways_with_one_meaning(stored: tuple[Path, dict[str, Any]]) -> None:
    data_dir, record = stored
    long = run("response", record["id"], "--data-dir", data_dir, "--at", "friction_ratio=2", "--json")
    short = run("response", record["id"], "--data-dir", data_dir, "--friction-ratio", "2", "--json")
    assert json.loads(long.stdout) == json.loads(short.stdout)
    point = ["simulate", "--no-particle", "--cycles", "2", "--method", "rk4", "--json"]
    long, short = run(*point, "--at", "frequency_ratio=2"), run(*point, "--frequency-ratio", "2")
    assert json.loads(long.stdout)["state"] == json.loads(short.stdout)["state"]
    twice = run(*point, "--at", "frequency_ratio=2", "--frequency-ratio", "3", status=2)
    assert "--frequency-ratio" in json.loads(twice.stdout)["detail"]


def test_a_contact_without_its_time_is_told_which_option_to_add() -> None:
    for model in ("dwell", "compliant"):
        assert "Add --contact-time" in run("simulate", "--contact", model, status=2).stderr


@pytest.mark.parametrize(
    ("suffix", "head"), [(".nc", b"\x89HDF"), (".csv", b"damping_ratio"), (".parquet", b"PAR1")]
)
def test_the_name_of_the_file_says_the_format(
    stored: tuple[Path, dict[str, Any]], tmp_path: Path, suffix: str, head: bytes
) -> None:
    data_dir, record = stored
    run("export", record["id"], "--data-dir", data_dir, "-o", tmp_path / f"f{suffix}")
    assert (tmp_path / f"f{suffix}").read_bytes().startswith(head)
    refused = run("export", record["id"], "--data-dir", data_dir, "-o", tmp_path / "f.dat", status=2)
    assert "--format" in refused.stderr


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_every_shell_completes_commands(shell: str) -> None:
    asked = {
        "bash": {"COMP_WORDS": "damperlab optim", "COMP_CWORD": "1"},
        "zsh": {"_TYPER_COMPLETE_ARGS": "damperlab optim"},
        "fish": {"_TYPER_COMPLETE_ARGS": "damperlab optim", "_TYPER_COMPLETE_FISH_ACTION": "get-args"},
    }[shell]
    ended = subprocess.run(
        [sys.executable, "-m", "damperlab"],
        env={**os.environ, **asked, "_DAMPERLAB_COMPLETE": f"complete_{shell}"},
        capture_output=True,
        text=True,
    )
    assert "optimum" in ended.stdout, ended.stderr
