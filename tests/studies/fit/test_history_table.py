from pathlib import Path

import numpy as np
import pytest

from damperlab.studies.faults import StudyFaults
from damperlab.studies.fit.history.history import History
from damperlab.studies.fit.history.table import parse_history
from damperlab.studies.fit.measured import Measurement
from damperlab.studies.fit.table import parse_table, read_table


def table(heading: str, rows: int = 30, line: str = "{t:.3f}, {x:.4f}", **more: float) -> str:
    """Write a free decay with 0.02 s between samples, from 20 mm."""
    values = ((0.02 * k, 20 * np.exp(-0.02 * k) * np.cos(15 * 0.02 * k)) for k in range(rows))
    return "\n".join([heading, *(line.format(t=t, x=x, **more) for t, x in values)])


def test_units_become_si_and_times_begin_at_zero() -> None:
    read = parse_history(table("time (ms); x (cm); deviation (mm)", line="{t}; {x}; 0.5"))
    assert read.step_s == pytest.approx(2e-5, rel=1e-12)
    assert read.displacement_m[0] == pytest.approx(0.2, rel=1e-12)
    assert read.deviation_m == pytest.approx(np.full(30, 5e-4), rel=1e-12)
    assert read.released
    assert read.time_s[-1] == pytest.approx(29 * 2e-5, rel=1e-12)


def test_a_deviation_in_per_cent_is_one_of_the_largest_displacement() -> None:
    read = parse_history(table("t (s), displacement (mm), deviation (%)", line="{t}, {x}, 2"))
    assert read.deviation_m == pytest.approx(np.full(30, 0.02 * 0.02), rel=1e-12)


@pytest.mark.parametrize(("unit", "metres"), [("g", 9.80665), ("m/s2", 1.0), ("cm/s2", 0.01)])
def test_a_base_acceleration_is_read_in_its_unit(unit: str, metres: float) -> None:
    lines = [f"{0.01 * k}, {1.0 * k / 30}, {np.sin(k)}" for k in range(30)]
    read = parse_history(
        "\n".join([f"time (s), relative displacement (mm), base acceleration ({unit})", *lines])
    )
    assert read.base_m_s2 is not None
    assert read.base_m_s2 == pytest.approx(metres * np.sin(np.arange(30)), rel=1e-12)
    assert read.relative
    assert not read.released


def test_the_heading_tells_a_history_from_a_response(tmp_path: Path) -> None:
    assert isinstance(parse_table(table("time (s), x (mm)")), History)
    assert isinstance(parse_table("frequency (Hz), amplitude (mm)\n2.5, 3"), Measurement)
    path = tmp_path / "decay.csv"
    path.write_text(table("# released by hand\nt_s ,x (mm)".replace("t_s ", "time_s")))
    read = read_table(path)
    assert isinstance(read, History)
    assert read.name == "decay"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (table("time (s), x (mm), x (mm)", line="{t}, {x}, {x}"), "names the column displacement_m twice"),
        (table("time (s), deviation (mm)"), "must have one column of displacement"),
        (table("time (s), x (mm), x - z (mm)", line="{t}, {x}, {x}"), "must have one column of displacement"),
        (table("time (s), x"), 'The heading "x" states no unit'),
        (table("time (s), speed (m/s)"), "names no known column"),
        (table("time (s), x (mm)", rows=5), "it must have from 24 to 20,000 rows"),
        (
            table("time (s), x (mm)").replace("0.200,", "0.230,"),
            "The times must rise in equal steps; row 11 at 0.23 s",
        ),
        (table("time (s), x (mm)", line="1, {x}"), "The times must rise in equal steps"),
        (table("time (s), x (mm)").replace("\n0.100,", "\n0.100,many,"), "Line 7 has 3 cells"),
        (table("time (s), x (mm)", line="{t}, nan"), '`line 2.displacement_m` must be a number, not "nan".'),
        (table("time (s), x (mm), deviation (mm)", line="{t}, {x}, 0"), "must be a number above 0"),
        (table("time (s), x (mm)", line="{t}, 0"), "a structure that moves"),
        (table("time (s), x (mm)", line="{t}, -{t}"), "must begin at a release from rest"),
        (table("time (s), x (mm), base acceleration (g)", line="{t}, {t}, 0"), "The base acceleration is 0"),
        (table("time (s), x (mm), base acceleration (g)", line="{t}, {x}, {t}"), "must begin at rest"),
    ],
)
def test_what_is_wrong_with_a_history_is_told(text: str, said: str) -> None:
    with pytest.raises(StudyFaults) as refused:
        parse_table(text)
    assert said in " ".join(fault.sentence for fault in refused.value.faults)


def test_an_acceleration_of_the_structure_is_refused_with_what_to_do() -> None:
    with pytest.raises(StudyFaults) as refused:
        parse_history("time (s), acceleration (g), base acceleration (g)\n0, 1, 0\n", "bench")
    said = str(refused.value)
    assert "an accelerometer shows of it is a pulse, whose height and shape are those of the sensor" in said
    assert "`displacement (mm)`, its first row at rest or where it is let go" in said
