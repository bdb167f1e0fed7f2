"""robust, precision, refine, tmd and response --with on real stores: friction alone, whose truth is known."""

import csv
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.oracles import forced_friction, transmissibility, tuned_mass
from tests.service.cli.commands import run

from damperlab.studies.store.store import Store

PNG = b"\x89PNG\r\n\x1a\n"
DAMPING = 0.02
FRICTION: dict[str, Any] = {
    "name": "friction",
    "particle": False,
    "damping_ratio": DAMPING,
    # a doubling in two steps, so that rays run through grid points
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


def peak(friction_ratio: float) -> float:
    """Largest X/Z over the three frequencies, by Den Hartog's solution without a stop."""
    found = [forced_friction.non_stop(DAMPING, r, friction_ratio) for r in (0.97, 1.0, 1.03)]
    return max(one.amplitude_ratio for one in found if one is not None)


def test_the_robust_damper_is_the_one_with_the_least_worst_case(data_dir: Path, tmp_path: Path) -> None:
    asked = ["robust", "friction", "--amplitudes", "1,2", "--data-dir", data_dir]
    document = json.loads(run(*asked, "--json").stdout)
    best = document["designs"][0]
    # friction below π/4 helps the more the larger it is, and the largest amplitude halves it
    assert best["friction_ratio"] == pytest.approx(0.4)
    assert best["amplitude"] == pytest.approx(2.0)
    assert best["value"] == pytest.approx(peak(0.2), rel=1e-9)
    assert best["nominal"] == pytest.approx(peak(0.4), rel=1e-9)
    assert len(document["designs"]) == 3  # 0.2 to 0.4; smaller nominal ratios leave the grid
    text = run(*asked, "--top", "1").stdout
    assert f"{peak(0.2):.6g}" in text
    assert "Left out of 5 dampers: 2 leave the grid, because at some base amplitude" in text
    assert "ray" not in text
    *_, head, _ = text.splitlines()
    assert head.index("worst X/Z") < head.index("best X/Z") < head.index("X/Z at the nominal amplitude")
    table = tmp_path / "robust.csv"
    run(*asked, "-o", table)
    with table.open(newline="") as file:
        assert [float(row["value"]) for row in csv.DictReader(file)] == [
            design["value"] for design in document["designs"]
        ]
    assert (
        "--amplitudes must be two numbers"
        in run("robust", "friction", "--amplitudes", "0,2", "--data-dir", data_dir, status=2).stderr
    )


def test_a_ranking_shows_every_axis_of_the_study_also_where_all_ranks_share_its_value(data_dir: Path) -> None:
    among = ["friction", "--within", "friction_ratio=0.1,0.15", "--data-dir", data_dir]
    for asked in (["optimum", *among, "--top", "2"], ["robust", *among, "--amplitudes", "1,1", "--top", "1"]):
        wanted = ["--details"] if asked[0] == "optimum" else []
        head, *rows = run(*asked, *wanted).stdout.splitlines()[-1 - int(asked[-1]) :]
        assert head.split()[:4] == ["friction_ratio", "γ_F", "frequency_ratio", "r"]
        # without a stop the response is largest at the frequency nearest to resonance
        assert {row.split()[1] for row in rows} == {"1"}
        assert "damping_ratio" not in head  # of one value


def test_a_result_may_be_limited_too(data_dir: Path) -> None:
    asked = [
        "optimum",
        "friction",
        "--within",
        f"amplitude_ratio_max=0,{peak(0.2) * 1.01}",
        "--data-dir",
        data_dir,
    ]
    document = json.loads(run(*asked, "--json").stdout)
    assert len(document["designs"]) == 3  # friction ratios from 0.2
    assert document["outside"] == 2
    assert "stick_fraction" in run("optimum", "friction", "--within", "sticks=0,1", status=2).stderr


def test_what_a_study_does_not_store_is_left_out_or_refused(tmp_path: Path) -> None:
    study = tmp_path / "little.json"
    study.write_text(json.dumps({**FRICTION, "name": "little", "metrics": ["amplitude_ratio"]}))
    run("run", study, "--data-dir", tmp_path / "data")
    asked = ["little", "--data-dir", tmp_path / "data"]
    assert "--details" in run("optimum", *asked).stdout
    for question in (["optimum"], ["robust", "--amplitudes", "1,2"], ["refine"]):
        refused = run(question[0], *asked, *question[1:], "--exclude-locked", status=2).stderr
        assert "The study does not store response_class, which --exclude-locked needs." in refused
    assert "does not store run_time, amplitude_error" in run("show", *asked, "--accuracy", status=2).stderr
    assert "amplitude_error, which the study does not store" in (
        run("response", *asked, "--metric", "amplitude_error", status=2).stderr
    )


def test_frequencies_that_may_miss_the_peak_are_remarked_until_those_are_computed_that_are_advised(
    tmp_path: Path,
) -> None:
    """Without a stop friction of 0.1 leaves a resonance of 1/(2ζ) about; with ζ = 0.02 two frequencies see nothing of it."""
    among = ["map", "--x", "friction_ratio", "--y", "damping_ratio"]
    questions = [
        ["optimum"],
        among,
        ["tmd", "--mass-ratio", "0.1", "--at", "damping_ratio=0.02"],
        ["robust", "--amplitudes", "1,1"],
    ]
    axes: dict[str, Any] = {"friction_ratio": [0.05, 0.1], "frequency_ratio": [0.8, 1.25]}
    for name, advised in (("ends", True), ("band", False)):
        study = {**FRICTION, "name": name, "damping_ratio": [DAMPING, 0.1], "axes": axes}
        (tmp_path / "study.json").write_text(json.dumps(study))
        run("run", tmp_path / "study.json", "--data-dir", tmp_path / "data")
        asked = [name, "--data-dir", tmp_path / "data"]
        for question in questions:
            wanted = [] if question[0] == "robust" else ["--details"]
            told = run(question[0], *asked, *question[1:], *wanted).stdout
            # a step of a quarter of 2ζ: 0.45 in 45
            assert ("`frequency_ratio: {start: 0.8, stop: 1.25, num: 46}`" in told) is advised, question
        report = tmp_path / f"{name}.html"
        run("report", *asked, "-o", report)
        assert ("start: 0.8, stop: 1.25, num: 46" in report.read_text()) is advised
        axes["frequency_ratio"] = {"start": 0.8, "stop": 1.25, "num": 46}
    mean = run("optimum", "ends", "--objective", "band_mean", "--data-dir", tmp_path / "data").stdout
    assert "far higher" not in mean


def test_precision_counts_the_points_and_their_time(data_dir: Path) -> None:
    document = json.loads(run("precision", "friction", "--data-dir", data_dir, "--json").stdout)
    assert sum(document["number"]) == document["points"] == 15
    store = Store.open(data_dir)
    times = store.cube(store.find("friction").id)["run_time"].values
    store.close()
    assert document["seconds"] == pytest.approx(times.sum(), rel=1e-12)
    assert document["columns"]["run_time"]["units"] == "s"
    assert "15 points" in run("precision", "friction", "--data-dir", data_dir).stdout


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
    assert follow_up not in run(*asked).stdout
    bad = run("refine", "locking", "--at", "friction_ratio=1", "--data-dir", tmp_path / "data", status=2)
    assert "--boundary" in bad.stderr


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


def test_the_comparison_is_that_of_the_closed_forms_and_is_drawn(data_dir: Path, tmp_path: Path) -> None:
    asked = ["tmd", "friction", "--mass-ratio", "0.1", "--criterion", "hinf", "--data-dir", data_dir]
    point = ["--at", "friction_ratio=0.2"]
    document = json.loads(run(*asked, *point, "--json").stdout)
    tuning, damping, _ = tuned_mass.exact_optimum(0.1)
    r = document["frequency_ratio"]
    np.testing.assert_allclose(
        document["tmd"], tuned_mass.amplitude_ratio(r, 0.1, tuning, damping, DAMPING), rtol=1e-11
    )
    np.testing.assert_allclose(
        document["no_damper"], [transmissibility.absolute_amplitude(DAMPING, x) for x in r], rtol=1e-12
    )
    assert document["hybrid_peak"] == pytest.approx(peak(0.2), rel=1e-9)
    assert "ratio" in run(*asked, *point).stdout
    for suffix, start in ((".png", PNG), (".svg", b"<?xml")):
        figure = tmp_path / f"comparison{suffix}"
        run(*asked, *point, "-o", figure)
        assert figure.read_bytes().startswith(start)


def test_two_studies_are_shown_together(data_dir: Path, tmp_path: Path) -> None:
    asked = [
        "response",
        "friction",
        "--with",
        "friction",
        "--at",
        "friction_ratio=0.2",
        "--data-dir",
        data_dir,
    ]
    document = json.loads(run(*asked, "--json").stdout)
    assert document["values"] == document["other"]
    assert document["apart"] == []
    assert "do not differ" in run(*asked).stdout
    run(*asked, "-o", tmp_path / "both.png")
    assert (tmp_path / "both.png").read_bytes().startswith(PNG)
    assert "--interpolate" in run(*asked, "--interpolate", status=2).stderr


def test_named_studies_are_listed_with_what_they_show() -> None:
    listed = json.loads(run("studies", "--named", "--json").stdout)["named"]
    points = {entry["name"]: entry["points"] for entry in listed}
    assert points["figure-11"] == 49 * 33
    assert "hysteresis-down" in run("studies", "--named").stdout
