"""Tables of what was measured, a frequency response or a time history: units, columns, and faults with their place."""

import math
from pathlib import Path

import numpy as np
import pytest
from tests.studies.documents import faults_of, fields_of

from damperlab.studies.faults import StudyFaults
from damperlab.studies.fit.document import parse_table, read_table
from damperlab.studies.fit.history.question import History
from damperlab.studies.fit.history.table import parse_history
from damperlab.studies.fit.lines import MOST_COLUMNS
from damperlab.studies.fit.measured import Measurement, parse_measurement


@pytest.mark.parametrize(
    ("heading", "row", "frequency_hz", "amplitude_m", "deviation_m"),
    [
        ("Frequency [kHz];Amplitude [in];Standard deviation [%]", "0.0025;1;2", 2.5, 0.0254, 0.000508),
        ("frequency (rad/s)\tamplitude (µm)\tdeviation (m)", "6.283185307179586\t5\t1e-6", 1.0, 5e-6, 1e-6),
        ("frequency_hz,amplitude_m,deviation_m", "2.5,0.012,0.0003", 2.5, 0.012, 0.0003),
        ("excitation frequency (rpm), x (cm), deviation (cm)", "150, 1.2, 0.03", 2.5, 0.012, 0.0003),
        ("f / Hz; x / mm; deviation / mm", "2.5; 12; 0.3", 2.5, 0.012, 0.0003),
        ("frequency_khz,amplitude_mm,deviation_mm", "2.5D-3,1.2D1,3.0d-1", 2.5, 0.012, 0.0003),
        ("# frequency (Hz), amplitude (mm), deviation (%)", "2.5, 12, 2.5", 2.5, 0.012, 0.0003),
        ("% frequency (Hz)   amplitude (mm)  deviation (mm)", "  2.5  12 0.3 ", 2.5, 0.012, 0.0003),
        ("frequency (Hz) amplitude (mm) deviation (mm)", "2.5 12 0.3", 2.5, 0.012, 0.0003),
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
    path.write_text("r, X/Z (-), friction force (lbf), mass_ratio\n1, 20, 0.1, 0\n0.9, 8, , 0.1\n")
    found = read_table(path)
    assert found.name == "bench"
    assert not found.in_hertz
    assert not found.in_metres
    assert found.deviation is None
    assert found.columns["friction_force_n"][0] == pytest.approx(0.44482216152605, rel=1e-15)
    assert math.isnan(found.columns["friction_force_n"][1])
    assert np.array_equal(found.columns["mass_ratio"], [0.0, 0.1])


def test_a_last_line_without_its_condition_is_not_cut_off() -> None:
    assert parse_measurement("r, X/Z, restitution\n" + "1, 2, 0.50\n" * 20 + "1, 3,").rows == 21


@pytest.mark.parametrize("heading", ["frequency (Hz);amplitude (mm)", "time (s);displacement (mm)"])
@pytest.mark.parametrize("separator", [";", "\t"])
def test_decimal_commas_are_told_once(heading: str, separator: str) -> None:
    rows = [f"{9 + row / 10:.3f};{2 + row / 100:.3f}".replace(".", ",") for row in range(50)]
    (fault,) = faults_of(parse_table, "\n".join([heading, *rows]).replace(";", separator))
    assert fault.field == "line 2"
    assert 'a number with a decimal comma, or with a comma between thousands: "9,000".' in fault.sentence
    assert "write decimal points" in fault.advice


def test_lines_that_are_all_cut_alike_are_told_once() -> None:
    (fault,) = faults_of(parse_table, "frequency (Hz),amplitude (mm)\n" + "9,000,0,100\n" * 50)
    assert (
        "Each of the 50 lines after the heading has 4 cells, but the heading names 2 columns."
        in fault.sentence
    )
    assert "decimal commas" in fault.advice


@pytest.mark.parametrize("heading", ["displacement 0.1 mm", "amplitude in 10^-1 mm", "amplitude (mm) x 10"])
def test_a_heading_with_a_factor_is_refused(heading: str) -> None:
    (fault,) = faults_of(parse_table, f"frequency (Hz), {heading}\n9, 1\n")
    assert "contains a factor" in fault.sentence
    assert "convert the numbers" in fault.advice


def test_every_fault_is_told_together() -> None:
    assert fields_of(parse_measurement, "r, X/Z\n1, x\n2, 3, 4\n0, 1\n") == [
        "line 2.amplitude_ratio",
        "line 3",
        "line 4.frequency_ratio",
    ]


def test_a_file_that_is_not_there_and_a_long_one_are_refused(tmp_path: Path) -> None:
    with pytest.raises(StudyFaults, match="cannot be read: No such file"):
        read_table(tmp_path / "none.csv")
    with pytest.raises(StudyFaults, match="at most 2,000 are allowed"):
        parse_measurement("r, X/Z\n" + "1, 2\n" * 2001)
    with pytest.raises(StudyFaults, match="at most 4,194,304 bytes"):
        parse_measurement("x" * (4 * 1024 * 1024 + 1))


@pytest.mark.parametrize(
    "heading",
    ["frequency (Hz), Acceleration amplitude (g)", "time (s), absolute_acceleration (m/s2), x (mm)"],
)
def test_an_acceleration_of_the_structure_is_refused_with_what_to_do(heading: str) -> None:
    (fault,) = faults_of(parse_table, f"{heading}\n2.5, 12, 1\n")
    assert "displacement" in fault.advice


def test_columns_are_counted_before_their_names_are_compared() -> None:
    (fault,) = faults_of(parse_table, "," * 30_000)
    assert fault.allowed == f"at most {MOST_COLUMNS} columns"


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


@pytest.mark.parametrize(
    ("unit", "metres"), [("g", 9.80665), ("m/s2", 1.0), ("cm/sec**2", 0.01), ("mg", 0.00980665)]
)
def test_a_base_acceleration_is_read_in_its_unit(unit: str, metres: float) -> None:
    lines = [f"{0.01 * k}, {1.0 * k / 30}, {np.sin(k)}" for k in range(30)]
    read = parse_history(
        "\n".join([f"time (s), relative displacement (mm), base acceleration ({unit})", *lines])
    )
    assert read.base_m_s2 == pytest.approx(metres * np.sin(np.arange(30)), rel=1e-12)
    assert read.relative
    assert not read.released


def test_a_number_of_nines_far_beyond_all_others_is_a_mark_of_a_missing_sample() -> None:
    lines = table("time (s), displacement (mm)").splitlines()
    lines[13] = "0.240, -9999"
    (fault,) = faults_of(parse_history, "\n".join(lines))
    assert (fault.field, fault.found) == ("line 14", "-9999")


def test_the_heading_tells_a_history_from_a_response(tmp_path: Path) -> None:
    assert isinstance(parse_table(table("time (s), x (mm)")), History)
    assert isinstance(parse_table("frequency (Hz), amplitude (mm)\n2.5, 3"), Measurement)
    path = tmp_path / "decay.csv"
    path.write_text(table("# released by hand\nt_s ,x (mm)".replace("t_s ", "time_s")))
    read = read_table(path)
    assert isinstance(read, History)
    assert read.name == "decay"


@pytest.mark.parametrize(
    "comment",
    [
        "displacement in mm, time in s",
        "largest displacement (in): 0.79",
        "rms noise 0.1 mm",
    ],
)
def test_a_comment_that_contradicts_no_heading_is_a_comment(comment: str) -> None:
    assert isinstance(parse_table(table(f"# {comment}\ntime (s), displacement (mm)")), History)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "The file holds no table of measured values."),
        ("frequency (Hz), amplitude (mm)\n", "The table has headings and no rows."),
        ("frequency, X/Z\n1, 2", 'The heading "frequency" states no unit; allowed are hz, khz, rad/s, rpm.'),
        ("frequency (mm), X/Z\n1, 2", 'has the unit "mm"'),
        ("r (Hz), X/Z\n1, 2", "it must have no unit, as it is a ratio"),
        ("r, amplitude (dB)\n1, 2", "Convert the numbers to one of these"),
        ("r, X/Z (dB)\n1, 2", "Convert the numbers to a ratio"),
        ("r, amplitude pp (mm)\n1, 2", "half of a peak-to-peak value"),
        ("r, peak-to-peak (mm)\n1, 2", "half of a peak-to-peak value"),
        ("r, double amplitude (mm)\n1, 2", "half of a peak-to-peak value"),
        ("r, amplitude (mm rms)\n1, 2", "an rms value does not determine it"),
        ("r, amplitude (relative) (mm)\n1, 2", "names no known column"),
        (
            "Run 4, 3.2.2021\nOperator: X\n\nf (Hz), x (mm)\n9, 1",
            "Remove the lines above line 4, or write # before them.",
        ),
        (
            "r, X/Z\n" + "1, 2.500\n" * 20 + "1, 2.5",
            'The file seems to be cut off: its last number, "2.5", has fewer digits',
        ),
        (table("time (s), x (mm)", line="{t}, 1_0"), '`line 2.displacement_m` must be a number, not "1_0".'),
        ("r, ampiltude (mm)\n1, 2", "Did you mean `amplitude (mm)`?"),
        ("r, X/Z, X/Z\n1, 2, 2", "Line 1 names the column amplitude_ratio twice."),
        ("r, restitution\n1, 0.5", "The table has no column of amplitude; it must have one."),
        ("r, frequency (Hz), X/Z\n1, 2.5, 3", "The table has two columns of frequency; it must have one."),
        ("r, X/Z, deviation (mm)\n1, 2, 3", "must both be lengths or both be ratios"),
        ("r, X/Z, clearance (mm), clearance ratio\n1, 2, 3, 4", "both clearance_m and clearance_ratio"),
        ("frq (Hz), peak (µm)\n9, 1", "Did you mean `frequency (Hz)`?"),
        ("f (Hz), amplitude\n9, 1", "State the unit of the numbers, as in `amplitude (m)` or"),
        ("Run 4\n9, 1\n10, 2", "Write # before it, and add below it a line that names the columns"),
        ("9, 1\n10, 2", "Write such a line above it, with the units of the numbers."),
        ("r, X/Z\n1, 2, 3", "Line 2 has 3 cells, but the heading names 2 columns."),
        ("r, X/Z\n1,", "`line 2.amplitude_ratio` must be a number above 0, not an empty cell."),
        ("r, X/Z\n1, twelve", '`line 2.amplitude_ratio` must be a number above 0, not "twelve".'),
        ("r, X/Z\n1e9, 2", "frequency_ratio` must be a number from 0.0001 to 10000"),
        ("r, X/Z, restitution\n1, 2, -1", "`line 2.restitution` must be a number of at least 0"),
        (table("time (s), x (mm), x (mm)", line="{t}, {x}, {x}"), "names the column displacement_m twice"),
        (table("time (s), x (mm), x - z (mm)", line="{t}, {x}, {x}"), "must have one column of displacement"),
        (table("Zeit (s), x (mm)"), "Did you mean `time (s)`?"),
        (table("sec, x (mm)"), "Did you mean `time (sec)`?"),
        (table("time (s), x (mm)", rows=5), "it must have from 24 to 20,000 rows"),
        (
            table("time (s), x (mm)").replace("0.200,", "0.230,"),
            "Line 12 has a step of 0.05 s, but the usual step is 0.02 s; all time steps must be equal. Add the samples",
        ),
        (
            table("time (s), x (mm)", line="1, {x}"),
            "The time 1 s in line 3 is not later than 1 s before it; time must increase. Order the lines by time",
        ),
        (
            table("sample, x (mm)"),
            'The heading "sample" stands for row numbers. Remove the column; a time history has `time (s)`',
        ),
        (
            table("time (s); x (µm)", line="{t:.2f};1,070.5"),
            '`line 2` has a number with a decimal comma, or with a comma between thousands: "1,070.5".',
        ),
        (table("# scale factor 0.01\ntime (s), x (mm)"), 'Line 1 names a factor: "# scale factor 0.01".'),
        (
            table("# displacement in inches\ntime (s), displacement (mm)"),
            'Line 1 says "inches", but the heading "displacement (mm)" says "mm".',
        ),
        (
            table("time (s), displacement (mm)") + "\n# time (msec)",
            'Line 32 says "msec", but the heading "time (s)" says "s".',
        ),
        (
            "# amplitudes are rms\nr, amplitude (mm)\n1, 2",
            'Line 1 mentions rms or peak-to-peak amplitudes: "# amplitudes are rms".',
        ),
        (table("time (s), x (mm), deviation (mm)", line="{t}, {x}, 0"), "must be a number above 0"),
        (table("time (s), x (mm)", line="{t}, 0"), "a structure that moves"),
        (table("time (s), x (mm)", line="{t}, -{t}"), "must begin at a release from rest"),
        (table("time (s), x (mm), base acceleration (g)", line="{t}, {t}, 0"), "The base acceleration is 0"),
        (table("time (s), x (mm), base acceleration (g)", line="{t}, {x}, {t}"), "must begin at rest"),
    ],
)
def test_a_fault_is_told_with_its_place(text: str, said: str) -> None:
    with pytest.raises(StudyFaults) as caught:
        parse_table(text)
    assert said in str(caught.value)


def history_of(moved: np.ndarray) -> str:
    return "\n".join(["time (s), x (mm)", *(f"{0.02 * k:.2f}, {x:.4f}" for k, x in enumerate(moved))])


DECAY = 4.0 * 0.997 ** np.arange(300) * np.cos(0.3 * np.arange(300))


@pytest.mark.parametrize(("pulled", "held"), [(0, 0), (0, 12), (0, 400), (11, 12), (80, 400)])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_release_is_found_behind_the_samples_in_which_it_was_pulled_and_held(
    pulled: int, held: int, sign: float
) -> None:
    """Noise of 0.5 % shifts a sample of the fall, 0.3 rad from the next, by 0.01 rad and less."""
    moved = sign * np.concatenate([np.linspace(0.0, 4.0, pulled), np.full(held, 4.0), DECAY])
    moved += 0.02 * np.random.default_rng(held).standard_normal(moved.size)
    read = parse_table(history_of(moved))
    assert isinstance(read, History)
    assert read.before_release == held + pulled
    assert read.displacement_m[0] == pytest.approx(sign * 0.004, rel=0.02)


@pytest.mark.parametrize("rest", [0, 3, 100])
@pytest.mark.parametrize("step", [0.05, 0.3, 0.7])
def test_a_structure_that_is_struck_is_not_taken_for_released(rest: int, step: float) -> None:
    swing = np.exp(-0.003 * np.arange(300)) * np.sin(step * np.arange(300))
    moved = np.concatenate([np.zeros(rest), swing]) + 0.01 * np.random.default_rng(1).standard_normal(
        rest + 300
    )
    with pytest.raises(StudyFaults, match="oscillates before the largest displacement"):
        parse_table(history_of(moved))


@pytest.mark.parametrize("away", [9.0, 2.0])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_decay_about_another_position_is_refused_and_one_that_friction_holds_is_not(
    sign: float, away: float
) -> None:
    """A structure that turns before its rest position is held there by friction: it never swings back."""
    with pytest.raises(StudyFaults, match="swings about another position") as caught:
        parse_table(history_of(sign * (DECAY + away)))
    assert "subtract the position" in str(caught.value).lower()
    noise = 0.02 * np.random.default_rng(2).standard_normal(300)
    held = np.where(np.arange(300) < 10, 2.7 + 1.3 * np.cos(np.pi * np.arange(300) / 10), 1.4)
    assert isinstance(parse_table(history_of(sign * (held + noise))), History)


def test_a_release_at_the_end_of_a_table_leaves_too_few_rows() -> None:
    with pytest.raises(StudyFaults, match="20 rows from the release in row 61 on"):
        parse_table(history_of(np.concatenate([np.full(60, 4.0), DECAY[:20]])))


def test_a_table_may_be_quoted_in_utf_16_with_rounded_times() -> None:
    rows = "\n".join(f'"{i / 128:.3f}","{4.0 * 0.97**i * np.cos(0.3 * i):.4f}"' for i in range(160))
    read = parse_table(f'"time (s)","x (mm)"\n{rows}'.encode("utf-16"))
    assert isinstance(read, History)
    assert read.step_s == 1 / 128
