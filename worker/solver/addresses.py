"""Addresses of arrays, which replace the arrays inside an integration.

For every array argument, numba counts the references by atomic instructions. In an integration, this counting would
take five sixths of the run time. The integrator therefore passes addresses to the functions that it calls. The caller
of the integrator keeps the arrays alive.

Indices into an address are not checked. With NUMBA_BOUNDSCHECK=1, one-dimensional arrays replace the addresses, and
numba checks their indices.
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
    """A one-dimensional array of numbers, or the address of an array."""

    def __getitem__(self, i: int, /) -> float:
        """Return one number of the sequence."""

    def __setitem__(self, i: int, number: float, /) -> None:
        """Replace one number of the sequence."""


if numba.config.DISABLE_JIT:

    def address(array: Any, first: int) -> Any:
        """Return a flat view of the array that begins at element `first`, if numba is disabled."""
        return array.reshape(-1)[first:]

elif numba.config.BOUNDSCHECK:

    @inlined
    def address(array: Any, first: int) -> Any:
        """Return a flat view of the array that begins at element `first`."""
        return array.reshape(-1)[first:]

else:

    @intrinsic  # type: ignore[untyped-decorator]
    def address(typingctx: Any, array: Any, first: Any) -> Any:
        """Return the address of element `first`.

        The first argument is a contiguous array or the address of an array. The array must outlive the result.
        """
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
    """Return the address of an array or, if numba checks indices, a one-dimensional view of the array."""
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
        """Flatten an array, or all arrays in a named tuple, if numba is disabled."""
        if isinstance(value, np.ndarray):
            return value.reshape(-1)
        if isinstance(value, tuple):
            return type(value)(*map(on_addresses, value))
        return value

else:

    @intrinsic  # type: ignore[untyped-decorator]
    def on_addresses(typingctx: Any, value: Any) -> Any:
        """Return a nested named tuple with addresses in place of its arrays.

        The arrays must be contiguous and must outlive the result. If the tuple still contained an array,
        numba would count the references to the array at every event.
        """

        def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            made = _value_on_addresses(context, builder, signature.args[0], arguments[0])
            return impl_ret_borrowed(context, builder, signature.return_type, made)

        return _type_on_addresses(value)(value), codegen
