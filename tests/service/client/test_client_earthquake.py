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


def test_fault_of_a_comparison_is_named(remote: Client) -> None:
    with pytest.raises(Refused, match=r"clearence_m.*clearance_m"):
        remote.earthquake_comparison("el-centro", clearence_m=0.01)
