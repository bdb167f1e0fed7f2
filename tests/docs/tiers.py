"""Which pages are computed again before every change, and which at night alone."""

from collections.abc import Iterable
from typing import Any

import pytest

FIRST_READ = ("README.md", "docs/tutorial.md")
"""What a newcomer reads first."""


def first_read(pages: Iterable[str]) -> list[Any]:
    """Give the pages as parameters of a test, all but those that are read first marked for the night."""
    night = pytest.mark.night
    return [page if page in FIRST_READ else pytest.param(page, marks=night) for page in pages]
