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


@pytest.mark.parametrize("page", first_read(pages()))
def test_python_of_a_page_runs_and_prints_what_it_shows(page: str, url: str, tmp_path: Path) -> None:
    text = (ROOT / page).read_text()
    put_what_a_reader_has(text, tmp_path, url)
    exact = is_of_here(key_of(page))
    for printed, shown in run_snippets(text, url, tmp_path):
        assert shown is None or difference(Shown("python", shown), printed, exact) == ""
