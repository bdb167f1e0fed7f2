"""Ground motions through the client: listed, handed in, and dampers compared under them."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from damperlab.service.client import Client, Refused

# one second at 5 Hz, in g
STEP_S, SAMPLES = 0.01, 101


@pytest.fixture(scope="module")
def remote(service: Any) -> Iterator[Client]:
    with Client(service.url, timeout=300) as client:
        yield client


@pytest.fixture
def file(tmp_path: Path) -> Path:
    time = STEP_S * np.arange(SAMPLES)
    path = tmp_path / "five hertz.csv"
    rows = [f"{t:.2f},{0.1 * np.sin(2 * np.pi * 5 * t):.17g}" for t in time]
    path.write_text("\n".join(rows) + "\n")
    return path


def test_record_is_handed_in_and_listed(remote: Client, file: Path) -> None:
    record = remote.upload_record(file, units="g")
    assert (record.name, record.samples) == ("five hertz", SAMPLES)
    assert record.duration_s == pytest.approx(1.0)
    assert record.peak_acceleration_g == pytest.approx(0.1)
    assert remote.upload_record(str(file), units="g").id == record.id
    listed = remote.records()
    assert record in listed
    assert any(each.id.startswith("loma-prieta") for each in listed)


def test_what_is_no_record_is_refused(remote: Client, file: Path, tmp_path: Path) -> None:
    with pytest.raises(Refused, match=r"\.at2, \.csv, \.txt"):
        remote.upload_record(tmp_path / "a.xlsx")
    with pytest.raises(Refused, match="No such file"):
        remote.upload_record(tmp_path / "none.csv")
    file.write_text("time,acceleration\n0,fast\n")
    with pytest.raises(Refused):
        remote.upload_record(file, units="g")


def test_comparison_without_friction_and_particle(remote: Client, file: Path, tmp_path: Path) -> None:
    record = remote.upload_record(file, units="g")
    answer = remote.earthquake_comparison(record, ["none", "tmd"], starts=0, tail_s=1.0)
    assert answer["case"].values.tolist() == ["none", "tmd"]
    assert answer["peak_relative_displacement_m"].attrs["units"] == "m"
    assert answer["peak_absolute_acceleration_m_s2"].attrs["units"] == "m/s2"
    none = answer.sel(case="none")
    # Table 2 of the paper: 1.605 kg, 2.5 Hz, ζ = 0.0038; the pieces of the record are linear, so a fine step of the
    # trapezoidal rule, whose error falls with its square, is an independent truth
    assert float(none["peak_relative_displacement_m"]) == pytest.approx(_peak(), rel=1e-5)
    assert answer.attrs["record"]["id"] == record.id
    answer.plot(tmp_path / "dampers.svg")
    assert "Peak of" in (tmp_path / "dampers.svg").read_text()


def _peak() -> float:
    """March the structure through the record and a second of rest, by average accelerations in 2,000 steps a sample."""
    omega, zeta, parts = 2 * np.pi * 2.5, 0.0038, 2000
    time = STEP_S * np.arange(SAMPLES)
    samples = 9.80665 * 0.1 * np.sin(2 * np.pi * 5 * time)
    h = STEP_S / parts
    force = -np.interp(h * np.arange((2 * SAMPLES - 2) * parts + 1), time, samples, right=0.0)
    left = np.array([[1, -h / 2], [omega**2 * h / 2, 1 + zeta * omega * h]])
    right = np.array([[1, h / 2], [-(omega**2) * h / 2, 1 - zeta * omega * h]])
    step, push = np.linalg.solve(left, right), np.linalg.solve(left, np.array([0.0, h / 2]))
    # one sample's worth of steps at a time keeps the loop in Python short
    x, v, highest = 0.0, 0.0, 0.0
    a, b, c, d = step.ravel().tolist()
    p, q = push.tolist()
    pushed = (force[:-1] + force[1:]).tolist()
    for total in pushed:
        x, v = a * x + b * v + p * total, c * x + d * v + q * total
        highest = max(highest, abs(x))
    return highest


def test_fault_of_a_comparison_is_named(remote: Client) -> None:
    with pytest.raises(Refused, match=r"clearence_m.*clearance_m"):
        remote.earthquake_comparison("el-centro", clearence_m=0.01)


def test_a_suite_is_submitted_asked_and_opened(remote: Client, suite: dict[str, Any], tmp_path: Path) -> None:
    study = remote.submit(suite["definition"]).wait(progress=False)
    assert study.id == suite["id"]
    cube = study.cube(chunks=None).load()
    shown = study.resonance_map(record="northridge", scale=3)
    assert shown["peak_relative_displacement_m"].dims == ("friction_force_n", "clearance_m")
    np.testing.assert_array_equal(
        shown["peak_relative_displacement_m"],
        cube["peak_relative_displacement_m"].sel(record="northridge-090", scale=3).squeeze().transpose(),
    )
    worst = study.resonance_map(scale=3)
    assert set(worst["record_at"].values.ravel()) <= set(cube["record"].values)
    best = study.optimal_designs(top=2, records=["northridge-360"], clearance_m=(0.002, 1))
    assert best.sizes["rank"] == 2
    assert set(best["record"].values) == {"northridge-360"}
    best.plot(tmp_path / "best.png")
    assert (tmp_path / "best.png").stat().st_size > 1000
    with pytest.raises(Refused, match="a ground-motion suite"):
        study.frequency_response()
