"""Bare addresses of arrays, for the inside of a march.

numba counts references to every array that a function is handed, with locked instructions: measured on a march, five
sixths of its run time. A march takes arrays, which its caller keeps alive, and hands only their addresses on.

An address knows no bounds. In the checked build (NUMBA_BOUNDSCHECK=1) it is the array itself, and every index is checked.
"""

from typing import Any, Protocol

import numba
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from damperlab.worker.jit import inlined


class Floats(Protocol):
    """Numbers in a row: an array of one dimension, or its address."""

    def __getitem__(self, i: int, /) -> float:
        """One of them."""

    def __setitem__(self, i: int, number: float, /) -> None:
        """Replace one of them."""


if numba.config.DISABLE_JIT:

    def address(array: Any, first: int) -> Any:
        """Plain-Python form: the flat array from element `first` on."""
        return array.reshape(-1)[first:]

elif numba.config.BOUNDSCHECK:

    @inlined
    def address(array: Any, first: int) -> Any:
        """The flat array from element `first` on."""
        return array.reshape(-1)[first:]

else:

    @intrinsic  # type: ignore[untyped-decorator]
    def address(typingctx: Any, array: Any, first: Any) -> Any:
        """Address of the element `first` of a contiguous array, or of what an address begins; the array must outlive it."""
        known = isinstance(array, types.CPointer) or (isinstance(array, types.Array) and array.layout == "C")
        if not known or not isinstance(first, types.Integer):
            return None
        signature = types.CPointer(array.dtype)(array, first)

        def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            data = arguments[0]
            if isinstance(signature.args[0], types.Array):
                data = cgutils.create_struct_proxy(signature.args[0])(context, builder, data).data
            return builder.gep(data, [arguments[1]])

        return signature, codegen


@inlined
def address_if(array: Any) -> Any:
    """Address of an array that may be absent."""
    if array is None:
        return None
    return address(array, 0)
