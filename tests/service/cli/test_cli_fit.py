"""The command fit, run as users run it."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml
from tests.service.cli.commands import run

from damperlab.studies.definition import Study
from damperlab.studies.reading import read_study
from damperlab.studies.specification.reading import read_specification
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


SOUGHT = ("--fit", "damping_ratio=0.01,0.2", "--fit", "natural_frequency_hz=2.3,2.7")
BARE = ("--no-particle", "--friction-ratio", "0", "--base-amplitude-m", str(BASE_MM / 1e3))
PLANNED = {
    "name": "planned",
    "structure": {"mass_kg": 1.7, "natural_frequency_hz": 2.4, "damping_ratio": 0.02},
    "excitation": {"base_amplitude_m": 0.0015, "frequency_hz": 2.5},
    "choose": {"clearance_m": [0.004, 0.008, 0.016]},
    "friction_force_n": 0.0,
    "particle_mass_kg": 0.16,
    "restitution": 0.5,
    "tolerances": {"clearance_m": 0.0005},
    "measure": "worst_displacement",
    "budget_points": 300,
    "builds": 2,
}


def test_a_fit_makes_a_specification_that_is_accepted(measured: Path, tmp_path: Path) -> None:
    anew = tmp_path / "anew.yaml"
    ended = run("fit", measured, *SOUGHT, *BARE, "--mass-kg", "1.6", "--specification", anew)
    assert f"Wrote {anew}; `damperlab design {anew}` searches a damper for it." in ended.stderr
    guessed = "Guessed are the clearance, the friction force, the mass of the particle and the restitution"
    assert guessed in ended.stdout
    assert "GUESS, to be edited: 1 to 20 times the amplitude of the base" in anew.read_text()
    dry = run("design", anew, "--dry-run").stdout
    assert dry.startswith("bench, corrected is complete. Chosen: clearance_m, friction_force_n.")
    asked = read_specification(str(anew))
    for name, true in (("damping_ratio", ZETA), ("natural_frequency_hz", NATURAL_HZ)):
        value = getattr(asked.structure, name)
        # twice an interval of 95 % is four standard deviations
        assert abs(value - true) <= 2 * asked.tolerances[name].of(value) < 0.1 * true


@pytest.mark.night
def test_a_fit_corrects_a_specification_and_a_design_of_it_runs(measured: Path, tmp_path: Path) -> None:
    planned, corrected = tmp_path / "planned.json", tmp_path / "corrected.json"
    planned.write_text(json.dumps(PLANNED))
    ended = run("fit", measured, *SOUGHT, *BARE, "--correct", planned, "--specification", corrected, "--json")
    document, answer = json.loads(corrected.read_text()), json.loads(ended.stdout)
    assert answer["specification"] == document
    assert answer["specification_words"][0] == (
        "Replaced by what was measured, or is known with it: the natural frequency, the damping ratio and the friction force."
    )
    structure = document["structure"]
    assert structure["mass_kg"] == 1.7
    assert abs(structure["damping_ratio"] - ZETA) < 0.05 * ZETA
    assert set(document["tolerances"]) == {"clearance_m", "natural_frequency_hz", "damping_ratio"}
    kept = {name: document[name] for name in PLANNED if name not in ("structure", "tolerances")}
    assert PLANNED | kept == PLANNED
    ended = run("design", corrected, "--data-dir", tmp_path / "data", "--json")
    assert json.loads(ended.stdout)["design"]["particle_mass_kg"] == 0.16


def test_what_was_measured_is_told_where_it_allows_no_corrected_specification(
    measured: Path, tmp_path: Path
) -> None:
    planned, corrected = tmp_path / "planned.json", tmp_path / "corrected.json"
    planned.write_text(json.dumps(PLANNED | {"limits": {"friction_force_n": 1e-4}}))
    rubs = ["0.001" if each == "0" else each for each in BARE]  # which is 6e-4 N
    ended = run("fit", measured, *SOUGHT, *rubs, "--correct", planned, "--specification", corrected, status=2)
    assert "Intervals of 95 %" in ended.stdout
    assert "friction_force_n" in ended.stderr
    assert not corrected.exists()
