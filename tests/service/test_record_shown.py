"""A record over HTTP: its samples, thinned or not, and a spectrum that agrees with the march of the structure itself."""

import httpx
import numpy as np
import pytest


def test_a_record_is_shown_with_its_spectrum(client: httpx.Client) -> None:
    whole = client.get("/api/v1/records/northridge", params={"samples": 400_000}).raise_for_status().json()
    assert len(whole["time_s"]) == whole["samples"]
    assert np.abs(whole["acceleration_m_s2"]).max() == pytest.approx(whole["peak_acceleration_m_s2"])
    thin = client.get(f"/api/v1/records/{whole['id']}", params={"samples": 50}).raise_for_status().json()
    assert len(thin["time_s"]) <= 50
    assert max(thin["acceleration_m_s2"]) == max(whole["acceleration_m_s2"])
    assert min(thin["acceleration_m_s2"]) == min(whole["acceleration_m_s2"])
    assert thin["pseudo_acceleration_m_s2"] == whole["pseudo_acceleration_m_s2"]

    period, heard = np.array(whole["period_s"]), np.array(whole["pseudo_acceleration_m_s2"])
    for place in (40, 60):
        frequency = 1 / period[place]
        asked = {
            "record": whole["id"],
            "natural_frequency_hz": frequency,
            "damping_ratio": whole["damping_ratio"],
            "cases": ["none"],
            "starts": 0,
        }
        answer = (
            client.post("/api/v1/earthquake-comparisons", json=asked, timeout=300.0).raise_for_status().json()
        )
        peak = answer["cases"]["none"]["peak_relative_displacement_m"]
        # the spectrum looks at samples alone: at most a share of (ω h)²/8 below
        share = (2 * np.pi * frequency * whole["step_s"]) ** 2 / 8
        assert (1 - share) * peak <= heard[place] / (2 * np.pi * frequency) ** 2 <= peak * (1 + 1e-9)


def test_a_record_that_is_not_there_is_not_shown(client: httpx.Client) -> None:
    assert client.get("/api/v1/records/nowhere").status_code == 404
    assert client.get("/api/v1/records/northridge", params={"samples": 1}).status_code == 422
