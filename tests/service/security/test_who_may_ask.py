"""Keys: who may ask, who may change what, and what is remembered of it."""

import json
import stat
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import httpx
import pytest
from tests.service.cli.commands import run, run_apart
from tests.service.conftest import SPECIFICATION, ended, wait_for, wait_for_design, wait_until
from tests.service.security.conftest import Guarded, make_key

from damperlab import Client
from damperlab.service.security import sessions
from damperlab.service.security.sessions import OF_ONE_KEY, Sessions
from damperlab.studies.store.catalogue.access_keys import AccessKey

STUDIES = "/api/v1/studies"


def _study(name: str, stop: float) -> dict[str, Any]:
    axes = {"friction_ratio": 0.1, "frequency_ratio": {"start": 0.5, "stop": stop, "num": 3}}
    return {"name": name, "particle": False, "damping_ratio": 0.0038, "axes": axes}


def _kind(answer: httpx.Response) -> str:
    kind: str = answer.json()["type"]
    return kind.removeprefix("urn:damperlab:problem:")


def test_without_a_key_nothing_is_told(guarded: Guarded) -> None:
    """Each route asks for one in `test_every_route`; so does what is no route."""
    with guarded.client(None) as client:
        answer = client.get("/api/v1/nothing")
        assert (answer.status_code, _kind(answer)) == (401, "no-key")
        assert answer.headers["www-authenticate"].startswith("Bearer")
        for path in ("/", "/health/live", "/health/ready", "/api/v1/session"):
            assert client.get(path).status_code == 200, path


def test_what_is_no_key_and_another_secret_under_a_known_id_open_nothing(guarded: Guarded) -> None:
    key = guarded.keys["ann"]["key"]
    changed = (key[:-1] + ("A" if key[-1] != "A" else "B"), key[:-1], key + "A", key.upper())
    none = ("x", "dlk_000000000000_" + "A" * 43, "dlk_" + "A" * 8000, *changed)
    with guarded.client(None) as client:
        for value in ("Bearer", *(f"Bearer {each}" for each in none), "Basic eDp5", b"Bearer \xff\xfe"):
            headers: Any = {"Authorization": value}
            assert client.get(STUDIES, headers=headers).status_code == 401, value


def test_a_place_before_the_studies_of_others_is_for_admins(guarded: Guarded) -> None:
    with guarded.client("ann") as ann, guarded.client("admin") as admin:
        for body in (_study("first", 1.71), [_study("first", 1.71)]):
            refused = ann.post(STUDIES, params={"priority": 1}, json=body)
            assert (refused.status_code, _kind(refused)) == (403, "scope-lacking")
            assert refused.json()["errors"][0]["field"] == "priority"
        assert ann.post(STUDIES, params={"priority": -4}, json=_study("last", 1.72)).json()["priority"] == -4
        made = admin.post(STUDIES, params={"priority": 3}, json=[_study("first", 1.73)])
        assert made.json()["studies"][0]["priority"] == 3
        assert admin.post(STUDIES, params={"priority": 11}, json=_study("no", 1.74)).status_code == 422


def test_an_owner_changes_what_is_his_and_nobody_elses(guarded: Guarded) -> None:
    with guarded.client("ann") as ann, guarded.client("bob") as bob, guarded.client("admin") as admin:
        made = ann.post(STUDIES, json=_study("anns", 1.4))
        assert made.status_code == 201, made.text
        record = made.json()
        assert record["provenance"]["submitted_by"] == record["submitted_by"] == "ann"
        listed = bob.get(STUDIES, params={"name": "anns"}).json()["studies"]
        assert [one["submitted_by"] for one in listed] == ["ann"]
        url = f"{STUDIES}/{record['id']}"
        assert bob.get(url).status_code == 200
        # the same definition is the same study, and stays hers
        assert bob.post(STUDIES, json=_study("anns", 1.4)).status_code == 200
        for method, path in (
            ("POST", "/cancel"),
            ("POST", "/resume"),
            ("POST", "/retry"),
            ("POST", "/recompute"),
            ("PATCH", ""),
            ("DELETE", ""),
        ):
            answer = bob.request(method, url + path)
            assert (answer.status_code, _kind(answer)) == (403, "not-yours"), path
        wait_for(ann, record["id"], ended)
        # a study that is done may be busy a moment longer, until its runner lets it go
        wait_until(lambda: ann.delete(url).status_code == 204)
        again = ann.post(STUDIES, json=_study("anns", 1.4)).json()
        wait_for(admin, again["id"], ended)
        wait_until(lambda: admin.delete(url).status_code == 204)


def test_a_design_and_its_studies_are_whose_they_are(guarded: Guarded) -> None:
    asked = SPECIFICATION | {"clearance_m": 0.0055}
    with guarded.client("ann") as ann, guarded.client("bob") as bob, guarded.client("admin") as admin:
        made = ann.post("/api/v1/designs", json=asked)
        assert made.status_code == 201, made.text
        url = f"/api/v1/designs/{made.json()['id']}"
        assert bob.post("/api/v1/designs", json=asked).status_code == 200
        for method, path in (("POST", "/cancel"), ("POST", "/resume"), ("DELETE", "")):
            answer = bob.request(method, url + path)
            assert (answer.status_code, _kind(answer)) == (403, "not-yours"), path

        def has_study(now: dict[str, Any]) -> bool:
            # a design says which studies it waits for before it enters them
            first = f"{STUDIES}/{now['studies'][0]}" if now["studies"] else STUDIES + "/none"
            return now["round"] > 1 and bob.get(first).status_code == 200

        now = wait_for_design(bob, made.json()["id"], has_study)
        record = bob.get(f"{STUDIES}/{now['studies'][0]}").json()
        assert record["provenance"]["submitted_by"] == "ann"
        # a design that is done cannot be cancelled any more
        assert ann.post(f"{url}/cancel").status_code in (200, 409)
        assert admin.delete(url).status_code == 204
        for study in ann.get(STUDIES, params={"limit": 200, "name": asked["name"]}).json()["studies"]:
            wait_until(lambda each=study["id"]: ann.delete(f"{STUDIES}/{each}").status_code == 204)


def test_a_revoked_and_an_expired_key_open_nothing(guarded: Guarded) -> None:
    short = make_key(guarded.data_dir, "guest", "read", 1.0)
    lost = make_key(guarded.data_dir, "guest", "read")
    with guarded.client(None) as client:

        def status(key: dict[str, Any]) -> int:
            return client.get(STUDIES, headers={"Authorization": f"Bearer {key['key']}"}).status_code

        assert status(lost) == 200
        run("admin", "keys", "revoke", lost["id"], "--data-dir", guarded.data_dir)
        wait_until(lambda: (status(lost), status(short)) == (401, 401))
    listed = json.loads(run("admin", "keys", "list", "--data-dir", guarded.data_dir, "--json").stdout)["keys"]
    valid = {key["id"]: key["valid"] for key in listed}
    assert [valid[key["id"]] for key in (short, lost, guarded.keys["ann"])] == [False, False, True]


def test_no_file_of_the_service_holds_a_secret_or_is_anybody_elses_to_read(guarded: Guarded) -> None:
    # a key is dlk_, its public id, its secret; the secret itself may hold underscores
    secrets = [key["key"].split("_", 2)[2].encode() for key in guarded.keys.values()]
    assert all(len(secret) == 43 for secret in secrets)  # 32 bytes in base64: no chance finding
    kept = [guarded.data_dir, *guarded.data_dir.rglob("*")]
    assert guarded.data_dir / "catalogue.sqlite" in kept
    for path in kept:
        assert stat.S_IMODE(path.stat().st_mode) & 0o077 == 0, path
    for path in (guarded.running.log, *filter(Path.is_file, kept)):
        content = path.read_bytes()
        assert not any(secret in content for secret in secrets), path


def test_changes_are_in_the_audit_log_with_who_asked_for_them(guarded: Guarded) -> None:
    with guarded.client("bob") as bob:
        answer = bob.delete(f"{STUDIES}/00000000abcd")
        assert answer.status_code == 404
        bob.get(STUDIES).raise_for_status()
    lines = [json.loads(line) for line in (guarded.data_dir / "audit.jsonl").read_text().splitlines()]
    (mine,) = (line for line in lines if line["request"] == answer.headers["x-request-id"])
    told = {"who": "bob", "key": guarded.keys["bob"]["id"], "how": "key", "address": "127.0.0.1"}
    assert (
        mine.items() >= {**told, "method": "DELETE", "path": f"{STUDIES}/00000000abcd", "status": 404}.items()
    )
    assert not any(line["method"] == "GET" and line["status"] == 200 for line in lines)


def test_a_session_of_the_page(guarded: Guarded) -> None:
    own = {"Origin": guarded.url, "Sec-Fetch-Site": "same-origin"}
    session = "/api/v1/session"
    with guarded.client(None) as page, guarded.client(None) as nobody:
        page.headers.update(own)
        assert page.get(session).json() == {"needed": True, "signed_in": False, "owner": "", "scopes": []}
        for wrong in ({"key": "dlk_x"}, {"key": "ключ"}):
            assert page.post(session, json=wrong).status_code == 401
        for odd in ({}, [], {"key": 1}, {"key": "a", "b": 1}):
            assert page.post(session, json=odd).status_code == 422
        answer = page.post(session, json={"key": guarded.keys["ann"]["key"]})
        assert answer.status_code == 200
        cookie = answer.headers["set-cookie"]
        assert "HttpOnly" in cookie
        assert "SameSite=strict" in cookie
        assert guarded.keys["ann"]["key"] not in cookie
        assert page.get(session).json()["owner"] == "ann"
        assert page.get(STUDIES).status_code == 200
        value = page.cookies["damperlab_session"]
        of_nobody = f"{'0' * 12}.99999999999.{'0' * 64}"
        changed = value[:-1] + ("0" if value[-1] != "0" else "1")
        for forged in (changed, value.replace(".", ".9", 1), of_nobody, "x"):
            given = {"Cookie": f"damperlab_session={forged}"}
            assert nobody.get(STUDIES, headers=given).status_code == 401
        # another site's page cannot use it
        cross = {"Origin": "http://evil.example", "Sec-Fetch-Site": "cross-site"}
        assert page.post(STUDIES, json=_study("evil", 1.2), headers=cross).status_code == 403
        assert page.delete(session).status_code == 204
        page.cookies.clear()
        assert page.get(STUDIES).status_code == 401


def test_a_session_ends_on_the_server(guarded: Guarded) -> None:
    key = make_key(guarded.data_dir, "guest", "read")

    def signed_in(client: httpx.Client) -> str:
        assert client.post("/api/v1/session", json={"key": key["key"]}).status_code == 200
        return client.cookies["damperlab_session"]

    def status(cookie: str) -> int:
        return nobody.get(STUDIES, headers={"Cookie": f"damperlab_session={cookie}"}).status_code

    with guarded.client(None) as page, guarded.client(None) as other, guarded.client(None) as nobody:
        copied, stays = signed_in(page), signed_in(other)
        assert (status(copied), status(stays)) == (200, 200)
        assert page.delete("/api/v1/session").status_code == 204
        assert (status(copied), status(stays)) == (401, 200)
        run("admin", "keys", "revoke", key["id"], "--data-dir", guarded.data_dir)
        wait_until(lambda: status(stays) == 401)


def test_a_key_has_only_so_many_sessions() -> None:
    key = AccessKey("0" * 12, "ann", ("read",), None, None, None, "1" * 64)
    opened = Sessions()
    values = [opened.begin(key)[0] for _ in range(OF_ONE_KEY + 2)]
    assert [opened.stands_for(each, key) for each in values] == [False] * 2 + [True] * OF_ONE_KEY


def test_a_session_ends_after_hours_and_with_its_key(monkeypatch: pytest.MonkeyPatch) -> None:
    lasting = AccessKey("0" * 12, "ann", ("read",), None, None, None, "1" * 64)
    over = replace(lasting, id="1" * 12, expires=datetime.now(UTC))
    opened = Sessions()
    values = [opened.begin(key)[0] for key in (lasting, over)]
    assert [opened.key_id(each) for each in values] == [lasting.id, None]
    monkeypatch.setattr(sessions, "LASTS_SECONDS", 0)
    assert opened.key_id(opened.begin(lasting)[0]) is None


def test_the_client_takes_its_key_from_argument_environment_or_file(
    guarded: Guarded, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from damperlab.service.client.faults import Problem, Refused

    def ask(**given: str) -> None:
        with Client(guarded.url, **given) as client:
            client.studies()

    key = guarded.keys["ann"]["key"]
    ask(api_key=key)
    with pytest.raises(Problem, match="key"):
        ask()
    monkeypatch.setenv("DAMPERLAB_KEY", key)
    ask()
    monkeypatch.delenv("DAMPERLAB_KEY")
    file = tmp_path / "key"
    file.write_text(key + "\n")
    monkeypatch.setenv("DAMPERLAB_KEY_FILE", str(file))
    file.chmod(0o644)
    with pytest.raises(Refused, match="chmod 600"):
        ask()
    file.chmod(0o600)
    ask()


def test_beyond_loopback_nothing_is_served_without_keys(tmp_path: Path) -> None:
    data = tmp_path / "data"
    beyond = ("serve", "--host", "0.0.0.0", "--port", "0", "--data-dir", data)
    refused = run(*beyond, status=2)
    assert "damperlab admin keys create" in refused.stderr
    assert "--open" in refused.stderr
    expired = ("--scope", "read", "--expires", "0s", "--data-dir", data, "--json")
    assert json.loads(run_apart("admin", "keys", "create", *expired).stdout)["valid"] is False
    run(*beyond, status=2)
    run("serve", "--open", "--keys", "--data-dir", data, "--port", "0", status=2)
