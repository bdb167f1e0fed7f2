"""What a user meets before a command computes: help, completion, libraries, spelling, folders."""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from tests.service.cli.commands import END_SECONDS, command, environment, run
from typer.main import get_command

from damperlab.service.cli.main import GONE, RENAMED, app
from damperlab.service.cli.store import warn_of_unknown_variables


def test_a_variable_that_is_no_setting_is_told_with_the_one_that_was_meant(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("DAMPERLAB_KYE", "x")
    monkeypatch.setenv("DAMPERLAB_XYZZY", "x")
    warn_of_unknown_variables()
    meant, none = capsys.readouterr().err.splitlines()
    assert "DAMPERLAB_KEY?" in meant
    assert "DAMPERLAB_XYZZY" in none
    assert "mean" not in none


@pytest.mark.parametrize(
    "line", ["race study --dry-run", "importance study", "robust study --amplitudes 1,2"]
)
def test_a_command_that_is_gone_says_what_to_do_instead(line: str) -> None:
    name, *more = line.split()
    said = run(name, *more, status=2)
    assert said.stdout == ""
    assert said.stderr.startswith(f"damperlab: there is no `{name}` any more. ")
    assert GONE[name] in said.stderr
    assert name not in get_command(app).commands  # type: ignore[attr-defined]
    # each command that is named in its place exists
    for instead in re.findall(r"`damperlab (\w+)`", GONE[name]):
        assert instead in get_command(app).commands  # type: ignore[attr-defined]


@pytest.mark.parametrize("old", RENAMED)
def test_a_command_by_its_old_name_works_and_says_the_new_one(old: str) -> None:
    said = run(old, "--help")
    assert f"damperlab {RENAMED[old].partition(' --')[0]}" in said.stdout
    assert (
        said.stderr == f"damperlab: `{old}` is now `{RENAMED[old]}`; the old name works until version 0.3.\n"
    )
    assert old not in get_command(app).commands  # type: ignore[attr-defined]


COMPUTING = ("numba", "dask.array", "distributed", "fastapi", "matplotlib", "xarray")


@pytest.mark.parametrize(
    ("commands", "needed"),
    [
        pytest.param(["studies", "show 'bare structure'"], set(), marks=pytest.mark.night),
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
        pytest.param(["simulate --cycles 2"], {"numba"}, marks=pytest.mark.night),
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
        "sys.argv[1:] = ['--help']\nmain()"
    )
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    kept, left = map(int, ended.stdout.splitlines()[-1].split())
    assert kept > 10 * left


def test_a_dry_run_says_the_size_and_stores_nothing(tmp_path: Path, linear_study: Path) -> None:
    data_dir = tmp_path / "data"
    size = json.loads(run("run", linear_study, "--dry-run", "--data-dir", data_dir, "--json").stdout)
    assert size["points"] == 22
    assert size["bytes"] > 22 * 8
    assert "22 points" in run("run", linear_study, "--dry-run", "--data-dir", data_dir).stdout
    assert not data_dir.exists()


def test_a_dry_run_says_what_is_stored(stored: tuple[Path, dict[str, Any]], linear_study: Path) -> None:
    data_dir, record = stored
    size = json.loads(run("run", linear_study, "--dry-run", "--data-dir", data_dir, "--json").stdout)
    assert size["points_stored"] == record["points_done"] == 22
    said = run("run", linear_study, "--dry-run", "--data-dir", data_dir).stdout
    assert "Already stored: 22 of 22 points." in said


def test_a_design_is_named_in_two_ways_with_one_meaning(stored: tuple[Path, dict[str, Any]]) -> None:
    data_dir, record = stored
    long = run("response", record["id"], "--data-dir", data_dir, "--at", "friction_ratio=2", "--json")
    short = run("response", record["id"], "--data-dir", data_dir, "--friction-ratio", "2", "--json")
    assert json.loads(long.stdout) == json.loads(short.stdout)
    point = ["simulate", "--no-particle", "--cycles", "2", "--method", "rk4", "--json"]
    long, short = run(*point, "--at", "frequency_ratio=2"), run(*point, "--frequency-ratio", "2")
    assert json.loads(long.stdout)["state"] == json.loads(short.stdout)["state"]


@pytest.mark.parametrize("more", [(), ("--cycles", "2", "--method", "rk4"), ("--starts", "2")])
def test_a_simulated_point_is_answered_in_a_few_lines(more: tuple[str, ...]) -> None:
    point = ["simulate", "--clearance-ratio", "10", *more]
    known = json.loads(run(*point, "--json").stdout)["metrics"]
    short = run(*point).stdout.splitlines()
    assert len(short) <= 12
    assert f"{known['amplitude_ratio']:.4g}" in short[1]
    assert any(line.startswith("amplitude_ratio") for line in run(*point, "--details").stdout.splitlines())


def test_a_simulated_point_that_friction_locks_is_said_to_be_clamped_first() -> None:
    first = run("simulate", "--no-particle", "--friction-ratio", "3").stdout.splitlines()[0]
    assert first == "Friction clamps the structure to its base: nothing is damped."


def test_a_shell_completes_commands() -> None:
    asked = {"COMP_WORDS": "damperlab optim", "COMP_CWORD": "1", "_DAMPERLAB_COMPLETE": "complete_bash"}
    command = [sys.executable, "-m", "damperlab"]
    ended = subprocess.run(command, env=os.environ | asked, capture_output=True, text=True, check=False)
    assert "optimum" in ended.stdout, ended.stderr


def test_a_tag_that_no_study_has_is_not_answered_with_a_study_to_compute(tmp_path: Path) -> None:
    assert "figure-11" in run("studies", "--data-dir", tmp_path).stderr
    assert "figure-11" not in run("studies", "--tag", "mine", "--data-dir", tmp_path).stderr


def test_doctor_tries_everything_but_the_cluster(tmp_path: Path) -> None:
    report = json.loads(run("doctor", "--no-cluster", "--data-dir", tmp_path / "data", "--json").stdout)
    assert report["ok"] is True
    found = {check["name"]: check["found"] for check in report["checks"]}
    assert list(found) == ["versions", "cores", "closed form", "kernels", "store"]
    assert "131.5827473" in found["closed form"]
    assert str(tmp_path / "data") in found["store"]


def test_doctor_names_what_does_not_work_and_exits_1(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    where = ("--scheduler", "tcp://127.0.0.1:1", "--data-dir", tmp_path / "file")
    report = json.loads(run("doctor", *where, "--json", status=1).stdout)
    assert report["ok"] is False
    assert [check["name"] for check in report["checks"] if not check["ok"]] == ["store", "cluster"]


# Root may write where permissions say no; without two of its capabilities it is held to them like everybody else.
AS_A_USER = ["setpriv", "--bounding-set", "-dac_override,-dac_read_search"] if os.geteuid() == 0 else []

pytestmark = pytest.mark.skipif(
    bool(AS_A_USER) and shutil.which("setpriv") is None, reason="root, and no setpriv to lay its powers down"
)


def test_a_folder_without_permission_is_named(tmp_path: Path, linear_study: Path) -> None:
    folder = tmp_path / "data"
    folder.mkdir(mode=0o555)
    ended = subprocess.run(
        [*AS_A_USER, *command("serve", "--port", "0", "--data-dir", folder)],
        capture_output=True,
        text=True,
        stdin=subprocess.DEVNULL,
        env=environment(),
        timeout=END_SECONDS,
    )
    assert ended.returncode == 1
    assert str(folder) in ended.stderr
    assert "permissions" in ended.stderr
    assert "Traceback" not in ended.stderr
    assert list(folder.iterdir()) == []
    folder.chmod(0o755)
    run("run", linear_study, "--data-dir", folder)
