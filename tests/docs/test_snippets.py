"""The Python of the pages runs as it stands, block after block, and prints what the pages show."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from docs.computed import is_of_here
from docs.console import ROOT, Shown, difference
from docs.snippets import key_of, pages, put_what_a_reader_has, run_snippets
from tests.docs.tiers import first_read
from tests.service.conftest import serving


@pytest.fixture(scope="module")
def url(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    with serving(tmp_path_factory.mktemp("service")) as running:
        yield running.url


def test_pages_with_python_are_found() -> None:
    assert {"README.md", "docs/how-to/fit.md", "docs/how-to/design.md"} <= set(pages())


@pytest.mark.parametrize("page", first_read(pages()))
def test_python_of_a_page_runs_and_prints_what_it_shows(page: str, url: str, tmp_path: Path) -> None:
    text = (ROOT / page).read_text()
    put_what_a_reader_has(text, tmp_path, url)
    exact = is_of_here(key_of(page))
    for printed, shown in run_snippets(text, url, tmp_path):
        assert shown is None or difference(Shown("python", shown), printed, exact) == ""


def test_a_block_that_fails_is_told(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError, match="ZeroDivisionError"):
        run_snippets("```python\nx = 1\n```\n\n```python\nx / 0\n```\n", "", tmp_path)


def test_blocks_are_one_program_and_each_has_what_it_prints(tmp_path: Path) -> None:
    page = "```python\nx = 1\nprint(x)\n```\n\n```text\n2\n```\n\n```python\nprint(x + 2)\n```\n"
    assert run_snippets(page, "", tmp_path) == [("1\n", "2\n"), ("3\n", None)]
