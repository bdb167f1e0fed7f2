"""Values of options and of settings that are refused: by their own name, with what was found and what is allowed."""

import json
from pathlib import Path

import pytest
from tests.service.cli.commands import run

VALUES = [
    (["simulate", "--starts", "300"], "--starts", "300", "at most 256"),
    (["simulate", "--cycles", "0"], "--cycles", "0", "at least 1"),
    (["simulate", "--history", "-1"], "--history", "-1", "at least 0"),
    (["run", "figure-11", "--budget", "-1"], "--budget", "-1", "at least 0"),
    (["run", "figure-11", "--workers", "0"], "--workers", "0", "at least 1"),
    (["run", "figure-11", "--priority", "99"], "--priority", "99", "at most 10"),
    (["run", "figure-11", "--quota", "lots"], "--quota", 'the text "lots"', "a size, such as 50GB"),
    (["serve", "--port", "99999"], "--port", "99999", "at most 65535"),
    (["studies", "--limit", "0"], "--limit", "0", "at least 1"),
    (["records", "--kanai-tajimi", "abc"], "--kanai-tajimi", 'the text "abc"', "a whole number"),
    (["records", "--kanai-tajimi", "1.5"], "--kanai-tajimi", "1.5", "a whole number"),
    (["records", "--peak-g", "high"], "--peak-g", 'the text "high"', "a number"),
]


@pytest.mark.parametrize(
    ("arguments", "option", "found", "allowed"), VALUES, ids=[each[1] for each in VALUES]
)
def test_a_value_is_refused_with_its_option_what_was_found_and_what_is_allowed(
    tmp_path: Path, arguments: list[str], option: str, found: str, allowed: str
) -> None:
    asked = [*arguments, *(() if arguments[0] == "simulate" else ("--data-dir", str(tmp_path)))]
    ended = run(*asked, status=2)
    assert ended.stderr.splitlines()[0].startswith(
        f"damperlab: `{option}` must be {allowed}, not {found}. "
    ), ended.stderr
    if arguments[0] != "serve":
        (fault,) = json.loads(run(*asked, "--json", status=2).stdout)["errors"]
        assert (fault["field"], fault["found"], fault["allowed"]) == (option, found, allowed)


@pytest.mark.parametrize(
    "asked",
    [
        ("simulate", "--damping-ratio", "1.1%"),
        ("response", "x", "--at", "restitution=1.1 %"),
        ("tmd", "x", "--detuning", "1.1%"),
        ("fit", "x.csv", "--fit", "damping_ratio=1.1%,0.02"),
    ],
)
def test_a_per_cent_is_answered_with_its_share(tmp_path: Path, asked: tuple[str, ...]) -> None:
    told = run(
        *asked, *(("--data-dir", tmp_path) if asked[0] in ("response", "tmd") else ()), status=2
    ).stderr
    assert "write the share as a number: 1.1 % is 0.011" in told.replace("Write", "write"), told


def test_a_tag_that_no_study_has_is_not_answered_with_a_study_to_compute(tmp_path: Path) -> None:
    assert "figure-11" in run("studies", "--data-dir", tmp_path).stderr
    told = run("studies", "--tag", "mine", "--data-dir", tmp_path).stderr
    assert told.strip() == "No study matches. Without these options every study is listed."


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [
        ("WORKERS", "abc", 'must be a whole number, not the text "abc".'),
        ("PORT", "99999", "must be at most 65535, not 99999."),
        ("QUOTA_BYTES", "lots", 'must be a size, such as 50GB, not the text "lots".'),
        ("SCHEDULER", "foo", 'is the text "foo". Write it as in tcp://HOST:8786 or tls://HOST:8786.'),
        ("ACCESS", "all", 'must be auto, keys or open, not the text "all".'),
        (
            "CORS_ORIGINS",
            "[a, b]",
            'is the text "[a, b]". Write them separated by commas, or as a list in JSON.',
        ),
    ],
)
def test_a_setting_is_refused_under_the_name_of_its_variable(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, name: str, text: str, told: str
) -> None:
    monkeypatch.setenv(f"DAMPERLAB_{name}", text)
    assert f"`DAMPERLAB_{name}` {told}" in run("studies", "--data-dir", tmp_path, status=2).stderr


def test_a_variable_that_is_no_setting_is_named_with_the_one_that_is_meant(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("DAMPERLAB_CATALOG", "postgresql://nobody")
    monkeypatch.setenv("DAMPERLAB_CACHE_DIR", str(tmp_path))
    said = run("studies", "--data-dir", tmp_path).stderr
    assert (
        said.count("DAMPERLAB_CATALOG is no setting, and is ignored; did you mean DAMPERLAB_CATALOGUE?") == 1
    )
    assert "CACHE_DIR" not in said
