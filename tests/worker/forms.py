"""How kernels are tested: in both of their forms, plain and compiled, and what is left to the night."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import settings

EPS = 2.0**-52
FIXED = settings(max_examples=30, deadline=None, derandomize=True, database=None)

both = pytest.mark.parametrize("form", ["plain", "jitted"])


def night(*values: Any) -> Any:
    """Values of a parametrised test that the night alone tries: another kernel, or more of the same."""
    return pytest.param(*values, marks=pytest.mark.night)


def in_form(function: Any, form: str) -> Callable[..., Any]:
    """The kernel in one of its forms; under NUMBA_DISABLE_JIT both are the plain function."""
    chosen: Callable[..., Any] = getattr(function, "py_func", function) if form == "plain" else function
    return chosen
