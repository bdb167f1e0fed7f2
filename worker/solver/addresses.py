"""Plain addresses of arrays, for use inside an integration.

numba counts references to every array argument of a function with locked instructions, which would take five sixths of
the run time of an integration. The integrator receives arrays, which its caller keeps alive, and passes on only their
addresses.

An address has no bounds. In the checked build (NUMBA_BOUNDSCHECK=1) it is the array itself, and every index is
checked.
"""

from typing import Any, Protocol

import numba
import numpy as np
from numba import types
from numba.core import cgutils
from numba.core.imputils import impl_ret_borrowed
from numba.extending import intrinsic
from numba.np.arrayobj import populate_array

from damperlab.worker.jit import inlined


class Floats(Protocol):
    """Numbers in a row: an array of one dimension, or its address."""

    def __getitem__(self, i: int, /) -> float:
        """One number of the row."""

    def __setitem__(self, i: int, number: float, /) -> None:
        """Replace one number of the row."""


if numba.config.DISABLE_JIT:

    def address(array: Any, first: int) -> Any:
        """Plain-Python form: give the flat array from element `first` on."""
        return array.reshape(-1)[first:]

elif numba.config.BOUNDSCHECK:

    @inlined
    def address(array: Any, first: int) -> Any:
        """The flat array from element `first` on."""
        return array.reshape(-1)[first:]

else:

    @intrinsic  # type: ignore[untyped-decorator]
    def address(typingctx: Any, array: Any, first: Any) -> Any:
        """Address of the element `first` of a contiguous array or of an address; the array must outlive it."""
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


def _flat(context: Any, builder: Any, kind: types.Array, array: Any) -> Any:
    """The flat form of an array: its address or, if indices are checked, the array of one dimension."""
    whole = cgutils.create_struct_proxy(kind)(context, builder, array)
    if not numba.config.BOUNDSCHECK:
        return whole.data
    row = cgutils.create_struct_proxy(_type_on_addresses(kind))(context, builder)
    populate_array(
        row,
        data=whole.data,
        shape=[whole.nitems],
        strides=[whole.itemsize],
        itemsize=whole.itemsize,
        meminfo=whole.meminfo,
        parent=whole.parent,
    )
    return row._getvalue()


def _type_on_addresses(kind: Any) -> Any:
    if isinstance(kind, types.Array):
        return kind.copy(ndim=1) if numba.config.BOUNDSCHECK else types.CPointer(kind.dtype)
    if isinstance(kind, types.BaseNamedTuple):
        return types.BaseTuple.from_types([_type_on_addresses(each) for each in kind], kind.instance_class)
    return kind


def _value_on_addresses(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    if isinstance(kind, types.Array):
        return _flat(context, builder, kind, value)
    if isinstance(kind, types.BaseNamedTuple):
        fields = [
            _value_on_addresses(context, builder, each, builder.extract_value(value, i))
            for i, each in enumerate(kind)
        ]
        return context.make_tuple(builder, _type_on_addresses(kind), fields)
    return value


if numba.config.DISABLE_JIT:

    def on_addresses(value: Any) -> Any:
        """Plain-Python form: flat arrays."""
        if isinstance(value, np.ndarray):
            return value.reshape(-1)
        if isinstance(value, tuple):
            return type(value)(*map(on_addresses, value))
        return value

else:

    @intrinsic  # type: ignore[untyped-decorator]
    def on_addresses(typingctx: Any, value: Any) -> Any:
        """A named tuple with addresses for its arrays, at any depth; the arrays, all contiguous, must outlive it.

        All arrays must be replaced, because references to a remaining one would be counted with locked instructions at
        every event.
        """

        def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            made = _value_on_addresses(context, builder, signature.args[0], arguments[0])
            return impl_ret_borrowed(context, builder, signature.return_type, made)

        return _type_on_addresses(value)(value), codegen
