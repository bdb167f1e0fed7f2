"""What questions about designs print, and what `refine` computes, on friction alone, whose truth is known."""

import json
import math
import shlex
from pathlib import Path
from typing import Any

import pytest
from tests.service.cli.commands import run

DAMPING = 0.02
FRICTION: dict[str, Any] = {
    "name": "friction",
    "particle": False,
    "damping_ratio": DAMPING,
    "axes": {
        "friction_ratio": {"start": 0.1, "stop": 0.4, "num": 5, "spacing": "log"},
        "frequency_ratio": [0.97, 1.0, 1.03],
    },
}


@pytest.fixture(scope="module")
def data_dir(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("designs")
    (folder / "friction.json").write_text(json.dumps(FRICTION))
    run("run", folder / "friction.json", "--data-dir", folder / "data")
    return folder / "data"


def test_a_ranking_shows_every_axis_of_the_study_also_where_all_ranks_share_its_value(data_dir: Path) -> None:
    among = ["friction", "--within", "friction_ratio=0.1,0.15", "--data-dir", data_dir]
    head, *rows = run("optimum", *among, "--top", "2", "--details").stdout.splitlines()[-3:]
    assert head.split()[:4] == ["friction_ratio", "γ_F", "frequency_ratio", "r"]
    # without a stop the response is largest at the frequency nearest to resonance
    assert {row.split()[1] for row in rows} == {"1"}
    assert "damping_ratio" not in head  # of one value


def test_every_question_about_frequencies_that_may_miss_the_peak_advises_those_that_see_it(
    tmp_path: Path,
) -> None:
    """Without a stop friction of 0.1 leaves a resonance of 1/(2ζ) about; with ζ = 0.02 two frequencies see nothing of it."""
    axes = {"friction_ratio": [0.05, 0.1], "frequency_ratio": [0.8, 1.25]}
    study = {**FRICTION, "name": "ends", "damping_ratio": [DAMPING, 0.1], "axes": axes}
    (tmp_path / "study.json").write_text(json.dumps(study))
    data = ("--data-dir", tmp_path / "data")
    run("run", tmp_path / "study.json", *data)
    run("report", "ends", *data, "-o", tmp_path / "ends.html")
    # a step of a quarter of 2ζ: 0.45 in 45
    advised = "frequency_ratio: {start: 0.8, stop: 1.25, num: 46}"
    assert advised in (tmp_path / "ends.html").read_text()
    for question in (
        ["optimum", "ends"],
        ["map", "ends", "--x", "friction_ratio", "--y", "damping_ratio"],
        ["tmd", "ends", "--mass-ratio", "0.1", "--at", "damping_ratio=0.02"],
    ):
        assert advised in run(*question, "--details", *data).stdout, question
    assert advised not in run("optimum", "ends", "--objective", "band_mean", "--details", *data).stdout


def test_refine_computes_follow_ups_until_the_optimum_is_known(tmp_path: Path) -> None:
    axes = {"friction_ratio": {"start": 0.5, "stop": 1.1, "num": 4}, "frequency_ratio": [0.9, 1.0, 1.1, 1.2]}
    study = tmp_path / "locking.json"
    study.write_text(json.dumps({**FRICTION, "name": "locking", "axes": axes}))
    run("run", study, "--data-dir", tmp_path / "data")
    asked = ["refine", "locking", "--tolerance", "0.03", "--data-dir", tmp_path / "data", "--workers", "1"]
    document = json.loads(run(*asked, "--json").stdout)
    assert document["known"] is True
    assert document["steps"]["friction_ratio"] <= 0.03 * (1 + 1e-9)
    (follow_up,) = document["with"]
    # one round: 17 values between the neighbours of the best of four
    assert document["fine_points"] == (math.ceil(0.6 / 0.03) + 1) * 4
    merged = run("optimum", "locking", "--with", follow_up, "--data-dir", tmp_path / "data", "--json").stdout
    best = json.loads(merged)["designs"][0]
    assert best["value"] == document["found"]["value"]
    assert best["study"] == follow_up
    alone = json.loads(run("optimum", "locking", "--data-dir", tmp_path / "data", "--json").stdout)
    assert best["value"] < alone["designs"][0]["value"]
    # again: everything is known, and nothing is computed
    text = run(*asked, "--details").stdout
    assert follow_up in text
    assert f"{best['friction_ratio']:.6g}" in text
    # the next command finds the study where this one found it
    (step,) = [line for line in text.splitlines() if line.startswith("Next: damperlab ")]
    assert run(*shlex.split(step)[2:]).stdout


def test_what_a_refinement_finds_is_said_in_the_units_of_its_study(tmp_path: Path) -> None:
    study = {
        "name": "pad",
        "particle": False,
        "damping_ratio": DAMPING,
        "physical": {
            "mass_kg": 2.0,
            "natural_frequency_hz": 2.5,
            "base_amplitude_m": 0.001,
            "friction_force_n": [0.05, 0.1, 0.15, 0.6],
            "excitation_frequency_hz": 2.5,
        },
    }
    (tmp_path / "pad.json").write_text(json.dumps(study))
    run("run", tmp_path / "pad.json", "--data-dir", tmp_path / "data")
    asked = ("refine", "pad", "--dry-run", "--data-dir", tmp_path / "data")
    moving = (*asked, "--exclude-locked")
    found = json.loads(run(*moving, "--json").stdout)["found"]
    said = run(*moving, "--details").stdout.splitlines()[-1]
    assert "friction force F_f = 0.15 N, excitation frequency f = 2.5 Hz" in said
    # X/Z with Z = 1 mm is X in mm; the error of a closed orbit is rounding
    assert said.endswith(f"value = {found['value']:.6g} mm")
    assert not [name for name in ("friction_ratio", "damping_ratio", "error") if name in said]
    # kZ = 0.49 N: the mass is locked with 0.6 N and moves with 0.15 N
    boundary = run(*asked, "--boundary", "friction_ratio", "--details").stdout.splitlines()[-1]
    assert (
        "along friction force F_f, low = 0.15 N, high = 0.6 N, below = no_impact, above = locked" in boundary
    )


def test_named_studies_are_listed_with_what_they_show() -> None:
    listed = json.loads(run("studies", "--named", "--json").stdout)["named"]
    points = {entry["name"]: entry["points"] for entry in listed}
    assert points["figure-11"] == 49 * 33
    assert "hysteresis-down" in run("studies", "--named").stdout


FORCED = """
name: press
excitation: force
damping_ratio: 0.05
physical: {mass_kg: 200, natural_frequency_hz: 8, force_n: [20, 40], particle_mass_kg: 10,
  clearance_m: 0.0005, friction_force_n: [0, 16]}
axes: {frequency_ratio: [0.9, 1.0, 1.1], restitution: 0.6}
"""


def test_answers_of_a_force_name_no_motion_of_the_base(tmp_path: Path) -> None:
    study, folder = tmp_path / "press.yaml", ("--data-dir", tmp_path / "data")
    study.write_text(FORCED)
    run("run", study, *folder)
    assert "excitation" in run("show", "press", *folder).stdout
    at = ("--at", "friction_force_n=16", "--at", "base_amplitude_m=8e-5")
    questions = (
        ("show", "press"),
        ("optimum", "press", "--details"),
        ("map", "press", "--x", "friction_force_n", "--y", "frequency_ratio", "--details"),
        ("tmd", "press", *at, "--details"),
        ("response", "press", *at),
    )
    words = " ".join(" ".join(run(*asked, *folder).stdout.split()) for asked in questions)
    assert "excitation a force on it" in words
    assert "2 static displacements" in words
    assert "Static displacement Z = 0.0791572 mm" in words
    assert "A force excites both structures" in words
    assert "base amplitude" not in words.lower()
