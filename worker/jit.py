"""The jit policy: how a function becomes a kernel.

A kernel called by another is a part of it; one called from Python is compiled separately, once per machine
(`compiler`, `kernel_cache`). Under NUMBA_DISABLE_JIT every kernel is the plain function.
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
    """The numba type of a part. A part is compiled once for all values of an argument.

    By default numba compiles a function again for every literal number in a call.
    """

    def get_call_type(self, context: Any, args: Any, kws: Any) -> Any:
        """Signature of a call."""
        return super().get_call_type(
            context,
            tuple(map(types.unliteral, args)),
            {name: types.unliteral(given) for name, given in kws.items()},
        )


register_model(_PartType)(models.OpaqueModel)


class Kernel:
    """A compiled function: it is a part of the kernels that call it, and a separate kernel when Python calls it.

    Parameters
    ----------
    function : callable
        Its plain form.
    options : dict
        numba's.
    """

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        update_wrapper(self, function)
        self.py_func = function
        self._options = options
        self._part = numba.njit(pipeline_class=PartCompiler, **options)(function)

    @cached_property
    def whole(self) -> Any:
        """numba's dispatcher for calls from Python; its kernels are stored on disk unless numba compiles alone."""
        dispatcher = numba.njit(pipeline_class=WholeCompiler, **self._options)(self.py_func)
        if not ALONE:
            dispatcher._cache = KernelCache(self.py_func)
        return dispatcher

    @property
    def _numba_type_(self) -> Any:
        """numba's type for it when a kernel calls it."""
        return _PartType(self._part)

    def __call__(self, *arguments: Any) -> Any:
        """Call the compiled kernel; compile it first for the types of these arguments if needed."""
        return self.whole(*arguments)

    def __reduce__(self) -> str:
        """Pickled by name, as functions are."""
        return self.py_func.__qualname__


def _kernel(function: F, **options: Any) -> F:
    if numba.config.DISABLE_JIT:
        return function
    return Kernel(function, _OPTIONS | options)  # type: ignore[return-value]


def kernel(function: F) -> F:
    """Compile on first call, store on disk, release the GIL.

    numba's `fastmath` is off: sums are never re-ordered. A product and a sum in one expression are rounded once
    (`compiler`). So a point has the same bits in any block, process and order. Division by zero gives inf and NaN as
    in C, because a numerical failure is data, not an exception.

    The compiler decides what is inlined into its caller. By default numba lets the first compiled caller decide this.
    The machine code, though not its results, would then depend on the kernels that a process has compiled before.
    """
    return _kernel(function, forceinline=False)


def inlined(function: F) -> F:
    """Like `kernel`, but always inlined into its callers.

    This is for the small laws inside the integration. By default the compiler does not inline some of them, and their
    states then pass through memory. This costs a quarter of the run time of a measured integration.
    """
    return _kernel(function, forceinline=True)
