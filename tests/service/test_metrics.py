"""The numbers for a monitor: every line as the format has it, and true."""

import json
import logging
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import httpx
import psutil
import pytest
import yaml

from damperlab.service.logs import JsonLines
from damperlab.service.own_process import own_process
from damperlab.service.traffic import Traffic

SAMPLE = r'^(damperlab|process)_[a-z_]+(\{[a-z]+="[^"\\\n]*"(,[a-z]+="[^"\\\n]*")*\})? [0-9.e+-]+$'

RULES = Path(__file__).parents[2] / "deploy" / "alerts.yaml"


def _read(client: httpx.Client) -> dict[str, float]:
    answer = client.get("/metrics").raise_for_status()
    assert answer.headers["content-type"] == "text/plain; version=0.0.4; charset=utf-8"
    assert answer.text.endswith("\n")
    samples = [line for line in answer.text.splitlines() if not line.startswith("#")]
    assert all(re.match(SAMPLE, line) for line in samples)
    return {name: float(value) for name, _, value in (line.rpartition(" ") for line in samples)}


def test_a_monitor_reads_studies_points_and_requests(client: httpx.Client, curve: dict[str, Any]) -> None:
    before = _read(client)
    assert before['damperlab_studies{state="done"}'] >= 1
    assert before["damperlab_points_done"] >= curve["points_total"]
    assert before["damperlab_cluster_trouble"] == 0
    assert before["damperlab_blocks_left"] >= 0
    for _ in range(3):
        assert client.get("/api/v1/studies/nosuchstudy0").status_code == 404
    client.request("BREW", "/metrics")
    after = _read(client)
    missed = 'damperlab_requests_total{method="GET",status="404"}'
    assert after[missed] == before.get(missed, 0) + 3
    assert after["damperlab_request_seconds_total"] > before["damperlab_request_seconds_total"]
    assert not any("BREW" in name for name in after)


def test_durations_are_counted_by_the_routes_template_and_add_up(client: httpx.Client) -> None:
    for number in range(4):
        client.get(f"/api/v1/studies/nosuchstudy{number}")
    told = _read(client)
    # none of what a client sent is a label
    assert not any("nosuchstudy" in name for name in told)
    labels = 'method="GET",route="/api/v1/studies/{study_id}"'
    name = "damperlab_request_duration_seconds"
    within = [value for key, value in told.items() if key.startswith(f"{name}_bucket{{{labels},le=")]
    assert within == sorted(within)
    assert within[-1] == told[f"{name}_count{{{labels}}}"] >= 4
    assert told[f"{name}_sum{{{labels}}}"] > 0.0
    everything = sum(value for key, value in told.items() if key.startswith(f"{name}_count"))
    answered = sum(value for key, value in told.items() if key.startswith("damperlab_requests_total"))
    assert everything == answered


def test_durations_fall_into_the_class_that_holds_them() -> None:
    traffic = Traffic()
    for seconds in (0.001, 0.005, 0.3, 1000.0):
        traffic.add("GET", 200, seconds, "/a")
    _, durations = traffic.read()
    assert durations["GET", "/a"].within == (2, 2, 2, 3, 3, 3, 3, 4)
    assert durations["GET", "/a"].seconds == pytest.approx(1000.306, rel=1e-15)


def test_process_is_told_as_the_system_tells_it() -> None:
    told = {name: value for name, (_, _, value) in own_process().items()}
    one = psutil.Process()
    with one.oneshot():
        # the interpreter may get some pages, and a file, between the two looks
        assert told["process_resident_memory_bytes"] == pytest.approx(one.memory_info().rss, rel=0.1)
        assert told["process_cpu_seconds_total"] == pytest.approx(sum(one.cpu_times()[:2]), abs=0.5)
        assert abs(told["process_open_fds"] - one.num_fds()) <= 2
        assert abs(told["process_start_time_seconds"] - one.create_time()) < 600.0


def test_rules_for_alerts_are_rules() -> None:
    promtool = shutil.which("promtool")
    if promtool is None:
        pytest.skip("no promtool here: `apt-get install prometheus` brings it")
    subprocess.run([promtool, "check", "rules", RULES], check=True)


def test_alerts_ask_for_what_the_service_tells(client: httpx.Client, curve: dict[str, Any]) -> None:
    told = {name.partition("{")[0] for name in _read(client)}
    assert {"damperlab_workers", "damperlab_blocks_in_flight", "damperlab_block_retries_total"} <= told
    rules = yaml.safe_load(RULES.read_text())
    asked = [rule["expr"] for group in rules["groups"] for rule in group["rules"]]
    assert len(asked) >= 5
    for expression in asked:
        names = re.findall(r"damperlab_[a-z_]+", expression)
        assert names
        assert set(names) <= told, expression


def test_log_lines_are_json_with_ids_of_their_own() -> None:
    record = logging.LogRecord(
        "damperlab.worker.run.runner", logging.WARNING, "f", 1, "study %s: %s", (), None
    )
    record.args = ("0123456789ab", 'worker tls://h:1 is left out: it "lies"')
    told = json.loads(JsonLines().format(record))
    assert (told["study"], told["worker"], told["level"]) == ("0123456789ab", "tls://h:1", "warning")
    assert told["message"].endswith('"lies"')
    assert "block" not in told
    record.args = ("0123456789ab", "block 17 was not computed by worker tcp://h:1: ValueError: no")
    told = json.loads(JsonLines().format(record))
    assert (told["study"], told["block"], told["worker"]) == ("0123456789ab", "17", "tcp://h:1")
    access = logging.LogRecord(
        "damperlab.access", logging.INFO, "f", 1, "GET / 200 in 1.0 ms [abc]", (), None
    )
    assert json.loads(JsonLines().format(access))["request"] == "abc"
