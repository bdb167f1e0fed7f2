"""What an export writes lies in one folder, which goes however the export ends; trouble with it is a problem document."""

import os
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import anyio
import httpx
import pytest
from starlette.requests import ClientDisconnect
from tests.filling import enter

from damperlab.service.problems import Problem
from damperlab.service.routes import export
from damperlab.service.security.caller import ANYBODY
from damperlab.service.settings import Settings
from damperlab.service.work.questions import Answer, Apart, answer
from damperlab.studies.definition import parse_study
from damperlab.studies.store.care.sweep import LEFT_ALONE_SECONDS, remove_exports
from damperlab.studies.store.store import Store

PARTS = b"a long answer"


def _write(place: Path) -> None:
    inner = place.parent / "export-inner"
    inner.mkdir()
    for path in (place, inner / "cube.nc"):
        path.write_bytes(PARTS)


def _ask(data_dir: Path, run: Callable[[Path], Answer], question: str = "export") -> httpx.Response:
    async def computed(
        request: Any, function: Any, settings: Any, asked: Any, place: Path, shares: int
    ) -> Answer:
        return run(place)

    work = SimpleNamespace(run=computed)
    store = SimpleNamespace(find=lambda name: None)
    # no export takes the turn of a question
    turns = {"exports": work, "work": None} if question == "export" else {"exports": None, "work": work}
    service = SimpleNamespace(settings=SimpleNamespace(data_dir=data_dir), store=store, **turns)
    app = SimpleNamespace(state=SimpleNamespace(service=service))
    study = SimpleNamespace(id="0" * 12, points_total=1)
    apart = Apart(app, points=0)  # type: ignore[arg-type]

    async def application(scope: Any, receive: Any, send: Any) -> None:
        known = {"app": app, "study": study, "request_id": "1", "caller": ANYBODY}
        await apart({**scope, **known}, receive, send)

    async def main() -> httpx.Response:
        transport = httpx.ASGITransport(app=application)
        async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as client:
            return await client.get(f"/api/v1/studies/{study.id}/{question}")

    return anyio.run(main)


@pytest.mark.parametrize("question", ["export", "resonance-map"])
def test_a_long_answer_is_sent_and_leaves_nothing(tmp_path: Path, question: str) -> None:
    def run(place: Path) -> Answer:
        assert (place.parent.parent == tmp_path) == (question == "export")
        _write(place)
        return 200, [(b"content-type", b"text/csv")], None

    found = _ask(tmp_path, run, question)
    assert (found.status_code, found.content) == (200, PARTS)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("end", [ClientDisconnect(), Problem(422, "work-limit", "Too much.")])
def test_what_a_killed_process_wrote_goes(tmp_path: Path, end: Exception) -> None:
    def run(place: Path) -> Answer:
        _write(place)
        raise end

    if isinstance(end, Problem):
        assert _ask(tmp_path, run).status_code == 422
    else:
        with pytest.raises(AssertionError):  # nothing is sent to a client that has left
            _ask(tmp_path, run)
    assert not list(tmp_path.iterdir())


def test_a_folder_that_cannot_be_used_is_the_store_s_trouble(tmp_path: Path) -> None:
    found = _ask(tmp_path / "moved", lambda place: (200, [], b""))
    assert (found.status_code, found.json()["type"]) == (503, "urn:damperlab:problem:store-unavailable")


def test_a_process_writes_in_its_folder_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    axes = {"friction_ratio": 0, "frequency_ratio": [0.9, 1.0]}
    study = parse_study({"name": "by hand", "damping_ratio": 0.01, "particle": False, "axes": axes})
    store = Store.open(tmp_path / "data")
    record = enter(store, study, study.shape)
    store.close()
    folder = tmp_path / "folder"
    folder.mkdir()

    def full(cube: Any, path: Path) -> None:
        assert path.is_relative_to(folder)
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(export, "write_netcdf", full)
    path = f"/api/v1/studies/{record.id}/export"
    asked = {
        "path": path,
        "raw_path": path.encode(),
        "query_string": b"",
        "request_id": "1",
        "caller": ANYBODY,
    }
    status, _, body = answer(Settings(data_dir=tmp_path / "data"), {**asked, "headers": []}, folder / "body")
    assert status == 503
    assert b"No space left" in (body or b"")


def test_exports_of_a_service_that_was_killed_go(tmp_path: Path) -> None:
    for name in ("export-old", "export-young"):
        (tmp_path / name / "export-inner").mkdir(parents=True)
    long_ago = time.time() - 2 * LEFT_ALONE_SECONDS
    os.utime(tmp_path / "export-old", (long_ago, long_ago))
    remove_exports(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["export-young"]
