"""Every error is a problem document (RFC 9457) that says what was found, what is allowed and what to do."""

import re
from collections.abc import Iterator
from typing import Any

import httpx
import pytest

STUDIES = "/api/v1/studies"
LIMIT = 4 * 1024 * 1024


def _problem(answer: httpx.Response, status: int) -> dict[str, object]:
    assert answer.status_code == status
    assert answer.headers["content-type"] == "application/problem+json"
    document: dict[str, object] = answer.json()
    assert {"type", "title", "status", "detail", "instance"} <= set(document)
    assert document["status"] == status
    assert document["request_id"] == answer.headers["x-request-id"]
    return document


@pytest.mark.parametrize(
    "path",
    [
        *("/nothing", "/api/v1/studies/", "/docs", "/redoc", f"{STUDIES}/000000000000"),
        f"{STUDIES}/000000000000/zarr/status/c.0.0.0.0.0.0",
    ],
)
def test_address_that_is_not_there(client: httpx.Client, path: str) -> None:
    _problem(client.get(path), 404)


@pytest.mark.parametrize(
    ("method", "path", "allowed"),
    [
        ("PUT", STUDIES, {"GET", "HEAD", "POST"}),
        ("GET", "/api/v1/simulate", {"POST"}),
        ("POST", "/health/live", {"GET", "HEAD"}),
    ],
)
def test_method_that_is_not_there_names_those_that_are(
    client: httpx.Client, method: str, path: str, allowed: set[str]
) -> None:
    answer = client.request(method, path)
    _problem(answer, 405)
    assert allowed == set(answer.headers["allow"].split(", "))


@pytest.mark.parametrize("path", [STUDIES, "/api/v1/simulate", "/api/v1/records"])
@pytest.mark.parametrize(
    "headers",
    [
        {},
        {"content-type": "application/xml"},
        {"content-type": "application/json; charset=latin-1"},
        {"content-type": "application/json", "content-encoding": "gzip"},
        {"content-type": "text"},
    ],
)
def test_body_in_another_format(client: httpx.Client, path: str, headers: dict[str, str]) -> None:
    answer = client.post(path, content=b"{}", headers=headers)
    assert _problem(answer, 415)["errors"]
    assert "application/json" in answer.headers["accept"]


def _endless(length: int) -> Iterator[bytes]:
    sent = 0
    while sent < length:
        yield b" " * 65536
        sent += 65536


@pytest.mark.parametrize("path", [STUDIES, "/api/v1/simulate"])
def test_body_over_the_limit_announced_or_not(client: httpx.Client, path: str) -> None:
    headers = {"content-type": "application/json"}
    _problem(client.post(path, content=b" " * (LIMIT + 1), headers=headers), 413)
    _problem(client.post(path, content=_endless(2 * LIMIT), headers=headers), 413)
    # One byte less is read, and refused for what it says.
    _problem(client.post(path, content=b" " * LIMIT, headers=headers), 422)


@pytest.mark.parametrize("path", [STUDIES, "/api/v1/simulate", "/api/v1/earthquake-comparisons"])
@pytest.mark.parametrize(
    "body",
    [
        b"",
        b"[]",
        b"\xff\xfe",
        b"{",
        b'{"axes": NaN}',
        b"[" * 100_000,
        b'{"cycles": ' + b"9" * 10_000 + b"}",
        b'{"\\ud800": "\\udfff"}',
        b'{"name": "\\u0000"}',
        b'{"frequency_ratio": true}',
        b'{"__proto__": {"admin": true}, "frequency_ratio": 1}',
    ],
)
def test_body_that_is_no_request(client: httpx.Client, path: str, body: bytes) -> None:
    answer = client.post(path, content=body, headers={"content-type": "application/json"})
    assert len(answer.content) < 20_000
    for fault in _problem(answer, 422)["errors"]:  # type: ignore[attr-defined]
        assert all(fault[key] for key in ("field", "found", "allowed", "advice"))


PARAMETERS: list[tuple[str, str, set[str]]] = [
    ("GET", f"{STUDIES}?limit=many&stat=done&state=asleep", {"limit", "stat", "state"}),
    ("GET", f"{STUDIES}?cursor=@", {"cursor"}),
    ("GET", f"{STUDIES}?tag=A", {"tag"}),
    ("GET", f"{STUDIES}?axis=gap", {"axis"}),
    ("GET", f"{STUDIES}?from=1", {"from"}),
    ("GET", f"{STUDIES}?axis=clearance_ratio&from=2&to=1", {"to"}),
    ("POST", f"{STUDIES}?dry_run=perhaps", {"dry_run"}),
    # given twice
    ("GET", f"{STUDIES}?limit=1&limit=2", {"limit"}),
    ("GET", f"{STUDIES}/000000000000/optimal-designs?top=1&top=2", {"top"}),
    ("POST", f"{STUDIES}?dry_run=true&dry_run=false", {"dry_run"}),
    ("POST", "/api/v1/designs?dry_run=true&dry_run=true", {"dry_run"}),
    ("POST", "/api/v1/simulate?dry_run=false&dry_run=true", {"dry_run"}),
    # where none is taken
    ("GET", f"{STUDIES}/{{id}}?dry_run=true", {"dry_run"}),
    ("GET", f"{STUDIES}/{{id}}/zarr/zarr.json?dry_run=true", {"dry_run"}),
    ("POST", f"{STUDIES}/{{id}}/cancel?dry_run=true", {"dry_run"}),
    ("DELETE", f"{STUDIES}/{{id}}?dry_run=true", {"dry_run"}),
]


@pytest.mark.parametrize(("method", "path", "fields"), PARAMETERS)
def test_a_parameter_is_refused_under_its_name(
    client: httpx.Client, curve: dict[str, Any], method: str, path: str, fields: set[str]
) -> None:
    body = {} if method == "POST" else None
    document: Any = _problem(client.request(method, path.replace("{id}", curve["id"]), json=body), 422)
    assert {fault["field"] for fault in document["errors"]} == fields
    name, *again = re.findall(r"[?&](\w+)=", path)
    assert ("given more than once" in str(document)) == (name in again)
    assert client.get(f"{STUDIES}/{curve['id']}").status_code == 200


TWICE = '"odd": 1, "odd": 2'


@pytest.mark.parametrize(
    ("method", "path", "body", "field"),
    [
        ("POST", STUDIES, "{%s}", "odd"),
        ("POST", "/api/v1/designs", "{%s}", "odd"),
        ("POST", "/api/v1/simulate", '{"frequency_ratio": 1, "contact": {%s}}', "contact.odd"),
        ("POST", "/api/v1/earthquake-comparisons", "{%s}", "odd"),
        ("POST", "/api/v1/fits", '{"structure": {%s}}', "structure.odd"),
        ("POST", "/api/v1/records", '{"kanai_tajimi": {%s}}', "kanai_tajimi.odd"),
        ("POST", "/api/v1/session", "{%s}", "odd"),
        ("PATCH", f"{STUDIES}/{{id}}", '{"note": "a", %s}', "odd"),
        # these take no body at all
        ("POST", f"{STUDIES}/{{id}}/refine", "{%s}", "body"),
    ],
)
def test_a_key_that_is_given_twice_in_a_body_is_refused(
    client: httpx.Client, curve: dict[str, Any], method: str, path: str, body: str, field: str
) -> None:
    url = path.replace("{id}", curve["id"])
    sent = client.request(method, url, content=body % TWICE, headers={"Content-Type": "application/json"})
    errors: Any = _problem(sent, 422)["errors"]
    assert field in [
        each["field"] for each in errors if "more than once" in each["message"] or field == "body"
    ]


def test_request_id_of_the_client_is_kept_if_it_is_harmless(client: httpx.Client) -> None:
    assert client.get("/health/live", headers={"x-request-id": "abc-1"}).headers["x-request-id"] == "abc-1"
    assert client.get("/health/live", headers={"x-request-id": "a b;c"}).headers["x-request-id"] != "a b;c"


@pytest.mark.parametrize(
    ("query", "found", "allowed"),
    [
        ("limit=0", "0", "at least 1"),
        ("limit=201", "201", "at most 200"),
        ("limit=many", 'the text "many"', "a whole number"),
        ("designs=perhaps", 'the text "perhaps"', "true or false"),
    ],
)
def test_a_parameter_is_refused_with_what_was_found_and_what_is_allowed(
    client: httpx.Client, query: str, found: str, allowed: str
) -> None:
    (fault,) = client.get(f"{STUDIES}?{query}").json()["errors"]
    assert (fault["field"], fault["found"], fault["allowed"]) == (query.partition("=")[0], found, allowed)
    assert fault["message"] == f"`{fault['field']}` must be {allowed}, not {found}."


# what a question itself refuses is in `tests/studies/answers/test_refused.py`
OF_CURVES = [
    ("resonance-map?x=frequency_ratio", "y"),
    ("resonance-map?x=frequency_ratio&y=clearance_m", "y"),
    ("resonance-map?x=friction_ratio&y=mass_ratio&record=loma-prieta", "record"),
    ("frequency-response?damping_ratio=nan", "damping_ratio"),
    ("frequency-response?dampingratio=1", "dampingratio"),
    ("optimal-designs?objective=", "objective"),
    ("optimal-designs?band=0.9,inf", "band"),
    ("optimal-designs?clearance_ratio=4,1e400", "clearance_ratio"),
    ("optimal-designs?top=0", "top"),
    ("optimal-designs?stick_fraction=0.5,0", "stick_fraction"),
    ("optimal-designs?scale=1,2", "scale"),
    ("optimal-designs?pareto=amplitude,mass&with=abc", "with"),
    ("tmd-comparison?clearance=3&mass_ratio=0.1", "clearance"),
    ("tmd-comparison", "mass_ratio"),
    ("work-precision?metric=status", "metric"),
    ("export?format=docx", "format"),
    ("POST refine-boundary?along=frequency_ratio", "boundary"),
]
OF_SUITES = [
    ("frequency-response", "study"),
    ("tmd-comparison", "study"),
    ("work-precision", "study"),
    ("POST refine", "study"),
    ("POST refine-boundary?along=clearance_m", "study"),
    ("resonance-map?x=record&y=scale", "x"),
    ("resonance-map?x=clearance_m&y=scale&record=loma-prieta", "record"),
    ("resonance-map?x=clearance_m&y=scale&metric=amplitude_ratio", "metric"),
    ("resonance-map?x=clearance_m&y=scale&frequency_ratio=1", "frequency_ratio"),
    ("fragility", "threshold"),
    ("optimal-designs?objective=peak", "objective"),
    ("optimal-designs?record=nowhere", "record"),
    ("optimal-designs?clearance_m=5,6", "clearance_m"),
    ("optimal-designs?metric=status", "metric"),
]


@pytest.mark.parametrize(
    ("kind", "query", "field"),
    [("curve", *each) for each in OF_CURVES] + [("suite", *each) for each in OF_SUITES],
)
def test_a_question_that_cannot_be_asked_names_its_parameter(
    client: httpx.Client, curve: dict[str, Any], suite: dict[str, Any], kind: str, query: str, field: str
) -> None:
    method, _, question = query.rpartition(" ")
    study = curve if kind == "curve" else suite
    answer = client.request(method or "GET", f"{STUDIES}/{study['id']}/{question}")
    faults: Any = _problem(answer, 422)["errors"]
    assert all(fault[key] for fault in faults for key in ("found", "allowed", "advice"))
    if field == "study":
        assert "a ground-motion suite" in faults[0]["found"]
    else:
        assert field in {fault["field"] for fault in faults}


PLANNED = {
    "structure": {"mass_kg": 1.7, "natural_frequency_hz": 2.5, "damping_ratio": 0.02},
    "excitation": {"base_amplitude_m": 0.001, "frequency_hz": {"start": 2, "stop": 3}},
    "choose": {"clearance_m": {"start": 0.002, "stop": 0.03}},
    "friction_force_n": 0.1,
    "particle_mass_kg": 0.16,
    "restitution": 0.5,
    "limits": {"cavity_length_m": 0.05},
}
FIT: dict[str, Any] = {
    "measured": "frequency (Hz), amplitude (mm)\n2.4, 5\n2.5, 15\n2.6, 5\n",
    "structure": {
        "particle": False,
        "axes": {"friction_ratio": 0},
        "physical": {"natural_frequency_hz": 2.5, "base_amplitude_m": 0.0015},
    },
    "fit": {"damping_ratio": [0.01, 0.2]},
    "deviation": 0.01,
}
BODIES: list[tuple[str, Any, set[str]]] = [
    ("studies", {"damping_ratio": -1, "axes": {"frequency_ratio": [], "restitution": 2}, "colour": "red"},
     {"damping_ratio", "axes.frequency_ratio", "axes.restitution", "axes.clearance_ratio", "colour"}),
    ("simulate", {"frequency_ratio": 0, "restitution": "high", "cycles": -1, "history": 1e9, "clearence_ratio": 3},
     {"frequency_ratio", "restitution", "cycles", "history", "clearence_ratio"}),
    ("designs", PLANNED | {"restitution": 2, "measure": "noise", "budget_points": 3, "nonsense": 1},
     {"restitution", "measure", "budget_points", "nonsense"}),
    ("earthquake-comparisons", {"record": "nowhere"}, {"record"}),
    ("earthquake-comparisons", {"record": {"kanai_tajimi": {"seed": 1}, "sweep": {}}}, {"record"}),
    ("earthquake-comparisons", {"clearance_m": -1}, {"clearance_m"}),
    ("earthquake-comparisons", {"natural_frequency_hz": 1000, "starts": 256}, {"starts"}),
    ("earthquake-comparisons", {"contact": {"model": "compliant", "contact_time": 0.003}, "restitution": 0}, {"restitution"}),
    ("fits", FIT | {"measured": 3, "fits": {}}, {"measured", "fits"}),
    ("fits", FIT | {"structure": 3, "seed": -1}, {"structure", "seed"}),
    ("fits", FIT | {"specification": {}, "fit": []}, {"specification", "fit"}),
    ("PATCH", {"tags": ["A b"]}, {"tags"}),
    ("PATCH", {"tagz": []}, {"tagz"}),
    ("PATCH", {}, {"remarks"}),
    ("PATCH", {"note": "n" * 4001}, {"note"}),
]  # fmt: skip
"""A body for a route, or for the study itself."""


@pytest.mark.parametrize(("route", "body", "fields"), BODIES)
def test_every_fault_of_a_body_is_named_and_nothing_is_stored(
    client: httpx.Client, curve: dict[str, Any], route: str, body: Any, fields: set[str]
) -> None:
    method, path = ("PATCH", f"{STUDIES}/{curve['id']}") if route == "PATCH" else ("POST", f"/api/v1/{route}")
    before = _ids(client)
    faults: Any = _problem(client.request(method, path, json=body), 422)["errors"]
    assert fields <= {fault["field"] for fault in faults}
    assert all(fault[key] for fault in faults for key in ("field", "found", "allowed", "advice"))
    assert _ids(client) == before


def _ids(client: httpx.Client) -> list[str]:
    return [each["id"] for each in client.get(STUDIES, params={"limit": 200}).json()["studies"]]
