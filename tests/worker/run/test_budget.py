"""A study that may take so many core hours and no more: it stops well, says so, and goes on later to the same bits."""

import json
import subprocess
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
import typer
from tests.service.cli.commands import run
from tests.worker.run_here import BLOCKS, friction_study, of_one_piece, run_here, submit

from damperlab.service.cli.options import read_time
from damperlab.studies.store.store import Store


@pytest.mark.parametrize("cores", [1, 2])
def test_study_stops_when_its_budget_is_spent_and_goes_on_to_the_same_bits(
    store: Store, monkeypatch: pytest.MonkeyPatch, cores: int
) -> None:
    """A block under way is ended: of each core one."""
    monkeypatch.setattr("damperlab.worker.run.in_this_process.core_count", lambda: cores)
    record = submit(store)
    # any block takes longer
    stopped = run_here(store, record.id, budget_seconds=1e-9)
    assert (stopped.state, stopped.blocks_done, stopped.points_failed) == ("cancelled", cores, 0)
    assert f"is spent; {cores} of {BLOCKS} blocks are kept" in (stopped.message or "")
    # of each run its own
    assert run_here(store, record.id, budget_seconds=1e-9).blocks_done == 2 * cores
    ended = run_here(store, record.id, budget_seconds=3600.0)
    assert (ended.state, ended.blocks_done, ended.message) == ("done", BLOCKS, None)
    assert of_one_piece(store, record.id, friction_study())


def test_the_command_says_what_became_of_the_budget_and_how_to_go_on(tmp_path: Path) -> None:
    study = tmp_path / "study.json"
    study.write_text(friction_study().model_dump_json(exclude_none=True))
    data = ("--data-dir", tmp_path / "data")
    ended = run("run", study, "--budget", "0", "--json", *data, status=1)
    record = json.loads(ended.stdout)
    assert (record["state"], record["points_done"]) == ("cancelled", 0)
    assert "the budget of 0 core hours is spent" in record["message"]
    assert "damperlab run" in ended.stderr
    assert json.loads(run("run", record["id"], "--budget", "1", "--json", *data).stdout)["state"] == "done"


def _run_for(seconds: float, study: Path, *data: Any) -> tuple[datetime, subprocess.CompletedProcess[str]]:
    """Run a study until so much later; on a busy machine that may be past before the command reads it, then for longer."""
    ends = datetime.now() + timedelta(seconds=seconds)
    command = ("run", study, "--until", ends.isoformat(), "--workers", "1", "--json", *data)
    ended = run(*command, status=None)
    if ended.returncode == 2 and "which is in the past" in ended.stderr and seconds < 200:
        return _run_for(4 * seconds, study, *data)
    assert ended.returncode == 1, ended.stderr
    return ends, ended


@pytest.mark.night
def test_the_command_stops_at_its_time_and_says_so(tmp_path: Path) -> None:
    axes = {
        "friction_ratio": {"start": 0.05, "stop": 0.75, "num": 1000},
        "frequency_ratio": {"start": 0.9, "stop": 1.1, "num": 1000},
    }
    study = tmp_path / "study.json"
    # hours of work
    study.write_text(json.dumps({"damping_ratio": 0.004, "particle": False, "axes": axes}))
    data = ("--data-dir", tmp_path / "data")
    ends, ended = _run_for(8, study, *data)
    record = json.loads(ended.stdout)
    assert record["state"] == "cancelled"
    assert f"it was to run until {ends:%Y-%m-%d %H:%M:%S}; {record['blocks_done']} of" in record["message"]
    assert "damperlab run" in ended.stderr
    again = run("run", record["id"], "--until", "2001-01-01", *data, status=2)
    assert "which is in the past" in again.stderr


def test_a_time_of_day_is_the_next_one() -> None:
    now = datetime.now().astimezone()
    for hours in (-1, 1):
        text = f"{now + timedelta(hours=hours):%H:%M:%S}"
        found = read_time(text)
        assert f"{found:%H:%M:%S}" == text
        # a day may have 23 or 25 hours
        assert timedelta(0) < found - now < timedelta(hours=25)
    with pytest.raises(typer.BadParameter, match="a time in the future"):
        read_time("soon")
