"""The OpenAPI document is a contract: complete and true, what it promised is kept, and every answer is as it says."""

import copy
import functools
import json
import re
from typing import Any

import httpx
import pytest
from jsonschema import Draft202012Validator
from tests.service.conftest import SPECIFICATION, ended, wait_for
from tests.service.contract import check, document_now, promised, promised_before
from tests.service.contract.breaks import breaks

STUDY = "/api/v1/studies/{study_id}"


@pytest.fixture(scope="module")
def document() -> dict[str, Any]:
    return document_now()


def test_nothing_that_clients_rely_on_is_gone(document: dict[str, Any]) -> None:
    assert breaks(promised_before(), promised(document)) == []


GONE = object()
RECORD = ("components", "schemas", "Record")
POINT_SCHEMA = ("components", "schemas", "Simulation")
MAP = ("paths", f"{STUDY}/resonance-map", "get")
CONTACTS = [{"$ref": f"#/components/schemas/{kind}Contact"} for kind in ("Instant", "Dwell", "Compliant")]
CHANGES: list[tuple[tuple[str, ...], Any, str]] = [
    (("paths", STUDY, "delete"), GONE, "delete: gone"),
    ((*MAP, "responses", "200"), GONE, "200: gone"),
    ((*MAP, "parameters"), [], "parameters: gone"),
    ((*POINT_SCHEMA, "properties", "contact", "anyOf"), [{"type": "string"}] * 4, "no longer"),
    ((*RECORD, "required"), ["name"], "points_done may be missing now"),
    ((*RECORD, "properties", "points_done"), GONE, "points_done: gone"),
    ((*RECORD, "properties", "points_done", "type"), "string", "string in place of integer"),
    ((*RECORD, "properties", "state", "enum"), GONE, "state enum: gone"),
    ((*POINT_SCHEMA, "required"), ["cycles"], "cycles must be given now"),
    ((*POINT_SCHEMA, "properties", "history", "maximum"), 9, "maximum: 9 in place of"),
    ((*POINT_SCHEMA, "properties", "method", "enum"), ["event"], "no longer rk4"),
    ((*POINT_SCHEMA, "properties", "history", "exclusiveMinimum"), 0, "exclusiveMinimum: 0 in place of none"),
    (("components", "schemas", "Catalog"), {"type": "array"}, "array in place of object"),
    # what is only added breaks nobody
    (("paths", "/api/v1/new"), {"get": {"responses": {}}}, ""),
    ((*RECORD, "properties", "novelty"), {"type": "string"}, ""),
    ((*POINT_SCHEMA, "properties", "novelty"), {"type": "boolean"}, ""),
    ((*MAP, "responses", "418"), {"description": "I am a teapot"}, ""),
    ((*POINT_SCHEMA, "properties", "contact", "anyOf"), [*CONTACTS, {"type": "string"}], ""),
    ((*POINT_SCHEMA, "properties", "method", "enum"), ["event", "rk4", "other"], ""),
]


@pytest.mark.parametrize(("place", "value", "said"), CHANGES)
def test_what_breaks_clients_is_found(
    document: dict[str, Any], place: tuple[str, ...], value: Any, said: str
) -> None:
    asked = {path: document["paths"][path] for path in (STUDY, MAP[1], "/api/v1/simulate", "/api/v1/catalog")}
    before = document | {"paths": asked}
    changed = copy.deepcopy(before)
    *way, last = place
    within = functools.reduce(dict.__getitem__, way, changed)
    within.pop(last, None)
    if value is not GONE:
        within[last] = value
    assert changed != before
    found = breaks(promised(before), promised(changed))
    assert any(said in line for line in found) if said else not found, found


def test_every_json_answer_has_a_schema_and_every_refusal_is_a_problem(document: dict[str, Any]) -> None:
    for (method, path), operation in _operations(document).items():
        for status, response in operation["responses"].items():
            for kind, content in response.get("content", {}).items():
                place = f"{method} {path} {status} {kind}"
                if kind == "application/problem+json":
                    assert int(status) >= 400, place
                    assert content["schema"] == {"$ref": "#/components/schemas/Problem"}, place
                elif kind == "application/json" and "{key}" not in path:
                    name = content["schema"]["$ref"].rpartition("/")[2]
                    assert name in document["components"]["schemas"], place


POINT = {"frequency_ratio": 1.0, "particle": False, "friction_ratio": 0.1}
FIT = {
    "measured": "frequency ratio, X/Z\n0.9, 5.2\n1.0, 49.8\n1.1, 4.8\n",
    "structure": {"particle": False, "axes": {"friction_ratio": 0}},
    "fit": {"damping_ratio": [0.001, 0.1]},
    "deviation": 0.05,
}
CHEAP: list[tuple[str, str, dict[str, Any]]] = [
    ("get", "/api/v1/catalog", {}),
    ("get", "/api/v1/records", {}),
    ("get", "/api/v1/accuracy/reports", {}),
    ("get", "/api/v1/session", {}),
    ("get", "/api/v1/studies", {}),
    ("get", "/health/live", {}),
    ("get", "/health/ready", {}),
    ("post", "/api/v1/simulate", {"json": POINT}),
    ("post", "/api/v1/simulate", {"json": POINT | {"cycles": 2, "history": 2}}),
    ("post", "/api/v1/simulate", {"json": POINT | {"starts": 3}}),
    ("post", "/api/v1/simulate", {"json": POINT, "params": {"dry_run": True}}),
    ("post", "/api/v1/studies", {"json": {"particle": False, "axes": {"frequency_ratio": 1}}, "params": {"dry_run": True}}),
    ("post", "/api/v1/studies", {"json": [{"particle": False, "axes": {"frequency_ratio": 1}}], "params": {"dry_run": True}}),
    ("post", "/api/v1/records", {"json": {"kanai_tajimi": {"seed": 4, "duration_s": 20, "peak_g": 0.1}}}),
    ("post", "/api/v1/earthquake-comparisons", {"json": {"record": "northridge", "cases": ["none", "tmd", "fd"]}}),
    ("post", "/api/v1/earthquake-comparisons", {"json": {"cases": ["fd"], "starts": 2}, "params": {"samples": 20}}),
    ("post", "/api/v1/earthquake-comparisons", {"json": {}, "params": {"dry_run": True}}),
    ("post", "/api/v1/fits", {"json": FIT}),
    ("post", "/api/v1/fits", {"json": FIT, "params": {"dry_run": True}}),
]  # fmt: skip
OF_A_CURVE: list[tuple[str, str, dict[str, Any]]] = [
    ("get", STUDY, {}),
    ("get", f"{STUDY}/versions", {}),
    ("get", f"{STUDY}/axes", {}),
    ("get", f"{STUDY}/resonance-map", {"x": "frequency_ratio", "y": "friction_ratio"}),
    ("get", f"{STUDY}/resonance-map", {"x": "frequency_ratio", "y": "friction_ratio", "metric": "status", "most": 2}),
    ("get", f"{STUDY}/frequency-response", {}),
    ("get", f"{STUDY}/optimal-designs", {}),
    ("get", f"{STUDY}/tmd-comparison", {"mass_ratio": 0.1}),
    ("get", f"{STUDY}/work-precision", {}),
]  # fmt: skip
OF_A_SUITE: list[tuple[str, str, dict[str, Any]]] = [
    ("get", f"{STUDY}/axes", {}),
    ("get", f"{STUDY}/resonance-map", {"x": "clearance_m", "y": "friction_force_n"}),
    ("get", f"{STUDY}/optimal-designs", {}),
    ("get", f"{STUDY}/fragility", {"threshold": 0.02}),
]


def test_answers_are_as_their_schemas_say(
    client: httpx.Client,
    curve: dict[str, Any],
    suite: dict[str, Any],
) -> None:
    for method, path, sent in CHEAP:
        check(method, path, client.request(method, path, **sent))
    for study, asked in ((curve, OF_A_CURVE), (suite, OF_A_SUITE)):
        for method, path, parameters in asked:
            address = path.replace("{study_id}", study["id"])
            check(method, path, client.request(method, address, params=parameters))
    shown = client.get("/api/v1/records/northridge-360", params={"samples": 20})
    check("get", "/api/v1/records/{record_id}", shown)
    again = client.post("/api/v1/studies", json=curve["definition"])
    assert again.status_code == 200
    check("post", "/api/v1/studies", again)


def _operations(document: dict[str, Any]) -> dict[tuple[str, str], Any]:
    paths = document["paths"].items()
    return {(method, path): found for path, methods in paths for method, found in methods.items()}


def test_every_route_is_described_and_every_reference_leads_somewhere(
    client: httpx.Client, document: dict[str, Any]
) -> None:
    assert client.get("/openapi.json").raise_for_status().json() == document
    assert all(operation["summary"] for operation in _operations(document).values())
    named = set(re.findall(r'"#/components/schemas/(\w+)"', json.dumps(document)))
    assert named
    assert named <= set(document["components"]["schemas"])


def test_every_example_is_what_its_schema_allows(document: dict[str, Any]) -> None:
    """A schema that took another one's name would refuse what the service takes."""
    tried = 0
    for (_, path), operation in _operations(document).items():
        for kind, content in operation.get("requestBody", {}).get("content", {}).items():
            schema = {**content["schema"], "components": document["components"]}
            for example in content.get("examples", {}).values() if kind == "application/json" else ():
                Draft202012Validator(schema).validate(example["value"])
                tried += "/studies" in path
    assert tried >= 4


@pytest.mark.night
def test_every_example_works_when_pasted(client: httpx.Client, document: dict[str, Any]) -> None:
    tried, lacking = 0, set()
    axes = {"friction_ratio": 0.1, "frequency_ratio": 1.0}
    study = {"particle": False, "damping_ratio": 0.3, "axes": axes}
    any_study = client.post("/api/v1/studies", json=study).json()["id"]
    specification = SPECIFICATION | {"clearance_m": 0.0058}
    any_design = client.post("/api/v1/designs", json=specification).json()["id"]
    client.post(f"/api/v1/designs/{any_design}/cancel").raise_for_status()
    for (method, template), operation in _operations(document).items():
        path = template.replace("{study_id}", any_study).replace("{design_id}", any_design)
        for kind, content in operation.get("requestBody", {}).get("content", {}).items():
            if "examples" not in content:
                lacking.add(path)
            for example in content.get("examples", {}).values():
                text = example["value"] if isinstance(example["value"], str) else json.dumps(example["value"])
                answer = client.request(method, path, content=text, headers={"content-type": kind})
                assert answer.status_code in (200, 201), answer.text
                tried += 1
                if "/studies" in path:
                    record = wait_for(client, answer.json()["id"], ended)
                    assert (record["state"], record["points_failed"]) == ("done", 0), record
                elif path.endswith("/designs"):
                    # taken is enough: a named specification has minutes of work, which no other test shall wait for
                    address = f"{path}/{answer.json()['id']}"
                    assert client.post(f"{address}/cancel").json()["state"] == "cancelled"
                    assert client.delete(address).status_code == 204
    client.delete(f"/api/v1/designs/{any_design}").raise_for_status()
    assert tried >= 4
    assert lacking == {"/api/v1/session"}  # a key cannot stand in a document


def test_schemas_of_hand_read_bodies_name_every_key_and_its_bounds(
    client: httpx.Client, document: dict[str, Any]
) -> None:
    """A number beyond each stated bound is refused by its name, and no key is refused as unknown."""
    schemas = document["components"]["schemas"]
    for path, name, whole in (
        ("simulate", "Simulation", {"frequency_ratio": 1.0, "clearance_ratio": 5.0}),
        ("earthquake-comparisons", "EarthquakeComparison", {}),
    ):
        properties = schemas[name]["properties"]
        bounded = {key: one["maximum"] for key, one in properties.items() if "maximum" in one}
        assert len(bounded) >= 5
        beyond = whole | {key: 2 * most + 1 for key, most in bounded.items()}
        answer = client.post(f"/api/v1/{path}", json=beyond)
        assert answer.status_code == 422
        assert {fault["field"] for fault in answer.json()["errors"]} == set(bounded)
        unknown = client.post(f"/api/v1/{path}", json=dict.fromkeys(properties) | {"nonsense": 1}).json()
        strangers = [fault["field"] for fault in unknown["errors"] if "nonsense" in fault["field"]]
        assert strangers == ["nonsense"]
        assert not [
            fault
            for fault in unknown["errors"]
            if "unknown" in fault["found"] and fault["field"] in properties
        ]
