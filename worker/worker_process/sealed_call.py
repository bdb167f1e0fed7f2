"""Calls that only the worker which makes them can read.

A Dask scheduler unpickles what it hands on, and so loads the module of every function and argument: solver and stores, which
take as long as all else that it loads. Of a sealed call it sees bytes.
"""

import pickle
from collections.abc import Callable
from typing import Any

from distributed.protocol.pickle import dumps


class _Call:
    """What is unpickled as the value of a call, which is made then."""

    def __init__(self, function: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
        self._what = function, arguments

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        return self._what


def sealed(function: Callable[..., Any], *arguments: Any) -> tuple[Callable[[bytes], Any], bytes]:
    """Give what to submit in place of a function and its arguments.

    Workers need nothing of this module: one of another version says that it is of another version.

    Parameters
    ----------
    function : callable
        It travels by name, where it has one that can be imported, and else as Dask's own calls do.
    *arguments
        What it is called with.
    """
    return pickle.loads, dumps(_Call(function, arguments))
