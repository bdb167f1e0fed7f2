"""Hashes of functions: of their code, and of the values of the global names in the code."""

import enum
import hashlib
import importlib
from collections.abc import Callable, Iterator
from functools import cache
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

_PACKAGE = "damperlab."
UNKNOWN = "unknown"
"""Fingerprint of a function that cannot be hashed.

A function with this fingerprint is always treated as changed.
"""


class _UnknownValue(Exception):
    """Raised for a value that cannot be hashed."""


def name_of(function: Callable[..., Any]) -> str:
    """Return the identifier of a function: its module and its qualified name."""
    return f"{function.__module__}:{function.__qualname__}"


def fingerprint(name: str) -> str:
    """Return the hash of the function with a given identifier (`name_of`).

    The hash includes called kernels only by name, because each kernel has its own fingerprint.

    Returns
    -------
    str
        Hash of 16 hex digits, equal for equal code and values under the same version of Python; `UNKNOWN` if the
        function does not exist or cannot be hashed.
    """
    module, _, qualified = name.partition(":")
    try:
        found: Any = importlib.import_module(module)
        for part in qualified.split("."):
            found = getattr(found, part)
    except (ImportError, AttributeError):
        return UNKNOWN
    return of_function(getattr(found, "py_func", found))


@cache
def of_function(function: FunctionType) -> str:
    """Return the hash of a plain Python function: 16 hex digits, or `UNKNOWN`."""
    digest = hashlib.sha256()
    try:
        for part in _described(function, set()):
            digest.update(part.encode())
    except _UnknownValue:
        return UNKNOWN
    return digest.hexdigest()[:16]


def _described(function: FunctionType, seen: set[int]) -> Iterator[str]:
    if id(function) in seen:
        return
    seen.add(id(function))
    yield from _code(function.__code__)
    held = [cell.cell_contents for cell in function.__closure__ or ()]
    for value in (*held, *(function.__defaults__ or ()), *(function.__kwdefaults__ or {}).values()):
        yield from _value(value, seen)
    for name in sorted(_names(function.__code__)):
        if name in function.__globals__:
            yield name
            yield from _value(function.__globals__[name], seen)


def _code(code: CodeType) -> Iterator[str]:
    """Yield the code of a function as text, without line numbers and docstring."""
    yield f"{code.co_code.hex()} {code.co_names} {code.co_varnames} {code.co_freevars} {code.co_argcount} {code.co_flags}"
    for number, constant in enumerate(code.co_consts):
        if isinstance(constant, CodeType):
            yield from _code(constant)
        elif number or not isinstance(constant, str):  # the first constant is a docstring
            yield f"{type(constant).__name__} {constant!r}"


def _names(code: CodeType) -> set[str]:
    inner = (constant for constant in code.co_consts if isinstance(constant, CodeType))
    return set(code.co_names).union(*map(_names, inner))


def _value(value: Any, seen: set[int]) -> Iterator[str]:
    kind = type(value)
    if hasattr(value, "py_func"):  # a kernel
        yield f"{name_of(value.py_func)} {getattr(value, '_options', None)}"
    elif isinstance(value, FunctionType) and value.__module__.startswith(_PACKAGE):
        yield from _described(value, seen)
    elif isinstance(value, tuple):
        yield f"{kind.__qualname__} {len(value)}"
        for each in value:
            yield from _value(each, seen)
    elif isinstance(value, (bool, int, float, complex, str, bytes, type(None), enum.Enum)):
        yield f"{kind.__name__} {value!r}"
    elif isinstance(value, np.ndarray):
        yield f"{value.dtype} {value.shape} {value.tobytes().hex()}"
    elif isinstance(value, type) and issubclass(value, enum.Enum):
        yield repr({name: member.value for name, member in value.__members__.items()})
    elif isinstance(value, type) and hasattr(value, "_field_defaults"):  # a class of named tuples
        yield f"{value.__qualname__} {value._fields} {value._field_defaults}"  # type: ignore[attr-defined]
    elif hasattr(value, "_defn"):  # a function of numba that writes LLVM IR
        yield from _described(value._defn, seen)
    else:
        yield _foreign(value)


def _foreign(value: Any) -> str:
    """Return the name of an object of another package. The version of the package is part of the identity of every
    kernel.
    """
    module = value.__name__ if isinstance(value, ModuleType) else getattr(value, "__module__", None)
    name = getattr(value, "__qualname__", getattr(value, "__name__", ""))
    if not module or f"{module}.".startswith(_PACKAGE) or not name:
        raise _UnknownValue
    return f"{module} {name}"
