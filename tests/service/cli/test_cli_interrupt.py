"""A study that is stopped, from the keyboard or by another process, keeps what is done and can be resumed."""

import json
import os
import re
import signal
import subprocess
import time
import urllib.request
from pathlib import Path
from typing import Any

import pytest

from studies.store.record import Record
from studies.store.store import Store
from tests.service.cli.commands import END_SECONDS, LINEAR, run, start

LONG: dict[str, Any] = {
    "name": "long",
    "particle": False,
    "axes": {
        "friction_ratio": {"start": 0.05, "stop": 0.75, "num": 80},
        "frequency_ratio": {"start": 0.9, "stop": 1.1, "num": 120},
    },
}
"""Friction alone: dozens of blocks and many seconds of kernels."""


@pytest.fixture
def data_dir(tmp_path: Path) -> Path:
    (tmp_path / "long.json").write_text(json.dumps(LONG))
    return tmp_path


def wait_for_block(store: Store, running: subprocess.Popen[str], blocks: int) -> Record:
    """Wait until more than `blocks` blocks are done and the study is still on its way."""
    give_up = time.monotonic() + END_SECONDS
    while time.monotonic() < give_up and running.poll() is None:
        records = store.page(1).records
        if records and records[0].blocks_done > blocks and records[0].state == "running":
            return records[0]
        time.sleep(0.02)
    out, err = running.communicate(timeout=10) if running.poll() is not None else ("", "")
    running.kill()
    raise AssertionError(f"no block was seen to be done while the study ran\n{out}\n{err}")


def test_cancelled_elsewhere_then_interrupted_then_resumed_to_the_end(data_dir: Path) -> None:
    store = Store.open(data_dir)
    running = start("run", data_dir / "long.json", "--data-dir", data_dir, "--workers", "1")
    seen = wait_for_block(store, running, 0)
    run("cancel", seen.id, "--data-dir", data_dir)
    out, err = running.communicate(timeout=END_SECONDS)
    assert running.returncode == 1, err
    assert f"damperlab resume {seen.id}" in err
    cancelled = store.find(seen.id)
    assert cancelled.state == "cancelled"
    assert seen.blocks_done <= cancelled.blocks_done < cancelled.blocks_total

    running = start("resume", "long", "--data-dir", data_dir, "--workers", "1", "--json")
    seen = wait_for_block(store, running, cancelled.blocks_done)
    os.killpg(running.pid, signal.SIGINT)
    out, err = running.communicate(timeout=END_SECONDS)
    assert running.returncode == 1, err
    assert "Traceback" not in err
    record = json.loads(out)
    assert record["state"] == "cancelled"
    assert record["blocks_done"] > cancelled.blocks_done

    document = json.loads(run("resume", seen.id, "--data-dir", data_dir, "--json").stdout)
    assert document["state"] == "done"
    assert document["points_done"] == 80 * 120
    assert document["points_failed"] == 0
    assert (store.cube(seen.id).status >= 0).all()
    store.close()


def test_a_server_shows_what_run_stores_and_run_follows_what_a_server_computes(data_dir: Path) -> None:
    server = start("serve", "--port", "0", "--data-dir", data_dir, "--workers", "1")
    try:
        url = _address(server)
        study = json.dumps(LINEAR).encode()
        linear = data_dir / "linear.json"
        linear.write_bytes(study)
        record = json.loads(run("run", linear, "--data-dir", data_dir, "--json").stdout)
        with urllib.request.urlopen(f"{url}/api/v1/studies/{record['id']}") as shown:
            assert json.load(shown) == record

        request = urllib.request.Request(
            f"{url}/api/v1/studies",
            (data_dir / "long.json").read_bytes(),
            {"Content-Type": "application/json"},
        )
        with urllib.request.urlopen(request) as answer:
            posted = json.load(answer)
        store = Store.open(data_dir)
        seen = wait_for_block(store, server, 0)
        assert seen.id == posted["id"]
        followed = run("run", data_dir / "long.json", "--data-dir", data_dir, "--json")
        assert "another process" in followed.stderr
        assert json.loads(followed.stdout)["state"] == "done"
        store.close()
    finally:
        server.send_signal(signal.SIGINT)
        server.communicate(timeout=END_SECONDS)
    assert server.returncode == 0


def _address(server: subprocess.Popen[str]) -> str:
    assert server.stderr is not None
    for line in server.stderr:
        if found := re.search(r"http://127\.0\.0\.1:(\d+)", line):
            assert found.group(1) != "0"
            return found.group(0)
    raise AssertionError("the server ended without an address")
