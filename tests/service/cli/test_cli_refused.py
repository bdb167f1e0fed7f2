"""What a command cannot do is refused before anything is computed, by the option's own name."""

import json
import re
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from tests.service.cli.commands import run

Refused = Callable[..., tuple[str, dict[str, Any]]]
PEAKS = "frequency ratio,amplitude ratio\n0.9,4\n1.0,6\n1.1,4\n"
KNOWN = "--no-particle --friction-ratio 0 --base-amplitude-m 0.001 --natural-frequency-hz 2.5"


@pytest.fixture
def refused(tmp_path: Path) -> Refused:
    """Run a command that is refused: what it says, and the problem document that it prints on request."""
    (tmp_path / "peaks.csv").write_text(PEAKS)
    (tmp_path / "wrong.json").write_text('{"structure": null}')
    (tmp_path / "bad.csv").write_text("frequency (Hz), amplitude (mm)\n2.5, twelve\n")
    (tmp_path / "shaken.csv").write_text("time (s), acceleration (g)\n0, 0\n0.01, oops\n")
    (tmp_path / "taken").write_text("")
    (tmp_path / "folder.png").mkdir()

    def ask(
        line: str, data_dir: Path = tmp_path / "data", status: int = 2, as_json: bool = True
    ) -> tuple[str, dict[str, Any]]:
        words: list[str | Path] = [*shlex.split(line.replace("HERE", str(tmp_path)).replace("KNOWN", KNOWN))]
        if words[0] not in ("simulate", "fit", "admin"):
            words += ["--data-dir", data_dir]
        document: dict[str, Any] = {}
        said = run(*words, status=status)
        assert said.stdout == ""
        assert "Traceback" not in said.stderr
        if as_json and words[0] not in ("serve", "admin", "export"):
            document = json.loads(run(*words, "--json", status=status).stdout)
            assert document["exit_status"] == status
            for fault in document.get("errors", ()):
                assert all(fault[key] for key in ("field", "found", "allowed", "advice"))
        assert not list((tmp_path / "data").rglob("*.zarr"))
        return said.stderr, document

    return ask


VALUES = [
    ("simulate --starts 300", "300", "at most 256"),
    ("simulate --cycles 0", "0", "at least 1"),
    ("run figure-11 --budget -1", "-1", "at least 0"),
    ("run figure-11 --workers 0", "0", "at least 1"),
    ("run figure-11 --priority 99", "99", "at most 10"),
    ("run figure-11 --quota lots", 'the text "lots"', "a size, such as 50GB"),
    ("serve --port 99999", "99999", "at most 65535"),
    ("studies --limit 0", "0", "at least 1"),
    ("records --kanai-tajimi abc", 'the text "abc"', "a whole number"),
    ("records --peak-g high", 'the text "high"', "a number"),
    ("tmd x --tmd-mass-ratio -1", "-1.0", "a number above 0 and at most 10"),
    ("tmd x --detuning -2", "-2.0", "a number above -1 and at most 10"),
    ("earthquake --case foo", 'the text "foo"', "one of none, tmd, pid, fd, hybrid"),
    ("studies --cursor xx", 'the text "xx"', "the cursor of a page"),
]


@pytest.mark.parametrize(("line", "found", "allowed"), VALUES)
def test_a_value_is_refused_with_what_was_found_and_what_is_allowed(
    refused: Refused, line: str, found: str, allowed: str
) -> None:
    option = shlex.split(line)[-2]
    said, document = refused(line)
    assert said.startswith(f"damperlab: `{option}` must be {allowed}, not {found}. ")
    for fault in document.get("errors", ()):
        assert (fault["field"], fault["found"], fault["allowed"]) == (option, found, allowed)


NAMED = [
    # there is no such command, argument, study or combination
    ("frobnicate", "frobnicate"),
    ("show", "ID"),
    ("run no-such-study", "no-such-study"),
    ("run figure-11 --workers 2 --scheduler tcp://127.0.0.1:1", "--scheduler"),
    ("run figure-11 --scheduler tcp://host", "Name the host and its port"),
    ("admin worker foo", "`ADDRESS` must be an address"),
    ("export x --format xlsx -o x", "netcdf"),
    ("export x -o HERE/f.dat", "--format"),
    ("map x -o figure.docx", ".png, .svg, .pdf, .csv"),
    ("map x -o HERE/folder.png", "it is a folder"),
    ("design prototype -o report.docx", ".html"),
    ("earthquake -o x.gif", ".png"),
    ("fit HERE/peaks.csv KNOWN --fit damping_ratio -o fit.csv", ".png"),
    ("studies --state lost", "queued, running, done, cancelled, failed"),
    # a place, a range, a number
    ("map x --at clearance_ratio", "dimension=value"),
    ("map x --at clearance_ratio=wide", "finite number"),
    ("optimum x --band 1.1,0.9", "lo not above hi"),
    ("optimum x --within sticks=0,1", "stick_fraction"),
    ("studies --within clearance_ratio=9", "--within"),
    ("simulate --restitution 1.5", "restitution"),
    ("simulate --tilt-deg 3", "--gravity-ratio"),
    ("simulate --excitation-frequency-hz 3", "--frequency-ratio"),
    ("simulate --clearance-ratio -1", "--no-particle"),
    ("simulate --at frequency_ratio=2 --frequency-ratio 3", "--frequency-ratio"),
    ("earthquake --restitution 2", "restitution"),
    ("earthquake --kanai-tajimi 1 --peak-g -1", "`--peak-g` must be"),
    ("records --kanai-tajimi 1 --duration-s -1", "`--duration-s` must be"),
    ("show x --tags Big_Tag", "`--tags` must be"),
    # what one option needs of another
    ("simulate --method rk4", "`--cycles` is missing"),
    ("simulate --excitation force --method rk4 --cycles 3", "excitation"),
    ("simulate --no-particle --clearance-ratio 3", "`--clearance-ratio`"),
    ("simulate --contact dwell", "--contact-time"),
    ("simulate --contact dwell --contact-time -2", "`--contact-time` must be"),
    ("simulate --contact-time 0.1", "--contact dwell"),
    ("simulate --method rk4 --cycles 3 --contact dwell --contact-time 0.1", "--method event"),
    ("simulate --method rk4 --cycles 3 --contact compliant --contact-time 0.1", "--method event"),
    ("earthquake --contact-time 0.1", "--contact dwell"),
    ("earthquake el-centro --duration-s 5", "--kanai-tajimi"),
    ("earthquake --generate '{sweep: {start_hz: 2}}'", "rate_hz_per_s"),
    ("earthquake --generate '{swept: 3}'", "random_vibration and shock"),
    ("earthquake --generate {sweep:[", "YAML"),
    ("earthquake --generate '{random_vibration: {seeds: 2}}'", "you mean `seed`"),
    ("earthquake --generate '{random_vibration: {psd_g2_per_hz: 1}}'", "[0.001, 0.001]"),
    ("records HERE/shaken.csv", "oops"),
    ("records --generate nowhere.yaml", "cannot be read"),
    ("records --generate '{shock: 3}'", "must be a mapping"),
    ("earthquake --generate {} --kanai-tajimi 1", "cannot be combined"),
    ("earthquake nowhere", "loma-prieta"),
    ("earthquake missing.at2", "cannot be read"),
    # what would change nothing is to be left out
    ("earthquake el-centro --units m/s2", "--units"),
    ("earthquake x.csv --kanai-tajimi 1", "RECORD"),
    ("records --units g", "--units"),
    ("records --name mine", "--name"),
    ("studies --named --state done", "--state"),
    ("refine x --boundary clearance_ratio --objective peak", "--objective"),
    ("refine x --boundary clearance_ratio --budget 3", "--budget"),
    ("refine x --at friction_ratio=1", "--boundary"),
    ("response x --at friction_ratio=1 --at friction_ratio=2", "given twice"),
    ("optimum x --within clearance_ratio=1,5 --within clearance_ratio=2,9", "given twice"),
    # numbers that are none, with what is allowed
    ("simulate --clearance-ratio nan", "a number from 1e-12 to 1e+12"),
    ("simulate --at restitution=x", "a number from 0 to 1"),
    ("earthquake --mass-kg inf", "a number from 1e-06 to 1e+12"),
    ("studies --limit x", "a whole number from 1 to 1,000"),
    # a fit
    ("fit HERE/peaks.csv", "--fit restitution"),
    ("fit HERE/peaks.csv --fit natural_frequency_hz", "natural_frequency_hz=LOW,HIGH"),
    ("fit HERE/peaks.csv --fit damping_ratio --no-particle", "`--friction-ratio`"),
    ("fit HERE/peaks.csv KNOWN --fit damping_ratio --deviation many", "a finite number"),
    ("fit HERE/peaks.csv KNOWN --fit damping_ratio --deviation 0%", "standard deviation"),
    ("fit HERE/peaks.csv KNOWN --fit damping_ratio --structure none.yaml", "none.yaml"),
    ("fit HERE/bad.csv KNOWN --fit damping_ratio", "`line 2.amplitude_m`"),
]  # fmt: skip


@pytest.mark.parametrize(("line", "named"), NAMED)
def test_a_refusal_names_the_option_or_what_is_to_be_written(refused: Refused, line: str, named: str) -> None:
    said, document = refused(line)
    assert named in said
    assert named.strip("`") in json.dumps(document, ensure_ascii=False) or not document


@pytest.mark.parametrize(
    ("line", "meant"),
    [
        ("optimun x", "optimum"),
        ("simulate --clerance-ratio 3", "--clearance-ratio"),
        ("map x --at clearence_ratio=3", "clearance_ratio"),
        ("studies --within clearence_ratio=2,5", "clearance_ratio"),
        ("studies --state dne", "done"),
        ("optimum x --objective peek", "peak"),
        ("export x --format cvs -o x", "csv"),
        ("run figur-11", "figure-11"),
        ("earthquake --at clearanc_m=1", "clearance_m"),
        ("earthquake --case tmd --case hybrd", "hybrid"),
        # a per cent is answered with its share
        ("simulate --damping-ratio 1.1%", "1.1 % is 0.011"),
        ("response x --at 'restitution=1.1 %'", "1.1 % is 0.011"),
        ("fit HERE/peaks.csv --fit damping_ratio=1.1%,0.02", "1.1 % is 0.011"),
    ],
)  # fmt: skip
def test_what_is_mistyped_is_answered_with_what_is_meant(refused: Refused, line: str, meant: str) -> None:
    said, _ = refused(line)
    assert re.search(rf"(Did you mean|[Ww]rite|Possible options)\b[^.?]*{re.escape(meant)}\b", said), said


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [
        ("WORKERS", "abc", "a whole number"),
        ("PORT", "99999", "at most 65535"),
        ("QUOTA_BYTES", "lots", "a size, such as 50GB"),
        ("SCHEDULER", "foo", "tcp://HOST:8786"),
        ("ACCESS", "all", "auto, keys or open"),
        ("CORS_ORIGINS", "[a, b]", "separated by commas"),
    ],
)
def test_a_setting_is_refused_under_the_name_of_its_variable(
    refused: Refused, monkeypatch: pytest.MonkeyPatch, name: str, text: str, told: str
) -> None:
    monkeypatch.setenv(f"DAMPERLAB_{name}", text)
    said, _ = refused("studies")
    assert f"`DAMPERLAB_{name}`" in said
    assert told in said


def test_every_fault_of_a_study_is_a_line_of_sentences(refused: Refused, tmp_path: Path) -> None:
    bad = '{"axes": {"clearance_ratio": -1, "friction_ratio": NaN, "speed": 3}, "steady": {"max_cycles": 0}}'
    (tmp_path / "bad.json").write_text(bad)
    said, document = refused("run HERE/bad.json")
    fields = {
        "axes.clearance_ratio",
        "axes.friction_ratio",
        "axes.speed",
        "axes.frequency_ratio",
        "steady.max_cycles",
    }
    assert {error["field"] for error in document["errors"]} == fields
    assert not (tmp_path / "data").exists()
    # what programs get is what people read
    for line, error in zip(said.splitlines(), document["errors"], strict=True):
        assert line.startswith(f"damperlab: {error['message']} ")
        assert re.fullmatch(r"damperlab: `[\w.]+` (is|must) .+\. [A-Z].*[.?]", line), line


def test_a_study_or_a_folder_that_is_not_there_is_named(refused: Refused, tmp_path: Path) -> None:
    _, document = refused("show nobody")
    assert document["type"].endswith(":study-not-found")
    assert "nobody" in document["detail"]
    said, _ = refused("studies", data_dir=tmp_path / "taken" / "data", status=1)
    assert str(tmp_path / "taken" / "data") in said


PLACES = [
    "map x -o PLACE.png", "response x --output PLACE.csv", "optimum x -o PLACE.svg",
    "export x -o PLACE.csv", "export x -o PLACE.nc",
    "report x -o PLACE.html", "simulate -o PLACE.csv", "earthquake -o PLACE.csv", "design prototype -o PLACE.html",
    "fit no-such.csv --study PLACE.yaml", "fit no-such.csv -o PLACE.png",
    "check accuracy -o PLACE", "check paper -o PLACE",
]  # fmt: skip
"""Commands that write; nothing is read or computed for a file that cannot be written."""


@pytest.mark.parametrize("line", PLACES)
@pytest.mark.parametrize(
    ("place", "told"),
    [
        ("HERE/taken/below/x", "taken is a file"),
        # /proc refuses files whoever asks, so that this is true of root as well
        ("/proc/x", "no file can be made in the folder /proc"),
    ],
)
def test_a_place_that_cannot_be_written_is_refused_before_anything_is_read(
    refused: Refused, line: str, place: str, told: str
) -> None:
    said, document = refused(line.replace("PLACE", place))
    assert told in said
    assert "no-such.csv" not in said
    for fault in document.get("errors", ()):
        assert fault["field"] in line.replace("-o", "--output")
