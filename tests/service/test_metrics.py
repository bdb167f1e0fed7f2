"""The numbers for a monitor: every line as the format has it, and true."""

import json
import logging
import re
from pathlib import Path
from typing import Any

import httpx
import yaml

from damperlab.service.logs import JsonLines

SAMPLE = r'^damperlab_[a-z_]+(\{[a-z]+="[^"\\\n]*"(,[a-z]+="[^"\\\n]*")*\})? [0-9.e+-]+$'


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
    for _ in range(3):
        assert client.get("/api/v1/studies/nosuchstudy0").status_code == 404
    client.request("BREW", "/metrics")
    after = _read(client)
    missed = 'damperlab_requests_total{method="GET",status="404"}'
    assert after[missed] == before.get(missed, 0) + 3
    assert after["damperlab_request_seconds_total"] > before["damperlab_request_seconds_total"]
    assert not any("BREW" in name for name in after)


def test_alerts_ask_for_what_the_service_tells(client: httpx.Client, curve: dict[str, Any]) -> None:
    told = {name.partition("{")[0] for name in _read(client)}
    assert {"damperlab_workers", "damperlab_blocks_in_flight", "damperlab_block_retries_total"} <= told
    rules = yaml.safe_load((Path(__file__).parents[2] / "deploy" / "alerts.yaml").read_text())
    asked = [rule["expr"] for group in rules["groups"] for rule in group["rules"]]
    assert len(asked) >= 5
    for expression in asked:
        names = re.findall(r"damperlab_[a-z_]+", expression)
        assert names
        assert set(names) <= told, expression


def test_log_lines_are_json_with_ids_of_their_own() -> None:
    record = logging.LogRecord("damperlab.worker.runner", logging.WARNING, "f", 1, "study %s: %s", (), None)
    record.args = ("0123456789ab", 'worker tls://h:1 is left out: it "lies"')
    told = json.loads(JsonLines().format(record))
    assert (told["study"], told["worker"], told["level"]) == ("0123456789ab", "tls://h:1", "warning")
    assert told["message"].endswith('"lies"')
    access = logging.LogRecord(
        "damperlab.access", logging.INFO, "f", 1, "GET / 200 in 1.0 ms [abc]", (), None
    )
    assert json.loads(JsonLines().format(access))["request"] == "abc"
