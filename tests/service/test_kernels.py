"""Kernels that are missing: said before and while they are compiled. The cheapest serve, those of fixed steps."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx
import psutil
import pytest
from tests.service.conftest import wait_until

POINT = {"particle": False, "frequency_ratio": 1.0, "damping_ratio": 0.05, "method": "rk4", "cycles": 2}
STUDY = {
    "particle": False,
    "damping_ratio": 0.05,
    "axes": {"friction_ratio": [0, 0.3], "frequency_ratio": [0.8, 1.2]},
    "solver": {"method": "rk4", "steps_per_cycle": 100},
    "steady": {"max_cycles": 50},
}
LINEAR = {"particle": False, "axes": {"friction_ratio": 0, "frequency_ratio": [0.8, 1.2]}}


@pytest.fixture
def bare_service(own_service: Callable[..., Any], tmp_path: Path) -> Any:
    """A service on a machine that has compiled nothing."""
    return own_service(DAMPERLAB_CACHE_DIR=str(tmp_path / "kernels"))


@pytest.mark.night
def test_what_must_be_compiled_is_said_first_and_only_then(bare_service: Any, tmp_path: Path) -> None:
    with httpx.Client(base_url=f"{bare_service.url}/api/v1", timeout=1800.0) as client:

        def ask(path: str, document: dict[str, Any], dry: bool = True) -> dict[str, Any]:
            answer = client.post(path, json=document, params={"dry_run": dry}).raise_for_status()
            found: dict[str, Any] = answer.json()
            return found

        before = ask("/simulate", POINT)
        assert (before["phase"], before["phase_done"], before["phase_total"]) == ("compiling", 0, 1)
        assert before["compiling_seconds"] > 0
        quake = ask("/earthquake-comparisons", {"record": "northridge"})
        assert (quake["phase"], quake["phase_done"], quake["phase_total"]) == ("compiling", 0, 4)
        assert list(tmp_path.rglob("*.nbc")) == [], "who only asks does not wait"

        ask("/simulate", POINT, dry=False)
        after = ask("/simulate", POINT)
        assert after == {"phase": "ready", "phase_done": 1, "phase_total": 1, "compiling_seconds": 0}

        estimate = ask("/studies", STUDY)
        assert estimate["kernels_missing"] == 2
        assert 0 < estimate["compiling_seconds"] < estimate["seconds"]
        linear = ask("/studies", LINEAR)
        assert (linear["kernels_missing"], linear["compiling_seconds"]) == (0, 0)

        record = client.post("/studies", json=STUDY).raise_for_status().json()
        assert record["phase"] in ("queued", "starting", "compiling")
        with client.stream("GET", f"/studies/{record['id']}/events") as stream:
            lines = [line.removeprefix("data:") for line in stream.iter_lines() if line.startswith("data:")]
        seen = [(event["phase"], event["phase_total"]) for event in map(json.loads, lines)]
        assert ("compiling", 2) in seen
        assert seen[-1] == ("done", None)
        done = client.get(f"/studies/{record['id']}").json()
        assert (done["state"], done["phase"], done["points_failed"]) == ("done", "done", 0)
        later = ask("/studies", STUDY | {"damping_ratio": 0.06})
        assert (later["kernels_missing"], later["compiling_seconds"]) == (0, 0)


@pytest.mark.night
def test_the_usual_kernels_are_compiled_in_the_background_and_a_shutdown_ends_that(
    own_service: Callable[..., Any], tmp_path: Path
) -> None:
    folder = tmp_path / "kernels"
    service = own_service(DAMPERLAB_CACHE_DIR=str(folder), DAMPERLAB_WARM="true")
    wait_until(lambda: any(folder.rglob("*.lock")))
    family = psutil.Process(service.process.pid).children(recursive=True)
    assert service.stop() == 0
    assert psutil.wait_procs(family, timeout=60)[1] == []
