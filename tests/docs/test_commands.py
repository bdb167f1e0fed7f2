"""What the pages say that commands print is what they print."""

import io
import os
import shlex
from contextlib import chdir, redirect_stdout
from pathlib import Path
from unittest.mock import patch

import numpy as np
import pytest
from docs import demo
from docs.computed import is_of_here
from docs.console import (
    HOW,
    ROOT,
    Shown,
    difference,
    figures_of,
    pages,
    put_files,
    run,
    shown_again,
    shown_in,
)
from matplotlib.image import imread
from tests.docs.tiers import first_read

from damperlab.service.cli.main import _run

SAME_PICTURE = 1e-4
"""The same where the same bits are computed: what another version of what draws letters may change."""
ALIKE = 0.02
"""Mean difference of two pictures, of 1 from black to white: a wrong curve or map differs by more, a chaotic cell by less."""


def compare(made: Path, kept: Path, exact: bool) -> None:
    new, old = imread(made), imread(kept)
    assert new.shape == old.shape
    off = float(np.abs(new - old).mean())
    assert off < (SAME_PICTURE if exact else ALIKE), f"{kept.name}: {HOW}"


def printed(command: str, folder: Path) -> str:
    """Run a command in this process, which has loaded everything; one that needs a shell as a reader would."""
    name, *words = shlex.split(command.replace("\\\n", ""))
    if Path(name).name != "damperlab" or "|" in words:
        return run(command, folder)
    settings = {"DAMPERLAB_DATA_DIR": str(folder / "data"), "COLUMNS": "110", "NO_COLOR": "1"}
    with chdir(folder), patch.dict(os.environ, settings), redirect_stdout(io.StringIO()) as out:
        assert _run(words) == 0
    return "".join(f"{line.rstrip()}\n" for line in out.getvalue().splitlines())


@pytest.mark.parametrize("page", first_read(pages()))
def test_commands_of_a_page_print_what_it_shows(page: str, tmp_path: Path) -> None:
    text = (ROOT / page).read_text()
    put_files(text, tmp_path)
    exact = is_of_here(page)
    found = [difference(shown, printed(shown.command, tmp_path), exact) for shown in shown_in(text)]
    assert found
    assert "".join(found) == ""
    for made, kept in figures_of(ROOT / page, tmp_path):
        compare(made, kept, exact)


@pytest.mark.night
def test_the_picture_of_the_readme_is_what_make_demo_draws(tmp_path: Path) -> None:
    compare(demo.make(tmp_path), ROOT / demo.PICTURE, is_of_here(demo.PICTURE))


@pytest.mark.parametrize(
    ("told", "found", "same", "exact"),
    [
        ("amplitude 3.91692\n", "amplitude 3.91792\n", False, False),
        ("amplitude 3.91692\n", "amplitudes 3.91692\n", False, False),
        ("a\nb\n", "a\nc\nb\n", False, False),
        ("a\n…\nb\n", "a\nc\n", False, False),
        ("chaotic 3.9\n", "chaotic 4.9\n", False, False),
        # chance is no difference
        ("took … s\n", "took 8.25 s\n", True, True),
        ("a\n…\nb\n", "a\nc\nd\nb\n", True, True),
        # nor is another processor; where the same bits are computed every digit counts
        ("amplitude 3.91692  X/Z\n", "amplitude    3.91693  X/Z\n", True, False),
        ("error 3e-15\n", "error 8e-15\n", True, False),
        ("chaotic 3.9\n", "chaotic 4.1\n", True, False),
        ("a\n…\nchaotic 3.9\n", "a\nb\nchaotic 3.8\n", True, False),
    ],
)
def test_a_page_that_is_out_of_date_is_told_and_can_be_renewed(
    told: str, found: str, same: bool, exact: bool
) -> None:
    shown = Shown("damperlab simulate", told)
    assert (difference(shown, found) == "") is same
    assert (difference(shown, found, exact=True) == "") is exact
    again = Shown(shown.command, shown_again(shown, found))
    assert difference(again, found, exact=True) == ""
