"""What many ask at a time is looked up and computed once, and nobody is told what was seen before they asked."""

import threading
from types import SimpleNamespace
from typing import Any

import anyio
import httpx
import pytest
from anyio.to_thread import run_sync

from damperlab.service.work.kept import READS, Kept
from damperlab.service.work.shared import Shared
from damperlab.studies.store.faults import StoreAway, StudyNotFound

URL = "/api/v1/studies/one/resonance-map"


def test_whoever_comes_during_a_look_is_told_of_the_next() -> None:
    looks: list[str] = []
    began, go = threading.Event(), threading.Event()

    def look(what: str) -> int:
        looks.append(what)
        began.set()
        go.wait(60)
        return len(looks)

    async def main() -> list[int]:
        shared = Shared(look)
        found = [0] * 11

        async def ask(place: int) -> None:
            found[place] = await shared.ask("a study")

        async with anyio.create_task_group() as group:
            group.start_soon(ask, 0)
            await run_sync(began.wait, 60)
            for place in range(1, 11):
                group.start_soon(ask, place)
            await anyio.wait_all_tasks_blocked()
            go.set()
        return found

    assert anyio.run(main) == [1] + [2] * 10
    assert looks == ["a study"] * 2


def test_what_is_not_found_is_told_to_all_and_forgotten() -> None:
    async def main() -> None:
        shared = Shared({"here": 1}.__getitem__)
        for _ in range(2):
            with pytest.raises(KeyError):
                await shared.ask("gone")
            assert await shared.ask("here") == 1

    anyio.run(main)


class _Service:
    """An application that answers slowly, and whose study changes when told."""

    def __init__(self, status: int) -> None:
        self.status, self.revision, self.computed = status, 1, 0
        self.others: dict[str, Any] = {}
        self.away: str | None = None
        self.state = SimpleNamespace(service=SimpleNamespace(store=self))

    def find(self, name: str) -> Any:
        if name in self.others:
            return SimpleNamespace(**self.others[name])
        if name == self.away:
            raise StoreAway("catalogue", "no answer", "one that answers", "try again")
        if name != "one":
            raise StudyNotFound("study", name, "one that is there", "name another")
        return SimpleNamespace(id=name, created=0, revision=self.revision, state="running")

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        self.computed += 1
        await anyio.sleep(0.05)
        body = b"%d of %d" % (self.computed, self.revision)
        headers = [(b"content-length", b"%d" % len(body)), (b"etag", b'W/"%s"' % body)]
        await send({"type": "http.response.start", "status": self.status, "headers": headers})
        await send({"type": "http.response.body", "body": body})


def _ask(status: int, steps: Any) -> None:
    service = _Service(status)
    kept = Kept(service)

    async def application(scope: Any, receive: Any, send: Any) -> None:
        await kept({**scope, "app": service}, receive, send)

    async def main() -> None:
        transport = httpx.ASGITransport(app=application)
        async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as client:
            await steps(service, client)

    anyio.run(main)


async def _together(client: httpx.AsyncClient, many: int) -> list[httpx.Response]:
    answers: list[httpx.Response] = []

    async def one() -> None:
        answers.append(await client.get(URL))

    async with anyio.create_task_group() as group:
        for _ in range(many):
            group.start_soon(one)
    return answers


def test_one_answer_serves_all_until_the_study_changes() -> None:
    async def steps(service: _Service, client: httpx.AsyncClient) -> None:
        answers = await _together(client, 30)
        assert {(each.status_code, each.content) for each in answers} == {(200, b"1 of 1")}
        tag = answers[0].headers["etag"]
        same = await client.get(URL, headers={"if-none-match": tag})
        assert (same.status_code, same.content, same.headers["etag"]) == (304, b"", tag)
        service.revision = 2
        assert (await client.get(URL, headers={"if-none-match": tag})).content == b"2 of 2"
        assert service.computed == 2

    _ask(200, steps)


def test_refusals_are_not_kept() -> None:
    async def steps(service: _Service, client: httpx.AsyncClient) -> None:
        answers = await _together(client, 5)
        assert [each.status_code for each in answers] == [409] * 5
        assert service.computed == 5
        assert (await client.get(URL.replace("one", "other"))).content == b"6 of 1"

    _ask(409, steps)


@pytest.mark.parametrize("away", ["one", "two"])
def test_a_question_whose_study_is_not_known_is_not_computed(away: str) -> None:
    async def steps(service: _Service, client: httpx.AsyncClient) -> None:
        service.away = away
        answer = await client.get(f"{URL}?minus=two")
        assert (answer.status_code, answer.json()["type"]) == (503, "urn:damperlab:problem:store-unavailable")
        assert service.computed == 0

    _ask(200, steps)


@pytest.mark.parametrize(
    "question",
    [
        "frequency-response?with=two",
        "resonance-map?minus=two",
        "differences?older=two",
        "optimal-designs?with=three,two",
    ],
)
@pytest.mark.parametrize(
    "change",
    [{"revision": 2}, {"created": 9}, {"state": "done"}, {"message": "lost"}, {"tags": ("a",)}, None],
)
def test_an_answer_made_of_several_studies_is_kept_while_all_stay_as_they_are(
    question: str, change: dict[str, Any] | None
) -> None:
    async def steps(service: _Service, client: httpx.AsyncClient) -> None:
        other = {"created": 0, "revision": 1, "state": "running", "message": None, "tags": ()}
        service.others = {"two": {"id": "two", **other}, "three": {"id": "three", **other}}
        url = URL.replace("resonance-map", question)
        for _ in range(2):
            assert (await client.get(url)).content == b"1 of 1"
        if change is None:
            del service.others["two"]
        else:
            service.others["two"] |= change
        # of one that was deleted the application itself says so
        assert (await client.get(url)).content == b"2 of 1"

    _ask(200, steps)


def test_every_parameter_that_names_a_study_is_known_as_one(
    client: httpx.Client, curve: dict[str, Any]
) -> None:
    """A new one cannot be forgotten: what answers that there is no such study has read it as one."""
    prefix, found = "/api/v1/studies/{study_id}/", set()
    for path, operations in client.get("/openapi.json").json()["paths"].items():
        for parameter in operations.get("get", {}).get("parameters", []) if path.startswith(prefix) else []:
            if parameter["in"] != "query":
                continue
            url = path.replace("{study_id}", curve["id"]).replace("{key}", "zarr.json")
            query = {"x": "frequency_ratio", "y": "friction_ratio"} if "resonance-map" in path else {}
            answer = client.get(url, params={**query, parameter["name"]: "0" * 12})
            if answer.status_code == 404:
                assert answer.json()["type"].endswith("study-not-found"), answer.text
                found.add((path.removeprefix(prefix), parameter["name"]))
    assert found == {(question, name) for question, names in READS.items() for name in names}


def _scope() -> dict[str, Any]:
    return {
        "type": "http",
        "method": "GET",
        "path": URL,
        "query_string": b"",
        "headers": [],
        "app": _Service(200),
    }


async def _nothing() -> Any:
    raise AssertionError("nothing is read")


def test_an_answer_that_its_reader_takes_slowly_keeps_nobody_waiting() -> None:
    async def main() -> None:
        read = anyio.Event()

        async def streamed(scope: Any, receive: Any, send: Any) -> None:
            await send({"type": "http.response.start", "status": 200, "headers": []})
            await send({"type": "http.response.body", "body": b"part", "more_body": True})
            await send({"type": "http.response.body", "body": b"", "more_body": False})

        async def slow(message: Any) -> None:
            if message["type"] == "http.response.body":
                await read.wait()

        async def quick(message: Any) -> None:
            if not message.get("more_body", True):
                read.set()

        kept, scope = Kept(streamed), _scope()
        with anyio.fail_after(60):
            async with anyio.create_task_group() as group:
                group.start_soon(kept, dict(scope), _nothing, slow)
                await anyio.wait_all_tasks_blocked()
                group.start_soon(kept, dict(scope), _nothing, quick)

    anyio.run(main)


def test_of_those_who_wait_for_what_is_given_up_one_computes() -> None:
    async def main() -> list[str]:
        seen: list[str] = []
        left, go = anyio.Event(), anyio.Event()

        async def answering(scope: Any, receive: Any, send: Any) -> None:
            seen.append("computed")
            if len(seen) == 1:
                await left.wait()
                return  # as where the client has left
            await go.wait()
            await send({"type": "http.response.start", "status": 200, "headers": []})
            await send({"type": "http.response.body", "body": b"whole"})

        async def send(message: Any) -> None:
            if message.get("body") == b"whole":
                seen.append("sent")

        kept, scope = Kept(answering), _scope()
        with anyio.fail_after(60):
            async with anyio.create_task_group() as group:
                for _ in range(5):
                    group.start_soon(kept, dict(scope), _nothing, send)
                while not seen:
                    await anyio.wait_all_tasks_blocked()
                left.set()
                while len(seen) < 2:
                    await anyio.wait_all_tasks_blocked()
                await anyio.wait_all_tasks_blocked()
                go.set()
        return seen

    assert anyio.run(main) == ["computed", "computed", *["sent"] * 4]
