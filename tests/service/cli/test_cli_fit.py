"""The command fit, run as users run it."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml
from tests.service.cli.commands import run

from damperlab.studies.definition import Study
from damperlab.studies.reading import read_study
from damperlab.studies.tmd.transfer import without_absorber

ZETA = 0.05
BASE_MM = 1.5
NATURAL_HZ = 2.5
KNOWN = (
    "--no-particle",
    "--friction-ratio",
    "0",
    "--natural-frequency-hz",
    str(NATURAL_HZ),
    "--base-amplitude-m",
    str(BASE_MM / 1e3),
)


@pytest.fixture
def measured(tmp_path: Path) -> Path:
    """Write a response in closed form, with 1 % of noise."""
    path = tmp_path / "bench.csv"
    noise = np.random.default_rng(7).standard_normal(21)
    rows = ["frequency (Hz), amplitude (mm), deviation (%)"]
    for r, off in zip(np.linspace(0.9, 1.1, 21), noise, strict=True):
        amplitude = BASE_MM * float(without_absorber(r, ZETA)) * (1 + 0.01 * off)
        rows.append(f"{r * NATURAL_HZ:.6f}, {amplitude:.6f}, 1")
    path.write_text("\n".join(rows) + "\n")
    return path


def test_a_fit_is_a_table_and_sentences_a_document_a_study_and_a_figure(
    measured: Path, tmp_path: Path
) -> None:
    study, figure, report = (tmp_path / name for name in ("fitted.yaml", "fit.png", "fit.html"))
    sought = ("--fit", "damping_ratio=0.01,0.2")
    ended = run("fit", measured, *sought, *KNOWN, "--study", study, "-o", figure)
    assert "damping_ratio" in ended.stdout
    assert "The model agrees with the measurement: chi-square is" in ended.stdout
    assert "20 degrees of freedom" in ended.stdout
    assert figure.read_bytes().startswith(b"\x89PNG\r\n\x1a\n")

    document = json.loads(run("fit", measured, *sought, *KNOWN, "--json", "-o", report).stdout)
    found = document["parameters"]["damping_ratio"]
    # Twice the half interval is four standard errors.
    assert abs(found["value"] - ZETA) < found["high"] - found["low"]
    assert found["determined"]
    assert document["units"] == {"frequency": "Hz", "amplitude": "m"}
    assert len(document["rows"]) == 21
    assert document["rows"][0]["measured"] == pytest.approx(document["rows"][0]["model"], rel=0.06)
    text = report.read_text()
    assert "<h1>bench, fitted</h1>" in text
    assert "http://" not in text.replace("http://www.w3.org", "")

    definition = read_study(str(study))
    assert isinstance(definition, Study)
    assert definition.coordinates["damping_ratio"] == [found["value"]]
    assert definition.coordinates["frequency_ratio"][[0, -1]] == pytest.approx([0.9, 1.1], rel=1e-12)
    assert document["study"] == yaml.safe_load(study.read_text())
    ended = run("run", study, "--data-dir", tmp_path / "data", "--json")
    assert json.loads(ended.stdout)["state"] == "done"


def test_a_file_says_what_is_known_and_an_axis_in_it_is_sought(measured: Path, tmp_path: Path) -> None:
    known = tmp_path / "known.yaml"
    known.write_text(
        "particle: false\naxes: {friction_ratio: 0}\n"
        "physical: {natural_frequency_hz: 2.5, base_amplitude_m: 0.0015}\n"
        "damping_ratio: {start: 0.01, stop: 0.2, num: 5}\n"
    )
    document = json.loads(run("fit", measured, "--structure", known, "--json").stdout)
    assert document["parameters"]["damping_ratio"]["range"] == [0.01, 0.2]
