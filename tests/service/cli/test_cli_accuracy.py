"""The report on accuracy: written by its command, kept, and served."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx
import pytest
from tests.service.cli.commands import run

from damperlab.service.reports import keep_report
from damperlab.worker.accuracy.cases import SCENES
from damperlab.worker.accuracy.methods import METHODS


def test_the_last_report_is_served_and_leaves_nothing_else_behind(
    own_service: Callable[..., Any], tmp_path: Path
) -> None:
    data_dir = tmp_path / "data"
    running = own_service(data_dir)
    with httpx.Client(base_url=running.url, timeout=300) as client:
        none = client.get("/api/v1/accuracy")
        assert (none.status_code, none.headers["content-type"]) == (404, "application/problem+json")
        assert client.get("/api/v1/accuracy/reports").json() == {"reports": []}
        for passed in (True, False):
            target = keep_report(data_dir, {"passed": passed, "diagrams": [], "stability": []})
        found = client.get("/api/v1/accuracy")
        assert (found.status_code, found.json()["passed"]) == (200, False)
        assert client.get("/api/v1/accuracy/reports").json() == {"reports": [{"passed": False}]}
        target.write_text("{ not a report")
        assert client.get("/api/v1/accuracy").status_code == 404
        assert client.get("/api/v1/accuracy/reports").json() == {"reports": []}
    target = keep_report(tmp_path / "new", {"passed": True})
    assert list(target.parent.iterdir()) == [target]


PNG = b"\x89PNG\r\n\x1a\n"
PAPER = METHODS[-1]


@pytest.mark.night
def test_accuracy_writes_its_report_and_keeps_it(tmp_path: Path) -> None:
    folder, data_dir = tmp_path / "report", tmp_path / "data"
    ended = run("check", "accuracy", "-o", folder, "--data-dir", data_dir, "--quick", "--json")
    report = json.loads(ended.stdout)
    assert report["passed"] is True
    assert json.loads((folder / "accuracy.json").read_text(encoding="utf-8")) == report
    assert json.loads((data_dir / "accuracy.json").read_text(encoding="utf-8")) == report
    assert (folder / "work-precision.png").read_bytes().startswith(PNG)
    words = (folder / "accuracy.md").read_text(encoding="utf-8")
    assert "(work-precision.png)" in words
    assert all(diagram["title"].capitalize() in words for diagram in report["diagrams"])
    names = [row["name"] for row in report["stability"]]
    assert len(set(names)) == len(names)
    assert all(f"| {name} |" in words for name in names)
    assert [row["name"] for row in report["stability"] if not row["passed"]] == []
    diagrams = {diagram["scene"]: diagram for diagram in report["diagrams"]}
    for scene in SCENES:
        assert report["advantages"][scene.name][PAPER.name]["error"] > 0.0
        (paper,) = (one for one in diagrams[scene.name]["curves"] if one["method"] == PAPER.name)
        # compliant walls are stiffer than its longest steps can be: they end in no number
        particle = scene.design.particle
        compliant = particle is not None and particle.wall is not None
        assert (paper["points"][0]["error"] is None) == compliant
