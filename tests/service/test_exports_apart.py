"""What an export writes lies in one folder, which goes however the export ends; trouble with it is a problem document."""

import os
import time
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import anyio
import httpx
import pytest
from fastapi import FastAPI
from starlette.requests import ClientDisconnect

from damperlab.service.edge.conditional import TAGGED_BYTES
from damperlab.service.problems import Problem, install
from damperlab.service.routes import export, questions
from damperlab.service.state import Service
from damperlab.studies.store.care.sweep import LEFT_ALONE_SECONDS, remove_exports

PARTS = b"a long answer"
WHOLE = TAGGED_BYTES + 1


def _ask(data_dir: Path, run: Callable[[Path], Any], question: str = "export") -> httpx.Response:
    async def computed(request: Any, function: Any, *arguments: Any, shares: int) -> Any:
        (place, *_) = arguments[-1]
        return run(place)

    work = SimpleNamespace(run=computed)
    # no export takes the turn of a question
    turns = {"exports": work, "work": None} if question == "export" else {"exports": None, "work": work}
    record = SimpleNamespace(id="0" * 12, name="", points_total=1, points_done=1, ended=False)
    app = FastAPI()
    install(app)
    for routes in (export, questions):
        app.router.routes.extend(routes.router.routes)
    parts: dict[str, Any] = dict.fromkeys(each.name for each in fields(Service)) | turns
    parts["settings"] = SimpleNamespace(data_dir=data_dir, question_points_apart=0)
    parts["store"] = SimpleNamespace(find=lambda name: record)
    app.state.service = Service(**parts)

    async def main() -> httpx.Response:
        transport = httpx.ASGITransport(app=app)
        async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as client:
            return await client.get(f"/api/v1/studies/{record.id}/{question}")

    return anyio.run(main)


@pytest.mark.parametrize("question", ["export", "resonance-map"])
@pytest.mark.parametrize("answer", [PARTS, bytes(WHOLE)], ids=["short", "long"])
def test_an_answer_is_sent_and_leaves_nothing(tmp_path: Path, question: str, answer: bytes) -> None:
    def run(place: Path) -> dict[str, str]:
        assert (place.parent.parent == tmp_path) == (question == "export")
        place.write_bytes(answer)
        return {"content-length": str(len(answer)), "content-type": "application/json"}

    found = _ask(tmp_path, run, question)
    assert (found.status_code, found.content) == (200, answer)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("question", ["export", "resonance-map"])
@pytest.mark.parametrize("end", [ClientDisconnect(), Problem(422, "work-limit", "Too much.")])
def test_what_a_killed_process_wrote_goes(tmp_path: Path, end: Exception, question: str) -> None:
    def run(place: Path) -> None:
        place.write_bytes(PARTS)
        (place.parent / "inner").mkdir()
        raise end

    # whoever has left reads nothing of it
    assert _ask(tmp_path, run, question).status_code == (422 if isinstance(end, Problem) else 400)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("trouble", ["moved", "full"])
def test_a_folder_that_cannot_be_used_is_the_store_s_trouble(tmp_path: Path, trouble: str) -> None:
    def full(place: Path) -> None:
        raise OSError(28, "No space left on device")

    found = _ask(tmp_path / "moved" if trouble == "moved" else tmp_path, full)
    assert (found.status_code, found.json()["type"]) == (503, "urn:damperlab:problem:store-unavailable")
    assert ("No space left" in found.text) == (trouble == "full")


def test_exports_of_a_service_that_was_killed_go(tmp_path: Path) -> None:
    for name in ("export-old", "export-young"):
        (tmp_path / name / "export-inner").mkdir(parents=True)
    long_ago = time.time() - 2 * LEFT_ALONE_SECONDS
    os.utime(tmp_path / "export-old", (long_ago, long_ago))
    remove_exports(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["export-young"]
