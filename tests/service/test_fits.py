"""Fits over HTTP and from Python: the same numbers as the command's, and the truth within their intervals."""

import json
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
import yaml
from tests.service.cli.commands import run

from damperlab.service.client import Client, Refused
from damperlab.service.client.fit import question
from damperlab.service.fit_report import parameter_rows
from damperlab.studies.fit.fitted import Estimate
from damperlab.studies.reading import parse_study_text
from damperlab.studies.tmd.transfer import without_absorber

FITS = "/api/v1/fits"
ZETA = 0.05
STRUCTURE = {
    "particle": False,
    "axes": {"friction_ratio": 0},
    "physical": {"natural_frequency_hz": 2.5, "base_amplitude_m": 0.0015},
}


@pytest.fixture(scope="module")
def table() -> str:
    """A response in closed form, with 1 % of noise."""
    noise = np.random.default_rng(7).standard_normal(21)
    rows = ["frequency (Hz), amplitude (mm)"]
    for r, off in zip(np.linspace(0.9, 1.1, 21), noise, strict=True):
        rows.append(f"{2.5 * r:.6f}, {1.5 * float(without_absorber(r, ZETA)) * (1 + 0.01 * off):.6f}")
    return "\n".join(rows) + "\n"


def asked(table: str, **changes: Any) -> dict[str, Any]:
    whole = {
        "measured": table,
        "name": "bench",
        "structure": STRUCTURE,
        "fit": {"damping_ratio": [0.01, 0.2]},
        "deviation": 0.01,
    }
    return whole | changes


def test_every_door_gives_the_same_fit_and_it_holds_the_truth(
    service: Any, table: str, tmp_path: Path
) -> None:
    (tmp_path / "bench.csv").write_text(table)
    ranges = {"damping_ratio": (0.01, 0.2)}
    in_file, in_text = (
        question(each, ranges, STRUCTURE, deviation=0.01) for each in (tmp_path / "bench.csv", table)
    )
    assert in_text | {"name": "bench"} == in_file == asked(table)
    with Client(service.url) as mine:
        found = mine.fit(tmp_path / "bench.csv", ranges, STRUCTURE, deviation=0.01)
        with pytest.raises(Refused, match=r"missing\.csv"):
            mine.fit("missing.csv", ["damping_ratio"])
        with pytest.raises(Refused) as swapped:
            mine.fit(table, STRUCTURE, ["damping_ratio"])  # type: ignore[arg-type]
    assert {fault.field for fault in swapped.value.faults} == {
        "structure",
        *(f"fit.{name}" for name in STRUCTURE),
    }
    damping = found["parameters"]["damping_ratio"]
    # twice an interval of 95 % is four standard errors to either side
    assert abs(damping["value"] - ZETA) < damping["high"] - damping["low"]
    study, report = tmp_path / "fitted.yaml", tmp_path / "fit.html"
    sought = (
        "--fit",
        "damping_ratio=0.01,0.2",
        "--deviation",
        "1%",
        "--no-particle",
        "--friction-ratio",
        "0",
    )
    known = ("--natural-frequency-hz", "2.5", "--base-amplitude-m", "0.0015")
    written = ("--study", study, "-o", report, "--json")
    assert json.loads(run("fit", tmp_path / "bench.csv", *sought, *known, *written).stdout) == found
    assert "<h1>bench, fitted</h1>" in report.read_text()
    assert yaml.safe_load(study.read_text()) == found["study"]
    assert parse_study_text(study.read_text(), "yaml").damping_ratio == damping["value"]


def test_an_axis_in_the_file_of_what_is_known_is_sought(table: str, tmp_path: Path) -> None:
    (tmp_path / "bench.csv").write_text(table)
    known = STRUCTURE | {"damping_ratio": {"start": 0.01, "stop": 0.2, "num": 5}}
    (tmp_path / "known.json").write_text(json.dumps(known))
    figure = tmp_path / "fit.png"
    sought = ("--structure", tmp_path / "known.json", "--deviation", "1%", "-o", figure, "--json")
    document = json.loads(run("fit", tmp_path / "bench.csv", *sought).stdout)
    assert document["parameters"]["damping_ratio"]["range"] == [0.01, 0.2]
    assert figure.read_bytes().startswith(b"\x89PNG\r\n\x1a\n")


def test_a_dry_run_says_whether_kernels_are_there(client: httpx.Client, table: str) -> None:
    answer = client.post(FITS, json=asked(table), params={"dry_run": True}).raise_for_status().json()
    assert answer["phase"] in ("ready", "compiling")


def test_only_a_length_is_reported_in_millimetres() -> None:
    rows = parameter_rows(
        [
            Estimate(name, 0.5, 0.4, 0.6, 0.05, 0.0, 1.0, 0.4, 0.6)
            for name in ("clearance_m", "damping_n_s_per_m")
        ]
    )
    assert [each[:2] for each in rows] == [("clearance [mm]", "500"), ("damping_n_s_per_m", "0.5")]


def test_a_time_history_is_fitted_and_one_without_a_predictable_stretch_is_refused(
    client: httpx.Client,
) -> None:
    noise = np.random.default_rng(1).standard_normal(200)
    time = 0.02 * np.arange(200)
    own = 2 * np.pi * 2.5 * np.sqrt(1 - ZETA**2)
    swing = np.exp(-ZETA * 2 * np.pi * 2.5 * time)
    moved = 20 * swing * (np.cos(own * time) + ZETA / np.sqrt(1 - ZETA**2) * np.sin(own * time))
    structure = {
        "particle": False,
        "physical": {"natural_frequency_hz": 2.5, "friction_force_n": 0, "mass_kg": 1},
    }

    def history(values: np.ndarray) -> str:
        return "\n".join(
            ["time (s), x (mm)", *(f"{t:.2f}, {x:.5f}" for t, x in zip(time, values, strict=True))]
        )

    answer = client.post(FITS, json=asked(history(moved + 0.1 * noise), structure=structure, deviation=0.005))
    assert answer.status_code == 200, answer.text
    found = answer.json()
    damping = found["parameters"]["damping_ratio"]
    assert abs(damping["value"] - ZETA) < damping["high"] - damping["low"] < 0.1 * ZETA
    assert found["rows_counted"] == 200
    assert found["study"]["damping_ratio"] == damping["value"]
    wild = noise.copy()
    wild[0] = 1.2 * np.abs(noise).max()
    answer = client.post(FITS, json=asked(history(wild), structure=structure, deviation=0.005))
    assert answer.status_code == 422
    assert "No parameters within their ranges describe even the first" in answer.text
