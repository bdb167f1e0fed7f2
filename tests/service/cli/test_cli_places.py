"""Where commands write is checked before they work: nothing is computed for a file that cannot be written."""

import json
from pathlib import Path
from typing import Any

import pytest
from tests.service.cli.commands import run

Stored = tuple[Path, dict[str, Any]]

FILES = (
    ("map", "bare structure", "-o", "x.png"),
    ("response", "bare structure", "--output", "x.csv"),
    ("optimum", "bare structure", "-o", "x.svg"),
    ("export", "bare structure", "-o", "x.csv"),
    ("export", "bare structure", "-o", "x.nc"),
    ("report", "bare structure", "-o", "x.html"),
    ("simulate", "-o", "x.csv"),
    ("earthquake", "-o", "x.csv"),
    ("design", "prototype", "-o", "x.html"),
    ("fit", "no-such.csv", "--study", "x.yaml"),
    ("fit", "no-such.csv", "--specification", "x.yaml"),
    ("fit", "no-such.csv", "-o", "x.png"),
)
FOLDERS = (("accuracy", "-o", "x"), ("reproduce", "-o", "x"))


def placed(arguments: tuple[str, ...], folder: Path) -> list[str | Path]:
    return [*arguments[:-1], folder / arguments[-1]]


def of_store(arguments: tuple[str, ...], data_dir: Path) -> tuple[str | Path, ...]:
    return () if arguments[0] in ("simulate",) else ("--data-dir", data_dir)


@pytest.mark.parametrize("arguments", [*FILES, *FOLDERS], ids=" ".join)
def test_a_folder_that_cannot_be_made_is_refused_before_anything_is_read(
    stored: Stored, tmp_path: Path, arguments: tuple[str, ...]
) -> None:
    taken = tmp_path / "taken"
    taken.write_text("here already")
    ended = run(*placed(arguments, taken / "below"), *of_store(arguments, stored[0]), status=2)
    assert f"{taken} is a file." in ended.stderr
    # nothing was read before the place was looked at
    assert "no-such.csv" not in ended.stderr
    assert ended.stderr.count("\n") == 1
    assert taken.read_text() == "here already"


@pytest.mark.parametrize("arguments", [*FILES, *FOLDERS], ids=" ".join)
def test_a_folder_that_takes_no_files_is_refused_without_the_system_s_own_words(
    stored: Stored, arguments: tuple[str, ...]
) -> None:
    """/proc refuses files whoever asks, so that this is true of root as well."""
    ended = run(*placed(arguments, Path("/proc")), *of_store(arguments, stored[0]), status=2)
    assert "no file can be made in the folder /proc" in ended.stderr
    assert "Errno" not in ended.stderr
    assert ".partial" not in ended.stderr


def test_what_is_refused_of_a_place_names_the_option_what_was_found_and_what_is_allowed(
    stored: Stored, tmp_path: Path
) -> None:
    (tmp_path / "taken").write_text("")
    asked = ("map", "bare structure", "-o", tmp_path / "taken" / "x.png", "--data-dir", stored[0], "--json")
    document = json.loads(run(*asked, status=2).stdout)
    (fault,) = document["errors"]
    assert (fault["field"], fault["found"]) == ("--output", str(tmp_path / "taken" / "x.png"))
    assert fault["allowed"] == "a file in a folder that can be written"
    assert fault["advice"] == "name another file with --output"


def test_a_folder_is_no_file_and_a_file_no_folder(stored: Stored, tmp_path: Path) -> None:
    folder = tmp_path / "taken.png"
    folder.mkdir()
    ended = run("map", "bare structure", "-o", folder, "--data-dir", stored[0], status=2)
    assert f"{folder} cannot be written: it is a folder" in ended.stderr
    (tmp_path / "file").write_text("here already")
    for output in (tmp_path / "file", tmp_path / "file" / "below"):
        ended = run("accuracy", "-o", output, "--data-dir", stored[0], status=2)
        assert f"{tmp_path / 'file'} is a file" in ended.stderr
    assert (tmp_path / "file").read_text() == "here already"
