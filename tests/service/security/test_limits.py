"""What one key or address may take: requests, studies that wait, points; another one is not touched by it."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import anyio
import httpx
import pytest
from tests.service.conftest import CURVE, SPECIFICATION, long_study, serving
from tests.service.security.conftest import Guarded, make_key

from damperlab.service.security.address import counted_address
from damperlab.service.security.caller import ANYBODY, Caller, counted_under
from damperlab.service.security.rates import Rates
from damperlab.service.security.shares import Shares

STUDIES = "/api/v1/studies"
A_MINUTE = 40


@pytest.fixture(scope="module")
def limited(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Guarded]:
    folder = tmp_path_factory.mktemp("limited")
    data: Path = folder / "data"
    keys = {who: make_key(data, who, "submit") for who in ("ann", "bob", "eve", "dan")}
    with serving(
        folder,
        DAMPERLAB_ACCESS="keys",
        DAMPERLAB_KEY_REQUESTS_PER_MINUTE=str(A_MINUTE),
        DAMPERLAB_KEY_QUOTA_UNFINISHED="2",
        DAMPERLAB_KEY_QUOTA_POINTS="240100",
        DAMPERLAB_KEY_QUOTA_BYTES="none",
        DAMPERLAB_KEY_QUOTA_RECORDS="2",
        DAMPERLAB_QUOTA_RECORDS="3",
        DAMPERLAB_KEY_QUOTA_DESIGNS="1",
    ) as running:
        yield Guarded(running, data, keys)


def _code(answer: httpx.Response) -> tuple[int, str]:
    return answer.status_code, answer.json()["errors"][0]["field"]


def test_points_and_studies_are_counted_for_each_owner(limited: Guarded) -> None:
    with limited.client("ann") as ann, limited.client("bob") as bob:
        long = [ann.post(STUDIES, json=long_study(f"long {each}", 0.0038 + 1e-4 * each)) for each in (0, 1)]
        assert [each.status_code for each in long] == [201, 201]
        waiting = ann.post(STUDIES, json=CURVE)
        assert _code(waiting) == (429, "key_quota_unfinished")
        assert int(waiting.headers["retry-after"]) > 0
        # what is there is never refused, and what is refused for one is not for another
        assert ann.post(STUDIES, json=long_study("long 0")).status_code == 200
        assert bob.post(STUDIES, json=CURVE).status_code == 201
        for each in long:
            assert ann.post(f"{STUDIES}/{each.json()['id']}/cancel").status_code == 200
        assert _code(ann.post(STUDIES, json=long_study("a third", 0.005))) == (
            507,
            "key_quota_points",
        )
        assert ann.delete(f"{STUDIES}/{long[0].json()['id']}").status_code == 204


def test_a_study_that_goes_on_counts_as_one_that_is_new(limited: Guarded) -> None:
    with limited.client("dan") as dan:
        urls = []
        for damping in (0.011, 0.012, 0.013):
            made = dan.post(STUDIES, json=long_study("going on", damping, frequencies=10)).json()
            urls.append(f"{STUDIES}/{made['id']}")
            assert dan.post(f"{urls[-1]}/cancel").status_code == 200
        assert [dan.post(f"{url}/resume").status_code for url in urls[:2]] == [200, 200]
        refused = dan.post(f"{urls[2]}/resume")
        assert _code(refused) == (429, "key_quota_unfinished")
        assert int(refused.headers["retry-after"]) > 0
        assert dan.get(urls[2]).json()["state"] == "cancelled"
        # one that waits already is refused by nothing
        assert dan.post(f"{urls[0]}/resume").status_code == 200
        assert dan.post(f"{urls[0]}/cancel").status_code == 200
        assert dan.post(f"{urls[2]}/resume").status_code == 200
        for url in urls:
            dan.post(f"{url}/cancel")


def test_records_are_counted_for_each_owner(limited: Guarded) -> None:
    def generate(client: httpx.Client, seed: int) -> httpx.Response:
        return client.post("/api/v1/records", json={"kanai_tajimi": {"seed": seed, "duration_s": 20}})

    with limited.client("ann") as ann, limited.client("bob") as bob:
        made = [generate(ann, seed) for seed in (1, 2)]
        assert [each.status_code for each in made] == [201, 201]
        assert _code(generate(ann, 3)) == (507, "key_quota_records")
        # what is there is never refused, and what is refused for one is not for another
        assert generate(ann, 1).status_code == 200
        third = generate(bob, 3)
        assert third.status_code == 201
        assert _code(generate(bob, 4)) == (507, "quota_records")
        records = {each["id"]: each for each in ann.get("/api/v1/records").json()["records"]}
        assert records[third.json()["id"]]["submitted_by"] == "bob"
        assert not any("submitted_by" in each for key, each in records.items() if not key.startswith("u-"))
        assert ann.delete(f"/api/v1/records/{made[0].json()['id']}").status_code == 204
        assert generate(ann, 4).status_code == 201


def test_designs_are_counted_for_each_owner(limited: Guarded) -> None:
    designs = "/api/v1/designs"
    with limited.client("dan") as dan:
        made = dan.post(designs, json=SPECIFICATION)
        assert made.status_code == 201
        other = SPECIFICATION | {"confidence": 0.8}
        assert _code(dan.post(designs, json=other)) == (507, "key_quota_designs")
        assert dan.post(designs, json=SPECIFICATION).status_code == 200
        assert dan.post(f"{designs}/{made.json()['id']}/cancel").status_code == 200


def test_a_key_has_so_many_requests_a_minute(limited: Guarded) -> None:
    with limited.client("eve") as eve, limited.client("bob") as bob:
        statuses = [eve.get(STUDIES, params={"limit": 1}).status_code for _ in range(A_MINUTE)]
        assert statuses == [200] * A_MINUTE
        # more may have come back meanwhile, one in 1.5 s
        while (answer := eve.get(STUDIES)).status_code == 200:
            pass
        assert _code(answer) == (429, "requests")
        assert 1 <= int(answer.headers["retry-after"]) <= 60
        assert bob.get(STUDIES).status_code == 200
        assert eve.get("/health/live").status_code == 200


def test_rates_fill_up_again(monkeypatch: pytest.MonkeyPatch) -> None:
    now = 1000.0
    monkeypatch.setattr("damperlab.service.security.rates.time.monotonic", lambda: now)
    rates = Rates(60)
    assert [rates.wait_seconds("ann") for _ in range(62)] == [0] * 60 + [1, 1]
    assert rates.wait_seconds("bob") == 0
    now += 2.0
    assert [rates.wait_seconds("ann") for _ in range(3)] == [0, 0, 1]
    assert Rates(None).wait_seconds("ann") == 0


def _caller(name: str) -> Caller:
    return Caller(name, ("read",), "key", key_id=name)


@pytest.mark.parametrize(
    ("mine", "other"),
    [
        ({"caller": _caller("ann")}, {"caller": _caller("bob")}),
        (
            {"caller": ANYBODY, "client_address": "192.0.2.1"},
            {"caller": ANYBODY, "client_address": "192.0.2.2"},
        ),
    ],
)
def test_so_many_streams_and_exports_are_open_at_a_time(mine: dict[str, Any], other: dict[str, Any]) -> None:
    """Of one key, and where nobody has one of one address; another's are not touched by it."""

    async def main() -> None:
        ended = anyio.Event()
        statuses: list[int] = []

        async def stream(scope: Any, receive: Any, send: Any) -> None:
            await send({"type": "http.response.start", "status": 200, "headers": []})
            await ended.wait()

        shares = Shares(stream, {"events": 2, "export": 1})

        async def ask(kind: str, who: dict[str, Any]) -> None:
            async def send(message: Any) -> None:
                if message["type"] == "http.response.start":
                    statuses.append(message["status"])
                    if message["status"] == 429:
                        assert b"retry-after" in dict(message["headers"])

            nothing: Any = None
            path = f"{STUDIES}/{'0' * 12}/{kind}"
            await shares({"type": "http", "method": "GET", "path": path, "headers": [], **who}, nothing, send)

        async def together(*kinds: str, who: dict[str, Any] = mine) -> list[int]:
            statuses.clear()
            for kind in kinds:
                group.start_soon(ask, kind, who)
                await anyio.wait_all_tasks_blocked()
            return list(statuses)

        with anyio.fail_after(60):
            async with anyio.create_task_group() as group:
                assert await together("events", "events", "events") == [200, 200, 429]
                assert await together("export", "export") == [200, 429]
                assert await together("events", "export", who=other) == [200, 200]
                ended.set()
            ended = anyio.Event()
            async with anyio.create_task_group() as group:
                assert await together("events", "events", "events") == [200, 200, 429]
                ended.set()

    anyio.run(main)


@pytest.mark.parametrize(
    ("address", "counted"),
    [
        ("192.0.2.7", "192.0.2.7"),
        ("::ffff:192.0.2.7", "192.0.2.7"),
        ("2001:db8:1:2:3:4:5:6", "2001:db8:1:2::/64"),
        ("2001:db8:1:2::9", "2001:db8:1:2::/64"),
        ("2001:db8:1:3::9", "2001:db8:1:3::/64"),
        ("fe80::1%eth0", "fe80::/64"),
        ("testclient", "testclient"),
        ("", ""),
    ],
)
def test_an_address_is_counted_by_its_network(address: str, counted: str) -> None:
    assert counted_address(address) == counted
    scope = {"caller": ANYBODY, "client_address": address}
    assert counted_under(scope) == (counted or ANYBODY.name)
    assert counted_under({**scope, "caller": Caller("", (), "key", "one")}) == "one"
