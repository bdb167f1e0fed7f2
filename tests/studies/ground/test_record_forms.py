"""Records as users have them: each form is read as what it is, or refused with the true reason and what to do."""

import gzip

import numpy as np
import pytest
from tests.studies.documents import faults_of

from damperlab.studies.faults import StudyFaults
from damperlab.studies.ground.files import Layout, read_record
from damperlab.studies.ground.motion import STANDARD_GRAVITY as G

STEP = 0.005
A = np.round(0.1 * np.sin(0.7 * np.arange(40)), 5)
"""Forty samples. The first is 0. Each file states their unit."""


def peer(
    units: str = "ACCELERATION TIME SERIES IN UNITS OF G", begin: str = "NPTS=  40, DT=   .0050 SEC,"
) -> str:
    lines = ["".join(f"{a:15.7E}" for a in A[k : k + 5]) for k in range(0, A.size, 5)]
    return "\n".join(
        ["PEER NGA STRONG MOTION DATABASE RECORD", "A quake, 1/1/2000, A station, 90", units, begin, *lines]
    )


def columns(heading: str, line: str = "{t:.3f}, {a}", scale: float = 1.0, step: float = STEP) -> str:
    rows = (line.format(t=k * step * scale, a=a, k=k, n=k + 1) for k, a in enumerate(A))
    return "\n".join([*([heading] if heading else []), *rows])


def alone(*heading: str) -> str:
    return "\n".join([*heading, *(f"{a}" for a in A)])


SI = "time (s), acceleration (m/s2)"
READ: dict[str, tuple[str | bytes, float | None]] = {
    "peer": (peer(), G),
    "the units are": (peer("The units are (g)"), G),
    "g's": (peer("ACCELERATION TIME HISTORY (G'S)"), G),
    "a sentence goes on": (peer("ACCELERATION TIME HISTORY IN UNITS OF G. FILTER POINTS: HP=0.2 Hz LP=10.0 Hz"), G),
    "stars": (peer("UNITS: CM/SEC**2"), 0.01),
    "in words": (peer("Acceleration, units of cm per second squared"), 0.01),
    "step in ms": (peer(begin="NPTS= 40, DT= 5 MSEC"), G),
    "old header": (peer(begin="   40   0.0050   NPTS, DT"), G),
    "per cent": (columns("time (s), acc (%g)"), 0.01 * G),
    "mg": (columns("time (s), acceleration (mg)"), 1e-3 * G),
    "exponents": (columns("time [s], acc [m s-2]"), 1.0),
    "signs": (columns("t / s; a / (m·s⁻²)", "{t:.3f}; {a}"), 1.0),
    "underlined": (columns("time_s,acc_g"), G),
    "metres": (columns("Time (sec), Acceleration (meters/sec^2)"), 1.0),
    "feet": (columns("time (s), acc (ft/s2)"), 0.3048),
    "row of units": (columns("time,acceleration\ns,cm/s2"), 0.01),
    "milliseconds": (columns("Time in milliseconds, acc (g)", "{t:g}, {a}", 1e3), G),
    "counted ms": (columns("time (ms), acc (m/s2)", "{k}, {a}", step=1e-3), 1.0),
    "one blank": (columns("Time(s) Acc(m/s/s)", "{t:.3f} {a}"), 1.0),
    "quoted lines": (columns('"time (s),acceleration (g)"', '"{t:.3f},{a}"'), G),
    "utf-16": (columns(SI).encode("utf-16"), 1.0),
    "utf-16 unmarked": (columns(SI).encode("utf-16-le"), 1.0),
    "number and step": (alone("40 0.005"), None),
    "number, step and unit": (alone("Units: cm/s/s", "40, 0.005"), 0.01),
    "number and step, five in a line": ("acceleration in g\n40 0.005\n" + peer().split("SEC,\n")[1], G),
    "a line of units in brackets": (columns("Time,Accel\n(s),(cm/s²)").encode("latin-1"), 0.01),
    "units of both in lines": (columns("Units of time: ms\nUnits of acceleration: g\ntime, acc", scale=1e3), G),
    "in one sentence": (columns("time in ms acc in g", scale=1e3), G),
    "names in capitals": (columns("TIME_MS;ACCELERATION_M_S2", "{t:.0f};{a}", 1e3), 1.0),
    "a direction": (columns("time_s,acc_h"), None),
    "peak in another unit": (columns("# peak acceleration 0.3 (g)\ntime (s), acceleration (m/s2)"), 1.0),
    "a title alone": (columns("Kobe 1995, NS, filtered", "{t:.3f} {a}"), None),
    "units in a sentence": (columns("# units: time s, acceleration m/s^2\ntime, acc"), 1.0),
    "commas in quotes": (columns('"Time, s","Acceleration, %g"'), 0.01 * G),
    "acceleration of a station of that name": (peer().replace("A quake", "Accumoli, velocity 3 cm/s"), G),
    "german": (columns("Zeit [s]; Beschleunigung [m/s²]", "{t:.3f}; {a}"), 1.0),
    "microseconds": (columns("time (us), acc (g)", "{t:.0f}, {a}", 1e6), G),
    "times before a trigger": (columns("time (s), acc (g)").replace("\n0.000,", "\n-0.000,"), G),
    "begins later": ("t [s]; a [g]\n" + "\n".join(f"{10 + k * STEP:.3f};{a}" for k, a in enumerate(A)), G),
    "trailing commas": (columns(SI, "{t:.3f},{a},"), 1.0),
    "fortran": (columns(SI, "{t:.3f} {a:.5E}").replace("E-0", "D-0"), 1.0),
    "no zero before the point": (peer().replace(" 0.", " .").replace("-0.", "-."), G),
    "excel names its separator": (columns("sep=;\nTime [s];Acc [g]", "{t:g};{a}"), G),
    "octave": (columns("# name: x\n# type: matrix\n# rows: 40\n# columns: 2", " {t:g} {a}"), None),
    "names and units in a block": (columns("Operator\tMM\nDate\t03.04.2021 12:33\n\nTime\tAccel\ns\tg", "{t}\t{a}"), G),
    "mps2": (columns("time_s,acc_mps2"), 1.0),
    "minus signs of a text processor": (columns(SI).replace("-", "−"), 1.0),
    "quantity beside the step": (alone("# ACCELERATION IN CM/S2, NPTS= 40, DT= 0.005 SEC"), 0.01),
    "unit below the samples": (columns("time, a") + "\n# acceleration in cm/s2", 0.01),
    "velocity of a site, by its column": (columns("# shear wave velocity 270 m/s\ntime (s), a"), None),
    "units and a date in comments": (columns("% recorded 2020-03-04\n% units: g", "{t:.3f} {a}"), G),
    "a direction in degrees": (columns("time (s), acceleration 360 (g)"), G),
    "one line shorter": (columns(SI, "{t:.3f}, {a:.5f}").replace("\n0.195, 0.08376", "\n0.195, 0.08376 \n"), 1.0),
}  # fmt: skip


def layout_of(text: str | bytes) -> Layout:
    return "at2" if isinstance(text, str) and text.startswith("PEER") else "csv"


@pytest.mark.parametrize("form", READ)
def test_a_form_is_read_as_what_it_is(form: str) -> None:
    text, factor = READ[form]
    motion = read_record(text, layout_of(text), units=None if factor else "g")
    step = 1e-3 if form == "counted ms" else STEP
    assert motion.step_s == pytest.approx(step, rel=1e-12)
    np.testing.assert_allclose(motion.acceleration_m_s2, A * (factor or G), rtol=1e-14)


def stamped(stamps: list[str], unit: str = "s") -> str:
    return "\n".join([f"time ({unit}), acc (g)", *(f"{t}, {k % 7}" for k, t in enumerate(stamps))])


@pytest.mark.parametrize(
    ("rate", "digits", "rows"),
    [
        (128, 3, 1000),
        (200, 2, 2000),
        (30, 3, 100),
        (256, 3, 300),
        (100, 1, 3000),
        (1024, 4, 3000),
        (1000 / 3, 4, 3000),
        (60, 2, 500),
        (102.4, 3, 2000),
        (1 / 0.015, 2, 2000),
    ],
)
@pytest.mark.parametrize("way", ["rounded", "cut off"])
def test_times_that_were_rounded_or_cut_off_are_equal_steps(
    rate: float, digits: int, rows: int, way: str
) -> None:
    times = np.arange(rows) / rate
    if way == "cut off":
        times = np.floor(times * 10**digits + 1e-6) / 10**digits
    motion = read_record(stamped([f"{t:.{digits}f}" for t in times]), "csv")
    assert motion.step_s == pytest.approx(1 / rate, rel=1e-12)


@pytest.mark.parametrize(("rate", "digits"), [(128, 3), (100, 2), (256, 3), (30, 3), (50, 2), (1000, 3)])
@pytest.mark.parametrize("rows", [600, 3000])
def test_a_sample_that_is_missing_is_found_between_rounded_times(rate: int, digits: int, rows: int) -> None:
    times = np.delete(np.arange(rows) / rate, 300)
    with pytest.raises(StudyFaults, match="Line 302 has a step of"):
        read_record(stamped([f"{t:.{digits}f}" for t in times]), "csv")


KNET = "Origin Time 2011/03/11 14:46:00\nSampling Freq(Hz)  100Hz\nScale Factor      3920(gal)/6182761\nMemo.\n  12  13  14\n"
ESM = "EVENT_NAME: X\nSAMPLING_INTERVAL_S: 0.005000\nNDATA: 3\nUNITS: cm/s^2\nDATA_TYPE: ACCELERATION\n0.1\n0.2\n0.3"
COSMOS = "Corrected acceleration   (Format v01.20 with 13 text lines)\nx\n 40 acceleration pts, approx 2 secs\n1 2 3\n"
SMC = "2 CORRECTED ACCELEROGRAM\n*\n*\n 1 2 3 4\n"
LVM = columns(
    "LabVIEW Measurement\t\nWriter_Version\t2\n***End_of_Header***\nX_Value\tAcc\tComment", "{t}\t{a}"
)
CSMIP = (
    "CORRECTED ACCELEROGRAM\n"
    + 20 * "a line\n"
    + " 40 POINTS OF ACCEL DATA EQUALLY SPACED AT .02 SEC.\n1 2\n"
)
CM = "time (s), acc (cm/s2)"
LATE = stamped([f"{k * STEP * (1 + 1e-4 * k):.6f}" for k in range(200)])
SOON = stamped(["0.000", "0.001", *(f"{k * STEP:.3f}" for k in range(1, 40))])
DATES = "2020-01-01T00:00:{t:06.3f}, {a}"
BROKEN: dict[str, tuple[str | bytes, str | None, str, str, str]] = {
    "velocity": (peer("VELOCITY TIME SERIES IN UNITS OF CM/S"), "g", "line 3", "a velocity", "differentiate this one"),
    "displacement": (peer("DISPLACEMENT TIME SERIES IN UNITS OF CM"), "g", "line 3", "a displacement", "twice"),
    "velocity column": (columns("time (s), velocity (cm/s)"), None, "line 1", "a velocity", "differentiate this one"),
    "displacement by its unit": (columns("time (s), x (mm)"), "g", "line 1", "a displacement", "twice"),
    "spectrum": (columns("Period (s), Sa (g)"), None, "line 1", "a response spectrum", "over time"),
    "frequency": (columns("frequency (Hz), acceleration (g)"), None, "line 1", "a frequency", "damperlab fit"),
    "unknown unit": (peer("UNITS OF FURLONGS"), "g", "line 3", "FURLONGS", "convert"),
    "a factor": (peer("UNITS OF G/100"), None, "line 3", "G/100", "convert"),
    "unknown time": (columns("time (fortnights), acc (g)"), None, "line 1", "fortnights", "convert"),
    "unknown columns": (columns("x,y"), "g", "line 1", '"x" is not known as a time', "time (s), acceleration (g)"),
    "two units": (columns("UNITS OF CM/S2\ntime (s), acc (g)"), None, "line 2", '1, but "g" in line 2', "correct or remove"),
    "contradicted": (columns("time (s), acc (m/s^2)"), "g", "units", "the file says m/s2", "leave `units` out"),
    "contradicted in words": (peer("Acceleration in g"), "cm/s2", "units", "the file says g", "leave `units` out"),
    "row numbers": (columns("", "{n}, {a}"), "g", "time", "row numbers", "NPTS= <number>"),
    "row numbers from 0": (columns("time, acc (g)", "{k}, {a}"), None, "time", "row numbers", "time (s)"),
    "row numbers named": (columns("Sample, acc (g)", "{n}, {a}"), None, "line 1", "a count of samples", "NPTS= <number>"),
    "order of columns": (columns("acc (g), time (s)", "{a}, {t:.3f}"), None, "line 1", "the time first", "time (s)"),
    "three columns": (columns("time (s), NS (g), EW (g)", "{t:.3f}, {a}, {a}"), None, "line 2", '3 numbers', "keep the time"),
    "five columns": (columns("", "{a} {a} {a} {a} {a}"), "g", "line 1", "5 numbers", "NPTS= <number>"),
    "one column": (alone("Acceleration in g"), None, "line 2", "1 number", "NPTS= <number>"),
    "a gap": (columns(SI).replace("\n0.100,", "\n0.100, 0.1\n0.130,"), None, "line 23", "a step of 0.03 s", "missing"),
    "two records": (columns(SI) + "\n" + columns(""), None, "line 42", "not later than", "one record"),
    "no number": (columns(SI).replace("\n0.000, 0.0", "\n0.000, n/a"), None, "line 2", "numbers only", "correct the line"),
    "no number within": (columns(SI).replace("\n0.100, ", "\n0.100, NaN"), None, "line 22", "numbers only", "correct the line"),
    "decimal commas": (columns(SI, "{t:.3f};{a}").replace(".", ","), None, "line 2", "decimal comma", "decimal points"),
    "decimal commas by commas": (columns(SI, "{t:.3f},{a:.3f}").replace(".", ","), None, "line 2", "a decimal comma", "points"),
    "another step": (columns("UNITS OF G\nNPTS= 40, DT= 0.01"), None, "line 2", "0.01 s apart, but", "correct the line"),
    "density": (columns("Frequency (Hz), PSD (g2/Hz)"), None, "line 1", "a spectral density", "random_vibration"),
    "spectrum given a unit": (columns("T,Sa"), "g", "line 1", "a response spectrum", "over time"),
    "peak values": (columns("T (s), PGA (g)"), None, "line 1", "a list of peak values", "over time"),
    "two units of time": (columns("Units of time: ms\ntime (s), acc (g)"), None, "line 2", '"ms" in line 1', "correct or"),
    "a factor behind": (columns("time (s), acc (g) x 1000"), None, "line 1", "x 1000", "convert"),
    "a factor in the name": (columns("time_s,acc_g_x100"), "g", "line 1", "acc_g_x100", "convert"),
    "over a number": (columns("time (s), a/9.81"), "m/s2", "line 1", "a/9.81", "convert"),
    "dates": (columns("time, acc (g)", DATES), None, "line 41", "No line consists of two numbers", "time in s"),
    "too few digits": (columns("time (s), acc (g)", "{t:.2f}, {a}"), None, "time", "too few digits", "more digits"),
    "k-net": (KNET, None, "record", "K-NET", "subtract their mean"),
    "esm": (ESM, None, "record", "ESM", "SAMPLING_INTERVAL_S"),
    "cosmos": (COSMOS, None, "record", "COSMOS", "acceleration block"),
    "smc": (SMC, None, "record", "SMC", "cm/s²"),
    "labview": (LVM, None, "record", "LabVIEW", "Y_Unit_Label"),
    "csmip": (CSMIP, None, "record", "CSMIP", "acceleration block"),
    "velocity in german": (columns("Zeit;Geschwindigkeit", "{t};{a}"), "g", "line 1", "a velocity", "differentiate this one"),
    "a frequency response": (columns("frequency (Hz), amplitude (mm)"), None, "line 1", "a frequency", "`damperlab fit`"),
    "displacement in spanish": (columns("tiempo,desplazamiento"), "g", "line 1", "a displacement", "twice"),
    "a step in minutes": (peer(begin="NPTS= 40, DT= .0050 MIN"), None, "line 4", 'the step in "MIN"', "in s"),
    "a rate for a step": (peer(begin="NPTS= 40, DT= 0.2 kHz"), None, "line 4", 'the step in "kHz"', "in s"),
    "contradicted in passing": (columns("Acceleration, g\ntime, a"), "m/s2", "units", 'line 1 mentions "g"', "in a heading"),
    "counts in passing": (columns("# values in counts\ntime, a"), "g", "units", 'line 1 mentions "counts"', "in a heading"),
    "velocity in passing": (columns("# integrated, cm/s\ntime, a"), "g", "units", 'line 1 mentions "cm/s"', "in a heading"),
    "scaled": (columns("# Scale factor: 0.001\ntime (s), acc (g)"), None, "line 1", "a factor", "multiply the samples"),
    "cut off in a number": (columns(SI, "{t:.3f}, {a:.5f}")[:-1], None, "line 41", "cut off", "complete file"),
    "decimal commas alone": (columns("", "{a:.5f}").replace(".", ","), "g", "line 2", "not later", "decimal points"),
    "an empty cell": (columns(SI).replace("\n0.100, 0.09906", "\n0.100,"), None, "line 22", "1 number", "complete the line"),
    "half milliseconds": (columns("time, acc (g)", step=0.5), None, "time", "counts by 0.5", "time (s)"),
    "a missing value": (columns(CM).replace(" 0.09906", " -9999"), None, "line 22", "a missing sample", "interpolated"),
    "unit beside the step contradicted": (alone("NPTS= 40, DT= 0.005, UNITS= CM/S2"), "g", "units", "says cm/s2", "leave"),
    "velocity beside the step": (alone("NPTS= 40, DT= 0.005, VELOCITY IN CM/S"), "g", "line 1", "a velocity", "differentiate"),
    "commas between thousands": (columns(SI).replace("0.09906", "1,070.9"), None, "line 22", "between thousands", "without"),
    "blanks between thousands": (columns(SI).replace("0.09906", "1 070.9"), None, "line 22", "between thousands", "without"),
    "whole thousands": (columns("s;g", "{t};{a}").replace("0.09906", "1,070"), None, "line 22", "thousands", "no separators"),
    "a power of ten": (columns("time (s), acceleration in 10^-3 m/s2"), None, "line 1", "10^-3", "convert"),
    "an exponent for a factor": (columns("time_s,acc_1e-3_g"), None, "line 1", "acc_1e-3_g", "convert"),
    "an exponent behind": (columns("time (s), acceleration (m/s2) E-3"), None, "line 1", "E-3", "convert"),
    "a number first": (columns("time (s), 1000 acceleration (g)"), None, "line 1", "1000 acc", "convert"),
    "times a number": (columns("time (s), acceleration times 1000 (g)"), None, "line 1", "times 1000", "convert"),
    "thousandths": (columns("time (s), acceleration thousandths g"), None, "line 1", "thousandths", "convert"),
    "a factor for the time": (columns("time 0.01 s, acceleration g", "{k}, {a}"), None, "line 1", "time 0.01 s", "time (s)"),
    "normalised": (columns("time (s), acceleration (m/s2) normalised by g"), None, "line 1", "normalised", "convert"),
    "a step as a product": (peer(begin="NPTS= 40, DT= 5 x 10^-3 SEC"), None, "line 4", "x 10^-3", "DT= <step in s>"),
    "a step without its E": (peer(begin="NPTS= 40, DT= 5.0-03 SEC"), None, "line 4", "5.0-03", "DT= <step in s>"),
    "a step with a comma": (peer(begin="NPTS= 40, DT= 0,005 SEC"), None, "line 4", "0,005", "DT= <step in s>"),
    "times among the samples": ("units of g\nNPTS= 80, DT= 0.005\n" + columns(""), None, "line 2", "40 lines", "correct"),
    "a second record": (peer() + "\n" + peer(), None, "line 13", "a second record", "its own file"),
    "pseudo": (columns("T [s],pseudo-acceleration [g]"), None, "line 1", "a response spectrum", "over time"),
    "a design spectrum": (columns("Elastic design spectrum\nT (s), acceleration (g)"), None, "line 2", "spectrum", "over"),
    "no E": (alone("units of g", "40 0.005").replace("0.09906", "9.906-02"), None, "line 23", "without E", "9.906E-02"),
    "samples in pairs": (columns("", "{a} {a}"), "g", "line 2", "does not increase", "NPTS= <number>"),
    "columns named as peer's": ("PEER\n" + columns(SI), None, "line 4", "NPTS=<number>", "name it .csv"),
    "no blanks between": (peer().split("  0.")[0] + "\n" + 2 * "1000.1234", None, "line 6", "below line 4", "blanks"),
    "rms values": (columns("time (s), rms acceleration (g)"), None, "line 1", "an rms value", "over time"),
    "rms values in words": (columns("t (s), root-mean-square acc (g)"), "g", "line 1", "an rms value", "over time"),
    "an envelope": (columns("time (s), envelope of acceleration (g)"), None, "line 1", "an envelope", "over time"),
    "logarithms": (columns("time (s), log10(acc) (g)"), "g", "line 1", "a logarithm", "not its logarithm"),
    "a response": (columns("time (s), relative acceleration (g)"), None, "line 1", "a relative acc", "of the base"),
    "a number of samples with a comma": (alone("units of g", "NPTS= 1,040, DT= 0.005"), None, "line 2", "1,040", "NPTS= <n"),
    "the step first": (alone("units of g", "DT= 0.005, NPTS= 40"), None, "line 2", "of the form NPTS=", "NPTS= <number>"),
    "bars": (columns("time (s)|acc (g)", "{t:.3f}|{a}"), None, "line 41", "No line consists of two numbers", "semicolon, tab"),
    "a clock that runs late": (LATE, None, "line 4", "0.010002 s in line 4 is off", "resample"),
    "the first step": (SOON, None, "line 3", "0.001 s, but the usual step is 0.005 s", "resample"),
    "a workbook": (b"PK\x03\x04[Content_Types].xml" + b"\0" * 50, None, "record", "a workbook", "save the sheet as CSV"),
    "an archive": (b"PK\x03\x04a.at2" + b"\0" * 50, None, "record", "a compressed file", "unpack it"),
    "compressed": (gzip.compress(columns(SI).encode()), None, "record", "a compressed file", "unpack it"),
    "binary": (b"\x01\x00\x00\x07" * 100, None, "record", "a binary file", "as text"),
}  # fmt: skip


@pytest.mark.parametrize("form", BROKEN)
def test_what_cannot_be_read_is_refused_with_its_reason_and_a_remedy(form: str) -> None:
    text, units, field, reason, remedy = BROKEN[form]
    (fault,) = faults_of(read_record, text, layout_of(text), units=units)
    assert fault.field == field
    assert reason in fault.sentence
    assert remedy in fault.advice
    assert all((fault.found, fault.allowed))
