"""The numbers for a monitor: every line as the format has it, and true."""

import re
from typing import Any

import httpx

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
