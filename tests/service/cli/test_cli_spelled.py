"""What a command refuses goes by the option that it was given by, and each option that is given counts."""

from pathlib import Path

import pytest
from tests.service.cli.commands import run

PEAKS = "frequency ratio,amplitude ratio\n0.9,4\n1.0,6\n1.1,4\n"


@pytest.mark.parametrize(
    ("arguments", "option"),
    [
        (("earthquake", "el-centro", "--units", "m/s2"), "--units"),
        (("earthquake", "x.csv", "--kanai-tajimi", "1"), "RECORD"),
        (("earthquake", "--kanai-tajimi", "1", "--units", "g"), "--units"),
        (("records", "--units", "g"), "--units"),
        (("records", "--name", "mine"), "--name"),
        (("studies", "--named", "--state", "done"), "--state"),
        (("refine", "x", "--boundary", "clearance_ratio", "--objective", "peak"), "--objective"),
        (("refine", "x", "--boundary", "clearance_ratio", "--budget", "3"), "--budget"),
    ],
    ids=lambda each: " ".join(each) if isinstance(each, tuple) else "",
)
def test_an_option_that_would_change_nothing_is_refused(
    tmp_path: Path, arguments: tuple[str, ...], option: str
) -> None:
    first = run(*arguments, "--data-dir", tmp_path / "data", status=2).stderr.splitlines()[0]
    assert option in first
    assert "out" in first  # what to do: leave it out


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("earthquake", "--case", "foo"), '`--case` must be one of none, tmd, pid, fd, hybrid, not the text "foo"'),
        (("earthquake", "--case", "tmd", "--case", "hybrd"), "Write hybrid."),
        (("earthquake", "--clearance-m", "-1"), "`--clearance-m` must be"),
        (("earthquake", "--kanai-tajimi", "1", "--peak-g", "-1"), "`--peak-g` must be"),
        (("records", "--kanai-tajimi", "1", "--duration-s", "-1"), "`--duration-s` must be"),
        (("tmd", "x", "--tmd-mass-ratio", "-1"), "`--tmd-mass-ratio` must be a number above 0 and at most 10, not -1.0."),
        (("tmd", "x", "--detuning", "-2"), "`--detuning` must be a number above -1 and at most 10, not -2.0."),
        (("race", "x", "--confidence", "0.2"), "`--confidence` must be a number from 0.5 to 0.9999, not 0.2."),
        (("remark", "x"), "--tags, --note: found neither of them; allowed: one or both"),
        (("remark", "x", "--tags", "Big_Tag"), "`--tags` must be"),
        (("simulate", "--method", "rk4"), "`--cycles` is missing"),
        (("simulate", "--clearance-ratio", "-1"), "or write --no-particle."),
        (("simulate", "--contact", "dwell", "--contact-time", "-2"), "`--contact-time` must be"),
        (
            ("simulate", "--method", "rk4", "--cycles", "3", "--contact", "dwell", "--contact-time", "0.1"),
            "`--contact` must be instant with method rk4, not dwell. Write --method event.",
        ),
        (("optimum", "x", "--within", "excitation_frequency_hz=9,3"), "--within: found '9,3', allowed: lo not above hi"),
        (("studies", "--within", "clearance_ratio=9"), "--within: found 'clearance_ratio=9', allowed: "),
        (("studies", "--within", "clearance_ratio=9,3"), "--within: found 'clearance_ratio=9,3', allowed: lo not above hi"),
        (("studies", "--within", "clearence_ratio=2,5"), "Write clearance_ratio."),
        (("studies", "--cursor", "xx"), '`--cursor` must be the cursor of a page, not the text "xx".'),
        (("studies", "--tag", "A_B"), "`--tag` must be"),
        (("fit", "PEAKS"), "as in --fit restitution --fit friction_ratio=0,1."),
        (("fit", "PEAKS", "--fit", "natural_frequency_hz"), "as in --fit natural_frequency_hz=LOW,HIGH."),
        (
            ("fit", "PEAKS", "--fit", "damping_ratio", "--no-particle"),
            "`--friction-ratio` is neither given nor estimated nor a column of the table",
        ),
    ],
    ids=lambda each: " ".join(each[:2]) if isinstance(each, tuple) else "",
)  # fmt: skip
def test_what_is_refused_is_called_as_the_option_is(
    tmp_path: Path, arguments: tuple[str, ...], told: str
) -> None:
    (tmp_path / "peaks.csv").write_text(PEAKS)
    asked = [str(tmp_path / "peaks.csv") if each == "PEAKS" else each for each in arguments]
    place = () if asked[0] == "simulate" else ("--data-dir", tmp_path / "data")
    assert told in run(*asked, *place, status=2).stderr
