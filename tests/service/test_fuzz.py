"""No request about a point or a study, however odd, gets a 500; documents of studies are drawn in studies/test_definition."""

import json
from typing import Any
from urllib.parse import quote

import httpx
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

MANY = settings(
    max_examples=40,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
    derandomize=True,
)
HEADERS = {"content-type": "application/json"}

scalars = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=20),
    st.sampled_from([1e308, -0.0, 10**400, "rest", "linear", "\ud800", "\x00", "amplitude_ratio"]),
)
documents = st.recursive(
    scalars,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=12), inner, max_size=4),
    max_leaves=12,
)
points = st.dictionaries(
    st.sampled_from(
        ["damping_ratio", "frequency_ratio", "clearance_ratio", "particle", "history", "samples", "method"]
    ),
    documents,
).map(lambda point: {"cycles": 1, **point})


def _as_it_should_be(answer: httpx.Response) -> None:
    assert answer.status_code < 500, answer.text
    if answer.status_code >= 400:
        assert answer.headers["content-type"] == "application/problem+json"
        problem = answer.json()
        assert problem["status"] == answer.status_code
        for fault in problem.get("errors", []):
            assert all(isinstance(fault[key], str) for key in ("field", "found", "allowed", "advice"))


@MANY
@given(document=points)
def test_any_json_as_a_design_point(client: httpx.Client, document: Any) -> None:
    _as_it_should_be(client.post("/api/v1/simulate", content=json.dumps(document), headers=HEADERS))


@MANY
@given(
    query=st.sampled_from(["resonance-map", "frequency-response", "optimal-designs", "export"]),
    parameters=st.dictionaries(
        st.sampled_from(
            ["x", "y", "metric", "over", "reduce", "band", "top", "objective", "damping_ratio", "format"]
        )
        | st.text(max_size=8),
        st.sampled_from(
            ["frequency_ratio", "damping_ratio", "restitution", "amplitude_ratio", "status", "peak"]
        )
        | st.sampled_from(
            ["max", "mean", "1", "0.9,1.1", "1e400", "-1", "nan", "csv", "10001", "9" * 5000, "1,nan"]
        )
        | st.text(max_size=8),
        max_size=5,
    ),
)
def test_any_question(
    client: httpx.Client, curve: dict[str, Any], query: str, parameters: dict[str, str]
) -> None:
    if query == "export":
        parameters["format"] = parameters.get("format", "csv")
    pairs = {
        quote(name.encode("utf-8", "surrogatepass")): quote(value.encode("utf-8", "surrogatepass"))
        for name, value in parameters.items()
    }
    text = "&".join(f"{name}={value}" for name, value in pairs.items())
    _as_it_should_be(client.get(f"/api/v1/studies/{curve['id']}/{query}?{text}"))
