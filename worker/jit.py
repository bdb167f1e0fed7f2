"""Decorators that turn a function into a compiled kernel.

A kernel that another kernel calls is compiled into the calling kernel. A kernel that Python calls is compiled once per
machine (see `compiler` and `kernel_cache`). With NUMBA_DISABLE_JIT, kernels are plain Python functions.
"""

from collections.abc import Callable
from functools import cached_property, update_wrapper
from typing import Any, TypeVar

import numba
from numba import types
from numba.extending import models, register_model

from damperlab.worker.compiler.numba_read import ALONE
from damperlab.worker.compiler.pipeline import PartCompiler, WholeCompiler
from damperlab.worker.kernel_cache import (
    CACHE_FOLDER,
    KernelCache,
    identity,
    shipped_folder,
    source_hash,
)

__all__ = ["CACHE_FOLDER", "identity", "inlined", "kernel", "shipped_folder", "source_hash"]

F = TypeVar("F", bound=Callable[..., Any])

_OPTIONS = {"nogil": True, "error_model": "numpy"}


class _PartType(types.Dispatcher):  # type: ignore[misc]
    """The numba type of a kernel that another kernel calls.

    By default, numba compiles a function again for every literal number in a call. With this type, a literal
    number causes no further compilation.
    """

    def get_call_type(self, context: Any, args: Any, kws: Any) -> Any:
        """Return the signature of a call, without literal types."""
        return super().get_call_type(
            context,
            tuple(map(types.unliteral, args)),
            {name: types.unliteral(given) for name, given in kws.items()},
        )


register_model(_PartType)(models.OpaqueModel)


class Kernel:
    """A compiled function.

    Kernels that call this function include its code. For calls from Python, the function is compiled separately.

    Parameters
    ----------
    function : callable
        Plain Python function.
    options : dict
        Options of the numba compiler.
    """

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        update_wrapper(self, function)
        self.py_func = function
        self._options = options
        self._part = numba.njit(pipeline_class=PartCompiler, **options)(function)

    @cached_property
    def whole(self) -> Any:
        """Dispatcher of numba for calls from Python.

        Compiled kernels are stored on disk, unless numba compiles without this package's compiler (`ALONE`).
        """
        dispatcher = numba.njit(pipeline_class=WholeCompiler, **self._options)(self.py_func)
        if not ALONE:
            dispatcher._cache = KernelCache(self.py_func)
        return dispatcher

    @property
    def _numba_type_(self) -> Any:
        """Type that numba uses when another kernel calls this kernel."""
        return _PartType(self._part)

    def __call__(self, *arguments: Any) -> Any:
        """Call the kernel. If the types of the arguments are new, the kernel is compiled first.

        Default values are passed as arguments, because numba would compile another kernel for an omitted argument.
        """
        defaults = self.py_func.__defaults__ or ()
        left_out = self.py_func.__code__.co_argcount - len(arguments)
        return self.whole(*arguments, *defaults[len(defaults) - left_out :])

    def __reduce__(self) -> str:
        """Pickle the kernel by its name, as Python pickles functions."""
        return self.py_func.__qualname__


def _kernel(function: F, **options: Any) -> F:
    if numba.config.DISABLE_JIT:
        return function
    return Kernel(function, _OPTIONS | options)  # type: ignore[return-value]


def kernel(function: F) -> F:
    """Compile a function at its first call, store the kernel on disk, and release the GIL during calls.

    The option `fastmath` of numba is off, so sums are not re-ordered. A product and a sum in one expression are rounded
    once (see `compiler`). So the results at a point have the same bits in any block, process and order. Division by
    zero gives inf or NaN as in C. Kernels report numerical failures by a status and raise no exception.

    The optimiser decides whether the function is inlined. By default, a function would inherit the option
    `forceinline` from the first caller that numba compiles. The machine code, but not the results, would then
    depend on the kernels that a process has compiled before.
    """
    return _kernel(function, forceinline=False)


def inlined(function: F) -> F:
    """Compile a function as `kernel` does, and inline the function into all its callers.

    Use this decorator for small functions that the integration calls often. Without inlining, the states pass through
    memory, which takes a quarter of the run time of a measured integration.
    """
    return _kernel(function, forceinline=True)
