"""Two stored studies side by side on the command line: the numbers, the words and the figure."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.service.cli.commands import LINEAR, run


def transmissibility(r: float, zeta: float) -> float:
    """X/Z of the bare structure, model equation; exact."""
    return math.sqrt((1 + (2 * zeta * r) ** 2) / ((1 - r**2) ** 2 + (2 * zeta * r) ** 2))


@pytest.fixture
def linear(tmp_path: Path, linear_study: Path) -> tuple[Path, dict[str, Any]]:
    """The linear study in a folder of this test's own, and its record."""
    folder = tmp_path / "data"
    return folder, json.loads(run("run", linear_study, "--data-dir", folder, "--json").stdout)


def test_a_study_less_another_is_the_difference_of_what_is_known_of_both(
    tmp_path: Path, linear: tuple[Path, dict[str, Any]]
) -> None:
    folder, first = linear
    damped = tmp_path / "damped.json"
    damped.write_text(json.dumps(LINEAR | {"name": "damped", "damping_ratio": 0.05}))
    run("run", damped, "--data-dir", folder)
    plane = ("--x", "frequency_ratio", "--y", "friction_ratio", "--data-dir", folder)
    document = json.loads(run("map", first["id"], "--minus", "damped", *plane, "--json").stdout)
    r = document["x"]
    free = [transmissibility(each, 0.0038) - transmissibility(each, 0.05) for each in r]
    np.testing.assert_allclose(document["difference"][0], free, rtol=1e-9, atol=1e-12)
    assert document["studies"][0] == first["id"]
    assert "structural damping ratio ζ (0.0038 and 0.05)" in document["note"]
    most = max(range(len(r)), key=lambda place: free[place])
    told = run("map", first["id"], "--minus", "damped", "--details", *plane).stdout
    assert f"by at most {free[most]:.4g} at r = {r[most]:.6g}" in " ".join(told.split())
    figure = tmp_path / "difference.svg"
    run("map", first["id"], "--minus", "damped", *plane, "-o", figure)
    drawn = figure.read_text()
    for words in ("bare structure", "damped", "The first less the second", "Difference in amplitude ratio"):
        assert words in drawn


def test_a_study_on_another_grid_is_refused_with_what_differs(
    tmp_path: Path, linear: tuple[Path, dict[str, Any]]
) -> None:
    folder, first = linear
    other = tmp_path / "other.json"
    axes = LINEAR["axes"] | {"frequency_ratio": [0.5, 1.0]}
    other.write_text(json.dumps(LINEAR | {"name": "coarse", "axes": axes}))
    run("run", other, "--data-dir", folder)
    plane = ("--x", "frequency_ratio", "--y", "friction_ratio", "--data-dir", folder)
    refused = run("map", first["id"], "--minus", "coarse", *plane, status=2).stderr
    assert "11 values from 0.5 to 1.5 of frequency_ratio, the second 2 values from 0.5 to 1" in " ".join(
        refused.split()
    )
