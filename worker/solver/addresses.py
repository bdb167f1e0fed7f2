"""Plain addresses of arrays, for use inside an integration.

numba counts the references to each array argument of a function by atomic instructions, which would take five sixths of
an integration's run time. So the integrator passes only addresses of arrays to the functions that it calls. The caller
of the integrator keeps the arrays alive.

Indices are checked only with NUMBA_BOUNDSCHECK=1, when one-dimensional arrays take the place of addresses.
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
    """A sequence of numbers: a one-dimensional array, or the address of an array."""

    def __getitem__(self, i: int, /) -> float:
        """Return one number of the sequence."""

    def __setitem__(self, i: int, number: float, /) -> None:
        """Replace one number of the sequence."""


if numba.config.DISABLE_JIT:

    def address(array: Any, first: int) -> Any:
        """Return the flat array from element `first` on, in plain Python."""
        return array.reshape(-1)[first:]

elif numba.config.BOUNDSCHECK:

    @inlined
    def address(array: Any, first: int) -> Any:
        """Return the flat array from element `first` on."""
        return array.reshape(-1)[first:]

else:

    @intrinsic  # type: ignore[untyped-decorator]
    def address(typingctx: Any, array: Any, first: Any) -> Any:
        """Return the address of element `first` of a contiguous array, or of an array given by its address.

        The array must outlive this address.
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
    """Return the flat form of an array: its address or, if indices are checked, a one-dimensional array."""
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
        """Flatten an array, or the arrays in a tuple, in plain Python."""
        if isinstance(value, np.ndarray):
            return value.reshape(-1)
        if isinstance(value, tuple):
            return type(value)(*map(on_addresses, value))
        return value

else:

    @intrinsic  # type: ignore[untyped-decorator]
    def on_addresses(typingctx: Any, value: Any) -> Any:
        """Return a named tuple in which addresses replace the arrays, at any depth.

        The arrays must be contiguous and outlive the result. If an array remained, numba would count the references to
        this array at every event.
        """

        def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            made = _value_on_addresses(context, builder, signature.args[0], arguments[0])
            return impl_ret_borrowed(context, builder, signature.return_type, made)

        return _type_on_addresses(value)(value), codegen
