"""`_replace` of named tuples in kernels, as in plain Python."""

import inspect
from typing import Any

from numba import types
from numba.core.imputils import impl_ret_borrowed
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate, Signature, signature
from numba.extending import infer_getattr, lower_builtin

_KEY = "damperlab_replace"


class _Replace(AbstractTemplate):  # type: ignore[misc]
    """Types a call of `_replace`.

    The call has one argument for each field; an ellipsis means that the field is kept.
    """

    key = _KEY
    this: Any

    def generic(self, args: Any, kws: Any) -> Signature | None:
        whole = self.this
        if args or not set(kws) <= set(whole.fields):
            return None
        given = [kws.get(name, types.ellipsis) for name in whole.fields]
        fields = [kws.get(name, kind) for name, kind in zip(whole.fields, whole, strict=True)]
        made = signature(types.BaseTuple.from_types(fields, whole.instance_class), *given, recvr=whole)
        named = inspect.Parameter.POSITIONAL_OR_KEYWORD
        names = [inspect.Parameter(name, named, default=...) for name in whole.fields]
        return made.replace(pysig=inspect.Signature(names))


@infer_getattr
class _Attributes(AttributeTemplate):  # type: ignore[misc]
    key = types.BaseNamedTuple

    def resolve__replace(self, whole: Any) -> Any:
        return types.BoundFunction(_Replace, whole)


@lower_builtin(_KEY, types.BaseNamedTuple, types.VarArg(types.Any))  # type: ignore[untyped-decorator]
def _replaced(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    """Emit the code of a call of `_replace`."""
    whole, *given = arguments
    fields = [
        builder.extract_value(whole, i) if kind == types.ellipsis else value
        for i, (kind, value) in enumerate(zip(signature.args[1:], given, strict=True))
    ]
    made = context.make_tuple(builder, signature.return_type, fields)
    return impl_ret_borrowed(context, builder, signature.return_type, made)
