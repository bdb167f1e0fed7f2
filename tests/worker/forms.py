"""Both forms of a kernel: the plain function, and what the compiler makes of it."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import settings

EPS = 2.0**-52
FIXED = settings(max_examples=60, deadline=None, derandomize=True, database=None)

both = pytest.mark.parametrize("form", ["plain", "jitted"])


def in_form(function: Any, form: str) -> Callable[..., Any]:
    """The kernel in one of its forms; under NUMBA_DISABLE_JIT both are the plain function."""
    chosen: Callable[..., Any] = getattr(function, "py_func", function) if form == "plain" else function
    return chosen
