"""Records: read from files of either format, refused with the line that is wrong, generated, and kept."""

import json
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.studies.documents import faults_of, fields_of

from damperlab.studies.faults import StudyFaults
from damperlab.studies.ground.brief import PEAK, brief_of
from damperlab.studies.ground.builtin import FIRST_COMPONENTS, builtin_ids, builtin_record
from damperlab.studies.ground.files import read_record
from damperlab.studies.ground.kanai_tajimi import kanai_tajimi, read_kanai_tajimi, spectrum
from damperlab.studies.ground.motion import STANDARD_GRAVITY
from damperlab.studies.ground.question import read_earthquake
from damperlab.studies.ground.shelf import RecordDamaged, RecordNotFound, Shelf

AT2 = """PEER NGA STRONG MOTION DATABASE RECORD
A quake, 1/1/2000, A station, 90
ACCELERATION TIME SERIES IN UNITS OF G
NPTS=   7, DT=   .0100 SEC,
  -.1000000E-02   .2000000E-02   .3000000E-02  -.4000000E-02   .5000000E-02
   .6000000E-02  -.7000000E-02
"""
VALUES = np.array([-1, 2, 3, -4, 5, 6, -7]) * 1e-3 * STANDARD_GRAVITY


AS_OTHERS_WRITE_IT = {
    "crlf": AT2.replace("\n", "\r\n"),
    "small letters": AT2.replace("NPTS=   7, DT=   .0100 SEC,", "npts=7 dt=1.0E-2"),
    "fortran D": AT2.replace("   .2000000E-02  ", " .2000000D-02  "),
    "glued minus": AT2.replace("   .3000000E-02  -.4", "   .3000000E-02-.4"),
    "blank end": AT2 + "\n\n",
    "byte order mark": "\ufeff" + AT2,
}


@pytest.mark.parametrize("text", AS_OTHERS_WRITE_IT.values(), ids=AS_OTHERS_WRITE_IT)
def test_the_same_file_as_others_write_it(text: str) -> None:
    motion = read_record(text.encode(), "at2")
    assert (motion.step_s, motion.name) == (0.01, "A quake, 1/1/2000, A station, 90")
    np.testing.assert_allclose(motion.acceleration_m_s2, VALUES, rtol=1e-15)


def peer(old: str, new: str) -> str:
    return AT2.replace(old, new)


@pytest.mark.parametrize(
    ("text", "field"),
    [
        (peer(".3000000E-02", ".3000x00E-02"), "line 5"),
        (peer(".6000000E-02", "NaN"), "line 6"),
        (peer("NPTS=   7", "NPTS=   6"), "line 6"),
        (peer("NPTS=   7", "NPTS=   8"), "line 7"),
        (peer("NPTS=   7, DT=   .0100 SEC,", "nothing here"), "line 4"),
        (peer("DT=   .0100", "DT=   0.0"), "line 4"),
        (peer("DT=   .0100", "DT=   99"), "line 4"),
        (peer(".5000000E-02", ".5000000E+09"), "line 4"),
        (AT2 + "1" * 100_000, "line 7"),
        ("0,0\n0.1,1\n", "units"),
        ("t (s), a (g)\n0,0\n", "line 3"),
        ("t (s), a (g)\n0,0\n0.1,0\n", "line 2"),
        ("", "line 1"),
    ],
)
def test_what_is_wrong_with_a_file_is_told_by_its_line(text: str, field: str) -> None:
    layout: Any = "at2" if text.startswith("PEER") else "csv"
    (fault,) = faults_of(read_record, text, layout)
    assert fault.field == field
    assert all((fault.found, fault.allowed, fault.advice))
    assert field != "units" or "`--units`" in fault.advice


@pytest.mark.parametrize(
    ("text", "layout", "own", "other"),
    [
        (AT2, "at2", "g", "m/s2"),
        (AT2.replace("UNITS OF G", "UNITS OF CM/SEC/SEC"), "at2", "cm/s2", "g"),
        ("time (s), acceleration (m/s^2)\n0,0\n0.1,1\n", "csv", "m/s2", "g"),
        ("t (s), a (Gal)\n0,0\n0.1,1\n", "csv", "cm/s2", "m/s2"),
    ],
)
def test_units_may_repeat_what_the_file_says_and_not_contradict_it(
    text: str, layout: str, own: str, other: str
) -> None:
    said = read_record(text, layout)  # type: ignore[arg-type]
    assert read_record(text, layout, units=own).content == said.content  # type: ignore[arg-type]
    (fault,) = faults_of(read_record, text, layout, units=other)
    assert (fault.field, fault.found) == ("units", f"{other} while the file says {own}")


@pytest.mark.parametrize("spelled", ["m/s^2", "m/s²", "M/SEC/SEC", "gal", "mg", "% g", "ft/s2"])
def test_units_are_given_in_every_spelling_that_a_heading_may_have(spelled: str) -> None:
    said = read_record(f"time (s), acceleration ({spelled})\n0,0\n0.01,1\n0.02,0\n", "csv")
    assert read_record("0,0\n0.01,1\n0.02,0\n", "csv", units=spelled).content == said.content


@settings(max_examples=30, deadline=None)
@given(st.binary(max_size=400))
def test_no_bytes_break_the_readers(content: bytes) -> None:
    for layout in ("at2", "csv"):
        with suppress(StudyFaults):  # anything else is a defect
            read_record(AT2.encode()[:180] + content, layout, "", "g")  # type: ignore[arg-type]


@settings(max_examples=20, deadline=None)
@given(
    st.lists(st.floats(-5.0, 5.0), min_size=2, max_size=40).filter(lambda x: max(map(abs, x)) > 1e-6),
    st.sampled_from([0.005, 0.01, 0.02, 1 / 30]),
    st.sampled_from(["g", "m/s2", "cm/s2"]),
)
def test_what_is_written_is_read(samples: list[float], step: float, units: str) -> None:
    factor = {"g": STANDARD_GRAVITY, "m/s2": 1.0, "cm/s2": 0.01}[units]
    rows = "".join(f"{k * step!r},{a!r}\n" for k, a in enumerate(samples))
    motion = read_record(f"time (s), acceleration ({units})\n{rows}", "csv")
    np.testing.assert_allclose(motion.acceleration_m_s2, np.array(samples) * factor, rtol=1e-15)
    lines = "".join(f"{a:15.7E}" + ("\n" if k % 5 == 4 else "") for k, a in enumerate(samples))
    text = f"PEER\nx\nUNITS OF {units.upper()}\nNPTS= {len(samples)}, DT= {step!r} SEC\n{lines}\n"
    motion = read_record(text, "at2", "", units)
    np.testing.assert_allclose(motion.acceleration_m_s2, np.array(samples) * factor, rtol=1e-7, atol=1e-300)


def test_the_built_in_records_are_what_their_headers_say() -> None:
    sizes = {"loma-prieta-000": (7997, 0.005), "el-centro-180": (5372, 0.01), "northridge-090": (1000, 0.02)}
    for record_id in builtin_ids():
        motion = builtin_record(record_id)
        if record_id in sizes:
            assert (motion.acceleration_m_s2.size, motion.step_s) == sizes[record_id]
    # El Centro 1940 is quoted with 0.28 g in PEER's processing, Corralitos with 0.64 g
    assert builtin_record("el-centro-180").peak_m_s2 / STANDARD_GRAVITY == pytest.approx(0.281, abs=1e-3)
    assert builtin_record("loma-prieta-000").peak_m_s2 / STANDARD_GRAVITY == pytest.approx(0.645, abs=1e-3)
    assert set(FIRST_COMPONENTS.values()) <= set(builtin_ids())


def test_a_seed_is_a_record() -> None:
    one, two = kanai_tajimi(7), kanai_tajimi(7)
    assert one.acceleration_m_s2.tobytes() == two.acceleration_m_s2.tobytes()
    assert kanai_tajimi(8).digest != one.digest
    assert one.peak_m_s2 == pytest.approx(0.3 * STANDARD_GRAVITY, rel=1e-12)
    assert one.duration_s == pytest.approx(30.0, rel=1e-12)


def test_the_periodogram_is_the_spectrum() -> None:
    """Without the trapezoid and over a whole period of the lines, whatever the seed.

    By the law of the second filter, x'' + 2ζωx' + ω²x of the base is the motion of the soil. The displacement between
    samples is that of linear pieces and not of the trapezoidal rule, which is (ωh)²/12 = 3e-5 of the acceleration.
    """
    motion = kanai_tajimi(3, 40.95, 0.01, 3.0, 0.4, rise_s=0.0, fall_s=0.0)
    assert motion.acceleration_m_s2.size == 4096
    omega = 2 * np.pi * 0.3
    velocity, displacement = motion.base_motion()
    soil = motion.acceleration_m_s2 + 2 * 0.6 * omega * velocity + omega**2 * displacement
    lines = np.abs(np.fft.rfft(soil))[1:-1] ** 2
    shape = spectrum(np.fft.rfftfreq(4096, 0.01)[1:-1], 3.0, 0.4)
    np.testing.assert_allclose(lines / lines.sum(), shape / shape.sum(), rtol=1e-4)


@pytest.mark.parametrize("seed", range(2))
def test_the_base_of_an_artificial_record_comes_to_rest(seed: int) -> None:
    """Some tens of centimetres at 0.3 g, as of recorded motions; metres would be drift.

    The filter remembers 1/(ζ_f·ω_f) = 1.06 s, over which the end of the trapezoid, 10 s long, is a tenth of the whole.
    """
    velocity, displacement = kanai_tajimi(seed).base_motion()
    assert 0.03 < np.abs(displacement).max() < 0.5
    assert abs(displacement[-1]) < 0.1 * np.abs(displacement).max()
    assert abs(velocity[-1]) < 0.1 * np.abs(velocity).max()


def test_the_spectrum_is_that_of_kanai_and_tajimi() -> None:
    """1 at rest, (1 + 4ζ²)/(4ζ²) at the frequency of the ground."""
    np.testing.assert_allclose(spectrum([0.0, 2.5], 2.5, 0.6), [1.0, (1 + 4 * 0.36) / (4 * 0.36)], rtol=1e-14)


@pytest.mark.parametrize(
    ("document", "field"),
    [
        ([], "kanai_tajimi"),
        ({"seed": -1}, "kanai_tajimi.seed"),
        ({"seed": 1.5}, "kanai_tajimi.seed"),
        ({"peak_g": 0}, "kanai_tajimi.peak_g"),
        ({"peak": 1}, "kanai_tajimi.peak"),
        ({"rise_s": 20, "fall_s": 20}, "kanai_tajimi.rise_s"),
        ({"duration_s": 1000, "step_s": 0.0001}, "kanai_tajimi.step_s"),
    ],
)
def test_bad_recipes_are_refused(document: object, field: str) -> None:
    assert fields_of(read_kanai_tajimi, document)[0] == field


@pytest.fixture
def shelf(tmp_path: Path) -> Shelf:
    return Shelf(tmp_path)


def test_the_shelf_keeps_a_record_once(shelf: Shelf, tmp_path: Path) -> None:
    motion = kanai_tajimi(1, 2.0, rise_s=0.5, fall_s=0.5)
    record_id, new = shelf.put(motion)
    assert new
    assert shelf.put(motion) == (record_id, False)
    found_id, found = Shelf(tmp_path).get(record_id)
    assert found_id == record_id
    assert found.acceleration_m_s2.tobytes() == motion.acceleration_m_s2.tobytes()
    assert (found.name, found.step_s) == (motion.name, motion.step_s)
    assert shelf.get("el-centro")[0] == "el-centro-180"
    with pytest.raises(RecordNotFound, match="loma-prieta"):
        shelf.get("loma prieta")
    with pytest.raises(RecordNotFound, match=record_id):
        shelf.get(motion.name)
    assert record_id in shelf.ids()
    assert shelf.summaries()[-1] == {"id": record_id, **motion.summary()}


def test_no_flipped_bit_of_a_record_is_read(shelf: Shelf) -> None:
    motion = kanai_tajimi(1, 1.0, rise_s=0.5, fall_s=0.5)
    record_id, _ = shelf.put(motion)
    expected = shelf.summaries()[-1]
    random = np.random.default_rng(7)
    for file in (shelf.folder / f"{record_id}.json", shelf.folder / f"{record_id}.npy"):
        whole = file.read_bytes()
        for bit in random.integers(8 * len(whole), size=200):
            content = bytearray(whole)
            content[bit // 8] ^= 1 << bit % 8
            file.write_bytes(bytes(content))
            if list(shelf.damaged()):
                with pytest.raises(RecordDamaged, match=record_id):
                    shelf.get(record_id)
            else:
                found, told = shelf.get(record_id)[1], shelf.summaries()[-1]
                assert (found.content, found.name, found.source) == (
                    motion.content,
                    motion.name,
                    motion.source,
                )
                assert told == expected
        file.unlink()
        assert [one for one, _ in shelf.damaged()] == ([record_id] if file.suffix == ".npy" else [])
        assert shelf.put(motion)[0] == record_id
        assert shelf.get(record_id)[1].content == motion.content


def test_a_summary_of_the_first_release_is_read(shelf: Shelf) -> None:
    motion = kanai_tajimi(1, 1.0, rise_s=0.5, fall_s=0.5)
    record_id, _ = shelf.put(motion)
    (shelf.folder / f"{record_id}.json").write_text(json.dumps(motion.summary()))
    assert shelf.summaries()[-1] == {"id": record_id, **motion.summary()}


def test_every_fault_of_a_comparison_at_once(shelf: Shelf) -> None:
    wrong = {"record": "nowhere", "scale": 0, "mass": 1, "restitution": 2, "starts": 1e9, "cases": ["all"]}
    fields = set(fields_of(read_earthquake, wrong, shelf))
    assert fields == {"record", "scale", "mass", "restitution", "starts", "cases[0]"}


def case(label: str, peak_m: float, acceleration: float = 1.0, stuck: float = 0.0) -> dict[str, Any]:
    return {
        "label": label,
        PEAK: peak_m,
        "peak_absolute_acceleration_m_s2": acceleration,
        "stick_fraction": stuck,
    }


HYBRID = case("particle and friction", 5.75e-3)


@pytest.mark.parametrize(
    ("cases", "told"),
    [
        # the damper with fewer parts is named as good and not as least
        ([case("TMD", 5.8e-3), HYBRID], "TMD moves as little as any, within 2 %, against the base: 5.8 mm"),
        ([case("TMD", 5.7e-3), HYBRID], "TMD moves least against the base: 5.7 mm"),
        # a structure that moves with the ground is not damped; a stored share may be below 1 by rounding
        (
            [case("no damper", 0.05, 12.0), case("friction", 0.0, 2.5, 1.0 - 4e-14)],
            "friction holds the structure to its base throughout: it moves with the ground, at up to 2.5 m/s²",
        ),
        ([case("TMD", 5e-3)], "Under quake the structure moves 5 mm against the base (TMD)."),
    ],
)
def test_of_cases_under_a_record_the_one_that_does_best_is_said_first(
    cases: list[dict[str, Any]], told: str
) -> None:
    record = {"name": "quake", "peak_displacement_m": 0.01}
    names = ("none", "fd") if cases[0]["label"] == "no damper" else ("tmd", "hybrid")
    compared = {
        "cases": dict(zip(names, cases, strict=False)),
        "record": record,
        "design": {"scale": 1.0},
    }
    assert told in brief_of(compared).sentences[0]
