"""A study of a force on the command line: what stands for Z is called the static displacement, never a motion of the base."""

from pathlib import Path

from tests.service.cli.commands import run

STUDY = """
name: press
excitation: force
damping_ratio: 0.05
physical: {mass_kg: 200, natural_frequency_hz: 8, force_n: [20, 40], particle_mass_kg: 10,
  clearance_m: 0.0005, friction_force_n: [0, 16]}
axes: {frequency_ratio: [0.9, 1.0, 1.1], restitution: 0.6}
"""


def test_answers_of_a_force_name_no_motion_of_the_base(tmp_path: Path) -> None:
    study, folder = tmp_path / "press.yaml", ("--data-dir", tmp_path / "data")
    study.write_text(STUDY)
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
    assert "A force on the structure excites both" in words
    assert "base amplitude" not in words.lower()
