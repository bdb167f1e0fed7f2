"""Lowering of typed IR to LLVM IR, for functions called by kernels and for functions called from Python."""

import operator
from collections import Counter
from functools import cache
from typing import Any

from llvmlite import ir as llvm
from numba import _dynfunc, types
from numba.core import ir, lowering, typed_passes
from numba.core.compiler_machinery import register_pass

from damperlab.worker.compiler.library import Part, Whole

_DOUBLE = llvm.DoubleType()


class FromTyped(lowering.Lower):  # type: ignore[misc]
    """Lowers typed IR to LLVM IR, with two differences from numba.

    An argument that is never reassigned remains an LLVM value and is not stored in memory. If several blocks
    use an argument, numba by default stores the argument in memory, and loads all of it at each use. LLVM
    would then have to remove most of these loads.

    A product and a sum in one expression are rounded once, as in C (FP_CONTRACT ON).

    With LLVM's flag `contract`, the optimiser would fuse a product and a sum wherever it brings them together. The last
    bits would then depend on inlining and on the scene. Here the last bits depend only on the expressions of the
    source, not on how a kernel is split into functions or which arguments it receives.
    """

    def _find_singly_assigned_variable(self) -> None:
        super()._find_singly_assigned_variable()
        times = Counter(
            statement.target.name
            for block in self.func_ir.blocks.values()
            for statement in block.find_insts(ir.Assign)
        )
        for statement in self.func_ir.blocks[min(self.func_ir.blocks)].find_insts(ir.Assign):
            name = statement.target.name
            if isinstance(statement.value, ir.Arg) and times[name] == 1 and not self._counts_references(name):
                self._singly_assigned_vars.add(name)

    def _counts_references(self, name: str) -> bool:
        return _holds_references(self.context, self.typeof(name))

    def incref(self, typ: Any, value: Any) -> None:
        """Increment the reference counts in a value.

        A value without counted references, such as a scene, is skipped, because numba would unpack all its fields.
        """
        if _holds_references(self.context, typ):
            super().incref(typ, value)

    def decref(self, typ: Any, value: Any) -> None:
        """Decrement the reference counts in a value."""
        if _holds_references(self.context, typ):
            super().decref(typ, value)

    def lower_binop(self, result_type: Any, expression: Any, operation: Any) -> Any:
        """Emit the code of an operation.

        A sum of a number and a product in the same expression becomes one fused multiply-add.
        """
        both = self.fndesc.calltypes[expression].args == (types.float64, types.float64)
        if both and operation in (operator.add, operator.sub):
            left, right = self._number(expression.lhs), self._number(expression.rhs)
            negative = operation is operator.sub
            if _is_product(expression.lhs, left):
                one, other = left.operands
                return self._fused(one, other, self.builder.fneg(right) if negative else right)
            if _is_product(expression.rhs, right):
                one, other = right.operands
                return self._fused(self.builder.fneg(one) if negative else one, other, left)
        return super().lower_binop(result_type, expression, operation)

    def _number(self, name: Any) -> Any:
        return self.context.cast(self.builder, self.loadvar(name.name), self.typeof(name.name), types.float64)

    def _fused(self, one: Any, other: Any, added: Any) -> Any:
        """Emit code for `one` · `other` + `added`, rounded once, or twice if the target has no fused multiply-add."""
        form = llvm.FunctionType(_DOUBLE, [_DOUBLE] * 3)
        function = self.builder.module.declare_intrinsic("llvm.fmuladd", [_DOUBLE], form)
        return self.builder.call(function, [one, other, added])


@cache
def _holds_references(context: Any, typ: Any) -> bool:
    """Whether values of a type contain counted references."""
    return bool(context.data_model_manager[typ].contains_nrt_meminfo())


def _is_product(name: Any, value: Any) -> bool:
    """Whether an operand is a product in the same expression, and not a named variable."""
    return name.name.startswith("$") and getattr(value, "opname", "") == "fmul"


class Lowering(typed_passes.NativeLowering):  # type: ignore[misc]
    """Lowers typed IR to LLVM IR in a library of the class `_library`."""

    _library: type[Part | Whole]
    lowering_class = FromTyped

    def run_pass(self, state: Any) -> bool:
        """Lower the function in `state`."""
        state.library = self._library(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.function = state.func_id.func
        state.library.enable_object_caching()
        return bool(super().run_pass(state))


@register_pass(mutates_CFG=True, analysis_only=False)
class LowerWhole(Lowering):
    """Lowers functions called from Python."""

    _name = "damperlab_lower_whole"
    _library = Whole


@register_pass(mutates_CFG=True, analysis_only=False)
class LowerPart(Lowering):
    """Lowers functions called by other kernels."""

    _name = "damperlab_lower_part"
    _library = Part

    def run_pass(self, state: Any) -> bool:
        """Lower a function to IR. The callers receive a placeholder without code, which is never executed."""
        super().run_pass(state)
        lowered = state["cr"]
        name = lowered.fndesc.qualname
        stand_in = _dynfunc.make_function(
            lowered.fndesc.lookup_module(), name, name, 0, lowered.env, (state.library,)
        )
        state.targetctx.insert_user_function(stand_in, lowered.fndesc, [state.library])
        state["cr"] = lowered._replace(cfunc=stand_in)
        return True
