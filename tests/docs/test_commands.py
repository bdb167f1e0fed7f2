"""What the pages say that commands print is what they print."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from docs.console import ROOT, Shown, difference, figures_of, put_files, run, shown_in

PAGES = sorted(
    path.relative_to(ROOT).as_posix()
    for path in (ROOT / "README.md", *(ROOT / "docs").rglob("*.md"))
    if "```console" in path.read_text()
)
ALIKE = 0.02
"""Mean difference of two pictures, of 1 from black to white: a wrong curve or map differs by more, a chaotic cell by less."""


def test_pages_that_teach_show_commands() -> None:
    assert {"README.md", "docs/tutorial.md", "docs/contact.md"} <= set(PAGES)


@pytest.mark.parametrize("page", PAGES)
def test_commands_of_a_page_print_what_it_shows(page: str, tmp_path: Path) -> None:
    text = (ROOT / page).read_text()
    put_files(text, tmp_path)
    found = [difference(shown, run(shown.command, tmp_path)) for shown in shown_in(text)]
    assert found
    assert "".join(found) == ""
    for made, kept in figures_of(ROOT / page, tmp_path):
        new, old = plt.imread(made), plt.imread(kept)
        assert new.shape == old.shape
        assert float(np.abs(new - old).mean()) < ALIKE, kept.name


@pytest.mark.parametrize(
    ("told", "found"),
    [
        ("amplitude 3.91692\n", "amplitude 3.91792\n"),
        ("amplitude 3.91692\n", "amplitudes 3.91692\n"),
        ("2 impacts\n", "3 impacts\n"),
        ("a\nb\n", "a\nc\nb\n"),
        ("", "a\n"),
        ("a\n…\nb\n", "a\nc\n"),
        ("chaotic 3.9\n", "chaotic 4.9\n"),
    ],
)
def test_a_page_that_is_out_of_date_is_told(told: str, found: str) -> None:
    assert difference(Shown("damperlab simulate", told), found)


@pytest.mark.parametrize(
    ("told", "found"),
    [
        ("amplitude 3.91692  X/Z\n", "amplitude    3.91693  X/Z\n"),
        ("error 3e-15\n", "error 8e-15\n"),
        ("took … s\n", "took 8.25 s\n"),
        ("a\n…\nb\n", "a\nc\nd\nb\n"),
        ("chaotic 3.9\n", "chaotic 4.1\n"),
    ],
)
def test_chance_is_no_difference(told: str, found: str) -> None:
    assert difference(Shown("damperlab simulate", told), found) == ""
