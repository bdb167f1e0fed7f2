"""What HTTP adds to answers: units, what is unknown, what is refused, compression; their numbers are in `test_answers`."""

from typing import Any

import httpx
import numpy as np
from tests.oracles.transmissibility import absolute_amplitude
from tests.service.conftest import computed, long_study

STUDIES = "/api/v1/studies"


def test_a_study_in_units_is_asked_in_units(client: httpx.Client, service: Any) -> None:
    hertz = [3.6, 4.0, 4.4]
    structure = {"mass_kg": 2.0, "natural_frequency_hz": 4.0, "base_amplitude_m": 0.003}
    study = {
        "particle": False,
        "damping_ratio": 0.05,
        "axes": {"friction_ratio": 0.0},
        "physical": structure | {"excitation_frequency_hz": hertz},
    }
    record = computed(service, study)

    def ask(question: str) -> dict[str, Any]:
        found: dict[str, Any] = client.get(f"{STUDIES}/{record['id']}/{question}").raise_for_status().json()
        return found

    # in the answer's own name, and in that of the study's physical block
    names = ("frequency_hz", "excitation_frequency_hz")
    answer, same = (ask(f"resonance-map?x={name}&y=friction_force_n") for name in names)
    assert answer == same
    assert (answer["x_dimension"], answer["columns"]["frequency_hz"]["units"]) == ("frequency_hz", "Hz")
    np.testing.assert_allclose(answer["x"], hertz, rtol=1e-15)
    truth = [absolute_amplitude(0.05, f / 4.0) for f in hertz]
    np.testing.assert_allclose(answer["values"][0], truth, rtol=1e-12)
    one, other = (ask(f"optimal-designs?{name}=3.9,4.1") for name in names)
    assert one == other


def test_what_is_not_computed_is_null_and_counted(client: httpx.Client) -> None:
    """A study that waits has a cube without a single value; once it is cancelled, only resuming it helps."""
    blockers = [client.post(STUDIES, json=long_study("block", 0.05 + 0.01 * n)).json() for n in range(2)]
    study = {"name": "never", "particle": False, "damping_ratio": 0.04, "axes": {"frequency_ratio": [1, 2]}}
    record = client.post(STUDIES, json=study).json()
    try:
        answer = client.get(f"{STUDIES}/{record['id']}/frequency-response").raise_for_status().json()
        assert (answer["values"], answer["complete"]) == ([None, None], 0.0)
        assert client.post(f"{STUDIES}/{record['id']}/cancel").json()["state"] == "cancelled"
        for question in (
            "frequency-response",
            "resonance-map?x=frequency_ratio&y=friction_ratio",
            "optimal-designs",
            "optimal-designs?pareto=amplitude,mass",
            "tmd-comparison?mass_ratio=0.1",
            "work-precision",
        ):
            refused = client.get(f"{STUDIES}/{record['id']}/{question}")
            assert refused.status_code == 409, question
            assert refused.headers["content-type"] == "application/problem+json"
            assert f"POST /api/v1/studies/{record['id']}/resume" in refused.json()["detail"]
    finally:
        for blocker in blockers:
            client.post(f"{STUDIES}/{blocker['id']}/cancel")
            client.delete(f"{STUDIES}/{blocker['id']}").raise_for_status()


def test_what_a_study_does_not_store_is_unknown(client: httpx.Client, service: Any) -> None:
    study = {
        "particle": False,
        "damping_ratio": 0.03,
        "axes": {"frequency_ratio": [0.9, 1.0]},
        "metrics": ["amplitude_ratio"],
    }
    record = computed(service, study)
    path = f"{STUDIES}/{record['id']}"
    (design,) = client.get(f"{path}/optimal-designs").raise_for_status().json()["designs"]
    assert (design["error"], design["response_class"], design["locked_share"]) == (None, "unknown", None)
    tmd = client.get(f"{path}/tmd-comparison?mass_ratio=0.1").raise_for_status().json()
    assert tmd["hybrid_peak_error"] is None


def test_answers_are_compressed_on_request(client: httpx.Client, curve: dict[str, Any]) -> None:
    address = f"{STUDIES}/{curve['id']}/axes"  # the record of a study that has just ended may change
    squeezed = client.get(address, headers={"accept-encoding": "gzip"})
    plain = client.get(address, headers={"accept-encoding": "identity"})
    assert squeezed.headers.get("content-encoding") == "gzip"
    assert "content-encoding" not in plain.headers
    assert squeezed.json() == plain.json()
    for refused in ("gzip;q=0", "br, gzip; q=0.000", "GZIP;Q=0"):
        answer = client.get(address, headers={"accept-encoding": refused})
        assert "content-encoding" not in answer.headers, refused
    for taken in ("gzip;q=0.001", "br;q=0, gzip"):
        answer = client.get(address, headers={"accept-encoding": taken})
        assert answer.headers.get("content-encoding") == "gzip", taken


def test_decimated_history_keeps_the_extremes(client: httpx.Client) -> None:
    point = {"particle": False, "damping_ratio": 0.05, "frequency_ratio": 1.0, "cycles": 20, "history": 20}
    full = client.post("/api/v1/simulate", json=point | {"samples": 20_000}).json()["history"]["u"]
    thin = client.post("/api/v1/simulate", json=point | {"samples": 40}).json()["history"]["u"]
    assert len(thin) <= 40 < len(full)
    assert (max(thin), min(thin)) == (max(full), min(full))
