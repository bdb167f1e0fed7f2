"""Evaluation of type tests at compile time: whether a field is None, and whether a named tuple belongs to a class."""

import operator
from typing import Any

from numba import types
from numba.core import ir
from numba.core.compiler_machinery import FunctionPass, register_pass


@register_pass(mutates_CFG=False, analysis_only=False)
class FoldTypeTests(FunctionPass):  # type: ignore[misc]
    """Replaces type tests by their results, so that numba omits the branches that are never taken.

    By itself, numba evaluates `x is None` at compile time if x is an argument. This pass also evaluates the test for
    fields of named tuples in an argument, at any depth. In addition, it evaluates `isinstance(x, C)` for a class C of
    named tuples. So a kernel can be written in plain Python for complete scenes, and contains no code for elements that
    a scene lacks.
    """

    _name = "damperlab_fold_type_tests"

    def __init__(self) -> None:
        super().__init__()

    def run_pass(self, state: Any) -> bool:
        """Replace each type test in the function of `state` by its result."""
        code = state.func_ir
        for block in code.blocks.values():
            for statement in block.find_insts(ir.Assign):
                answer = self._answer(statement.value, code, state.args)
                if answer is not None:
                    places = code._definitions[statement.target.name]
                    places[places.index(statement.value)] = answer
                    statement.value = answer
        return True

    def _answer(self, value: Any, code: Any, arguments: Any) -> Any:
        """Return the value of an expression as a constant; None if the types of the arguments do not determine the
        value.
        """
        if not isinstance(value, ir.Expr):
            return None
        if value.op in ("getattr", "static_getitem"):
            if isinstance(_type_of(value, code, arguments), types.NoneType):
                return ir.Const(None, value.loc)
        elif value.op == "binop" and value.fn in (operator.is_, operator.is_not):
            left, right = (_type_of(side, code, arguments) for side in (value.lhs, value.rhs))
            if (
                left is not None
                and isinstance(right, types.NoneType)
                and not isinstance(left, types.Optional)
            ):
                absent = isinstance(left, types.NoneType)
                return ir.Const(absent == (value.fn is operator.is_), value.loc)
        elif value.op == "call" and len(value.args) == 2 and not value.kws:
            function, wanted = (_definition(name, code) for name in (value.func, value.args[1]))
            if getattr(function, "value", None) is isinstance:
                found = _type_of(value.args[0], code, arguments)
                if found is not None:
                    return ir.Const(getattr(found, "instance_class", None) is wanted.value, value.loc)
        return None


def _definition(name: ir.Var, code: Any) -> Any:
    """Return the expression assigned to a variable; None if several branches assign the variable."""
    try:
        return code.get_definition(name)
    except KeyError:
        return None


def _type_of(value: Any, code: Any, arguments: Any) -> Any:
    """Return the numba type of an argument, of a field of an argument, or of the constant None.

    For any other value, return None.
    """
    if isinstance(value, ir.Var):
        value = _definition(value, code)
    if isinstance(value, ir.Arg):
        found = arguments[value.index]
        return types.none if isinstance(found, types.Omitted) and found.value is None else found
    if isinstance(value, ir.Const) and value.value is None:
        return types.none
    if isinstance(value, ir.Expr) and value.op in ("getattr", "static_getitem", "exhaust_iter"):
        made = _definition(value.value, code)
        if isinstance(made, ir.Expr) and made.op == "exhaust_iter":
            made = _definition(made.value, code)
        if value.op == "static_getitem" and isinstance(made, ir.Expr) and made.op == "build_tuple":
            return _type_of(made.items[value.index], code, arguments)
        whole = _type_of(value.value, code, arguments)
        if value.op == "exhaust_iter" or not isinstance(whole, types.BaseNamedTuple):
            return whole
        if value.op == "static_getitem":
            return whole.types[value.index] if isinstance(value.index, int) else None
        return whole.types[whole.fields.index(value.attr)] if value.attr in whole.fields else None
    return None
