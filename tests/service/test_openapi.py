"""The OpenAPI document: complete and true."""

import json
import re
from typing import Any

import httpx
import jsonschema
import pytest


def _operations(client: httpx.Client) -> dict[tuple[str, str], Any]:
    paths = client.get("/openapi.json").raise_for_status().json()["paths"]
    return {(method, path): found for path, methods in paths.items() for method, found in methods.items()}


def test_every_route_is_described(client: httpx.Client) -> None:
    assert all(operation["summary"] for operation in _operations(client).values())


def test_every_reference_leads_somewhere(client: httpx.Client) -> None:
    document = client.get("/openapi.json").json()
    named = set(re.findall(r'"#/components/schemas/(\w+)"', json.dumps(document)))
    assert named
    assert named <= set(document["components"]["schemas"])


def test_every_example_is_what_its_schema_allows(client: httpx.Client) -> None:
    """A schema that took another one's name would refuse what the service takes."""
    document = client.get("/openapi.json").json()
    tried = 0
    for (_, path), operation in _operations(client).items():
        for kind, content in operation.get("requestBody", {}).get("content", {}).items():
            schema = {**content["schema"], "components": document["components"]}
            for example in content.get("examples", {}).values() if kind == "application/json" else ():
                jsonschema.Draft202012Validator(schema).validate(example["value"])
                tried += "/studies" in path
    assert tried >= 4


@pytest.mark.night
def test_every_example_works_when_pasted(client: httpx.Client, helpers: Any) -> None:
    tried = 0
    lacking = set()
    axes = {"friction_ratio": 0.1, "frequency_ratio": 1.0}
    any_study = client.post(
        "/api/v1/studies", json={"particle": False, "damping_ratio": 0.3, "axes": axes}
    ).json()["id"]
    for (method, template), operation in _operations(client).items():
        path = template.replace("{study_id}", any_study)
        for kind, content in operation.get("requestBody", {}).get("content", {}).items():
            if "examples" not in content:
                lacking.add(path)
            for example in content.get("examples", {}).values():
                text = example["value"] if isinstance(example["value"], str) else json.dumps(example["value"])
                answer = client.request(method, path, content=text, headers={"content-type": kind})
                assert answer.status_code in (200, 201), answer.text
                tried += 1
                if "/studies" in path:
                    record = helpers.wait_for(client, answer.json()["id"], helpers.ended)
                    assert (record["state"], record["points_failed"]) == ("done", 0), record
                elif path.endswith("/designs"):
                    # taken is enough: a named specification has minutes of work, which no other test shall wait for
                    address = f"{path}/{answer.json()['id']}"
                    assert client.post(f"{address}/cancel").json()["state"] == "cancelled"
                    assert client.delete(address).status_code == 204
    assert tried >= 4
    assert lacking == {"/api/v1/session"}  # a key cannot stand in a document


def test_schemas_of_hand_read_bodies_name_every_key_and_its_bounds(client: httpx.Client) -> None:
    """A number beyond each stated bound is refused by its name, and no key is refused as unknown."""
    schemas = client.get("/openapi.json").json()["components"]["schemas"]
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
