"""GET /api/v1/accuracy: the report that was kept last, and a problem document before there is one."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx

from damperlab.service.reports import keep_report, last_report


def test_the_last_report_is_served(own_service: Callable[..., Any], tmp_path: Path) -> None:
    data_dir = tmp_path / "data"
    running = own_service(data_dir)
    with httpx.Client(base_url=running.url, timeout=300) as client:
        none = client.get("/api/v1/accuracy")
        assert none.status_code == 404
        assert none.headers["content-type"] == "application/problem+json"
        assert "damperlab accuracy" in none.json()["detail"]
        assert client.get("/api/v1/accuracy/reports").json() == {"reports": []}
        keep_report(data_dir, {"passed": True, "diagrams": [], "stability": []})
        keep_report(data_dir, {"passed": False, "diagrams": [], "stability": []})
        found = client.get("/api/v1/accuracy")
        assert (found.status_code, found.json()["passed"]) == (200, False)
        assert client.get("/api/v1/accuracy/reports").json() == {"reports": [{"passed": False}]}
        (data_dir / "accuracy.json").write_text("{ not a report")
        assert client.get("/api/v1/accuracy").status_code == 404
        assert client.get("/api/v1/accuracy/reports").json() == {"reports": []}


def test_a_kept_report_leaves_nothing_else_behind(tmp_path: Path) -> None:
    target = keep_report(tmp_path / "new", {"passed": True})
    assert last_report(tmp_path / "new") == {"passed": True}
    assert list(target.parent.iterdir()) == [target]
