import math
from pathlib import Path

import numpy as np
import pytest

from damperlab.studies.faults import StudyFaults
from damperlab.studies.fit.lines import MOST_COLUMNS
from damperlab.studies.fit.measured import Measurement, parse_measurement, read_measurement
from damperlab.studies.fit.structure import read_structure
from damperlab.studies.fit.table import parse_table, read_table


@pytest.mark.parametrize(
    ("heading", "row", "frequency_hz", "amplitude_m", "deviation_m"),
    [
        ("frequency (Hz), amplitude (mm), deviation (mm)", "2.5, 12, 0.3", 2.5, 0.012, 0.0003),
        ("Frequency [kHz];Amplitude [in];Standard deviation [%]", "0.0025;1;2", 2.5, 0.0254, 0.000508),
        ("frequency (rad/s)\tamplitude (µm)\tdeviation (m)", "6.283185307179586\t5\t1e-6", 1.0, 5e-6, 1e-6),
        ("frequency_hz,amplitude_m,deviation_m", "2.5,0.012,0.0003", 2.5, 0.012, 0.0003),
        ("excitation frequency (rpm), x (cm), deviation (cm)", "150, 1.2, 0.03", 2.5, 0.012, 0.0003),
    ],
)
def test_units_of_the_headings_become_si_units(
    heading: str, row: str, frequency_hz: float, amplitude_m: float, deviation_m: float
) -> None:
    found = parse_measurement(f"# measured on a Monday\n\n{heading}\r\n{row}\r\n")
    assert found.in_hertz
    assert found.in_metres
    assert found.frequency == pytest.approx([frequency_hz], rel=1e-15)
    assert found.amplitude == pytest.approx([amplitude_m], rel=1e-15)
    assert found.deviation == pytest.approx([deviation_m], rel=1e-14)


def test_ratios_and_conditions_are_read_and_an_empty_condition_is_none(tmp_path: Path) -> None:
    path = tmp_path / "bench.csv"
    path.write_text("r, X/Z, friction force (lbf), mass_ratio\n1, 20, 0.1, 0\n0.9, 8, , 0.1\n")
    found = read_measurement(path)
    assert found.name == "bench"
    assert not found.in_hertz
    assert not found.in_metres
    assert found.deviation is None
    assert found.columns["friction_force_n"][0] == pytest.approx(0.44482216152605, rel=1e-15)
    assert math.isnan(found.columns["friction_force_n"][1])
    assert np.array_equal(found.columns["mass_ratio"], [0.0, 0.1])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "The file holds no table of measured values."),
        ("frequency (Hz), amplitude (mm)\n", "The table has headings and no rows."),
        ("frequency, X/Z\n1, 2", 'The heading "frequency" states no unit; allowed are hz, khz, rad/s, rpm.'),
        ("frequency (mm), X/Z\n1, 2", 'has the unit "mm"'),
        ("r (Hz), X/Z\n1, 2", "it may have no unit: it is a ratio"),
        ("r, ampiltude (mm)\n1, 2", "Did you mean `amplitude (mm)`?"),
        ("r, X/Z, X/Z\n1, 2, 2", "Line 1 names the column amplitude_ratio twice."),
        ("r, restitution\n1, 0.5", "The table has no column of amplitude; it must have one."),
        ("r, frequency (Hz), X/Z\n1, 2.5, 3", "The table has two columns of frequency; it must have one."),
        ("r, X/Z, deviation (mm)\n1, 2, 3", "must both be lengths or both be ratios"),
        ("r, X/Z, clearance (mm), clearance ratio\n1, 2, 3, 4", "both clearance_m and clearance_ratio"),
        ("f (Hz), Displacement (mm)\n9, 1", "Did you mean `amplitude (mm)`?"),
        ("f (Hz), disp\n9, 1", "Did you mean `amplitude`?"),
        ("frq (Hz), peak (µm)\n9, 1", "Did you mean `frequency (Hz)`?"),
        ("f (Hz), peak (µm)\n9, 1", "Did you mean `amplitude (µm)`?"),
        ("f (Hz), amplitude\n9, 1", "State the unit that the numbers are in, as in `amplitude (m)` or"),
        ("Run 4\nf (Hz), amplitude (mm)\n9, 1", "Remove this line, or write # before it."),
        ("Run 4, Monday\nf (Hz); amplitude (mm)\n9; 1", "Remove this line, or write # before it."),
        ("Run 4\ntime (s), displacement (mm)\n9, 1", "Remove this line, or write # before it."),
        ("Run 4\n9, 1\n10, 2", "Write # before it, and below it such a line"),
        ("9, 1\n10, 2", "Write such a line above it, with the units that the numbers are in."),
        ("r, X/Z\n1, 2, 3", "Line 2 has 3 cells, but the heading names 2 columns."),
        ("r, X/Z\n1,", "`line 2.amplitude_ratio` must be a number above 0, not an empty cell."),
        ("r, X/Z\n1, twelve", '`line 2.amplitude_ratio` must be a number above 0, not "twelve".'),
        ("r, X/Z\n1, nan", 'not "nan"'),
        ("r, X/Z\n1, 1e999", 'not "1e999"'),
        ("r, X/Z\n-1, 2", '`line 2.frequency_ratio` must be a number above 0, not "-1".'),
        ("r, X/Z\n1e9, 2", "frequency_ratio` must be a number from 0.0001 to 10000"),
        ("r, X/Z, restitution\n1, 2, -1", "`line 2.restitution` must be a number of at least 0"),
    ],
)
def test_a_fault_is_told_with_its_place(text: str, said: str) -> None:
    with pytest.raises(StudyFaults) as caught:
        parse_measurement(text)
    assert said in str(caught.value)


@pytest.mark.parametrize("heading", ["frequency (Hz);amplitude (mm)", "time (s);displacement (mm)"])
@pytest.mark.parametrize("separator", [";", "\t"])
def test_decimal_commas_are_told_once(heading: str, separator: str) -> None:
    rows = [f"{9 + row / 10:.3f};{2 + row / 100:.3f}".replace(".", ",") for row in range(50)]
    with pytest.raises(StudyFaults) as caught:
        parse_table("\n".join([heading, *rows]).replace(";", separator))
    (fault,) = caught.value.faults
    assert fault.field == "line 2"
    assert 'a decimal comma, "9,000"' in fault.sentence
    assert "write decimal points" in fault.advice


def test_lines_that_are_all_cut_alike_are_told_once() -> None:
    with pytest.raises(StudyFaults) as caught:
        parse_table("frequency (Hz),amplitude (mm)\n" + "9,000,0,100\n" * 50)
    (fault,) = caught.value.faults
    assert (
        "Each of the 50 lines after the heading has 4 cells, but the heading names 2 columns."
        in fault.sentence
    )
    assert "decimal commas" in fault.advice


@pytest.mark.parametrize("heading", ["displacement (mm)", "Disp", "peak (mm)", "temperature"])
def test_nobody_is_told_to_remove_the_measurement(heading: str) -> None:
    with pytest.raises(StudyFaults) as caught:
        parse_measurement(f"frequency (Hz), {heading}\n9, 1\n")
    assert "emove" not in str(caught.value)


def test_every_fault_is_told_together() -> None:
    with pytest.raises(StudyFaults) as caught:
        parse_measurement("r, X/Z\n1, x\n2, 3, 4\n0, 1\n")
    assert [fault.field for fault in caught.value.faults] == [
        "line 2.amplitude_ratio",
        "line 3",
        "line 4.frequency_ratio",
    ]


def test_a_path_may_be_a_text(tmp_path: Path) -> None:
    table, structure = tmp_path / "bench.csv", tmp_path / "known.yaml"
    table.write_text("r, X/Z\n1, 20\n0.9, 8\n")
    structure.write_text("damping_ratio: 0.01\n")
    for read in (read_measurement, read_table):
        found, same = read(str(table)), read(table)
        assert isinstance(found, Measurement)
        assert isinstance(same, Measurement)
        assert found.name == same.name == "bench"
        assert found.amplitude.tolist() == same.amplitude.tolist() == [20.0, 8.0]
    assert read_structure(str(structure)) == read_structure(structure) == {"damping_ratio": 0.01}


def test_a_file_that_is_not_there_and_a_long_one_are_refused(tmp_path: Path) -> None:
    with pytest.raises(StudyFaults, match="cannot be read: No such file"):
        read_measurement(tmp_path / "none.csv")
    with pytest.raises(StudyFaults, match="at most 2,000 are allowed"):
        parse_measurement("r, X/Z\n" + "1, 2\n" * 2001)
    with pytest.raises(StudyFaults, match="at most 4,194,304 bytes"):
        parse_measurement("x" * (4 * 1024 * 1024 + 1))


@pytest.mark.parametrize(
    "heading", ["acceleration (m/s2)", "Acceleration amplitude (g)", "absolute_acceleration (m/s2)"]
)
def test_an_acceleration_of_the_structure_is_refused_with_what_to_do(heading: str) -> None:
    with pytest.raises(StudyFaults) as refused:
        parse_measurement(f"frequency (Hz), {heading}\n2.5, 12\n")
    said = str(refused.value)
    assert (
        "a motion that is no sine, so that its largest displacement is not its largest acceleration over ω²."
        in said
    )
    assert "Integrate the recorded acceleration twice, high-pass filtered" in said


def test_columns_are_counted_before_their_names_are_compared() -> None:
    with pytest.raises(StudyFaults) as caught:
        parse_table("," * 30_000)
    assert [fault.allowed for fault in caught.value.faults] == [f"at most {MOST_COLUMNS} columns"]
