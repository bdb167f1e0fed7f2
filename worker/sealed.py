"""Calls that only the worker which makes them can read.

A Dask scheduler unpickles what it hands on, and so loads the module of every function and argument: solver and stores, which
take as long as all else that it loads. Of a sealed call it sees bytes.
"""

import pickle
from collections.abc import Callable
from typing import Any


def sealed(function: Callable[..., Any], *arguments: Any) -> tuple[Callable[[bytes], Any], bytes]:
    """Give what to submit in place of a function and its arguments.

    Parameters
    ----------
    function : callable
        Of a module that workers can import.
    *arguments
        What it is called with.
    """
    return opened, pickle.dumps((function, arguments))


def opened(call: bytes) -> Any:
    """Make a call that was sealed; the value of the Dask task."""
    function, arguments = pickle.loads(call)  # noqa: S301  who reaches a worker can run anything there
    return function(*arguments)
