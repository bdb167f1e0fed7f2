"""How numba compiles a kernel: everything that it calls is linked into it once, optimised once and emitted once.

numba alone optimises and emits each function together with all functions that it calls, and does so for each of its callers
again. A kernel calls some two hundred functions, so most of that work is thrown away. Besides, the same function is then
in many libraries, optimised differently in each, and the loader picks one of them.

Here a function that other kernels call stays LLVM IR (`Part`). Only what Python calls becomes machine code (`Whole`), from one
private copy of each part. So the bits of a result depend on the sources and the target alone, not on what else the process
has compiled or loaded.

Two more things differ from numba. A branch on a field that is None is dropped, so that a function can be handed a whole scene
(`_FoldTypeTests`). And a product and a sum are rounded once where the source has them in one expression (`_FromTyped`).

All of this is done by subclasses, for numba's documented `pipeline_class`; nothing of numba is patched.
"""

import gc
import operator
import os
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

from llvmlite import binding
from llvmlite import ir as llvm
from numba import _dynfunc, types
from numba.core import compiler, config, ir, lowering, typed_passes, untyped_passes
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler_machinery import FunctionPass, PassManager, register_pass

_ENVIRONMENT = "_ZN08NumbaEnv"
_V3 = ("avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "popcnt")
"""Features of a processor of level x86-64-v3, as LLVM names them."""


def target_of(triple: str, features: dict[str, bool], wanted: str = "") -> tuple[str, str]:
    """Processor and features for which kernels are compiled: the same on every machine that has AVX2.

    Parameters
    ----------
    triple : str
        LLVM's name of the platform, such as x86_64-unknown-linux-gnu.
    features : dict of bool
        What the machine's processor has.
    wanted : str
        `generic` for the baseline of the architecture, whatever the processor has: equal bits in a fleet some of whose
        machines lack AVX2.

    Returns
    -------
    processor, features : str
        As LLVM takes them. Older x86-64 processors get the baseline of their architecture, others `generic`: portable,
        slower, and with last bits of their own, since no product and sum are rounded once there.
    """
    if not triple.startswith("x86_64"):
        return "generic", ""
    if wanted != "generic" and all(features.get(name, False) for name in _V3):
        return "x86-64-v3", ""
    return "x86-64", ""


TRIPLE: str = binding.get_process_triple()
PROCESSOR, FEATURES = target_of(
    TRIPLE, dict(binding.get_host_cpu_features()), os.environ.get("DAMPERLAB_TARGET", "")
)
config.CPU_NAME, config.CPU_FEATURES = PROCESSOR, FEATURES  # read when numba compiles for the first time


class Part(JITCodeLibrary):  # type: ignore[misc]
    """A function that other kernels call: IR that waits for what calls it."""

    def finalize(self) -> None:
        """Mark it complete; it is neither optimised as a whole nor emitted."""
        self._raise_if_finalized()
        self._finalized = True


class Whole(JITCodeLibrary):  # type: ignore[misc]
    """A function that Python calls, with its own copy of all that it calls."""

    def finalize(self) -> None:
        """Link every part once, optimise, emit."""
        self._own = {variable.name for variable in self._final_module.global_variables}
        self._linking_libraries = _needed(self)
        super().finalize()

    def _optimize_final_module(self) -> None:
        for variable in self._final_module.global_variables:
            # numba's environment of a function serves its wrapper for Python, which parts lack
            if variable.name.startswith(_ENVIRONMENT) and variable.name not in self._own:
                variable.linkage = binding.Linkage.internal
        super()._optimize_final_module()
        for function in self._final_module.functions:
            # so late, lest it change what is inlined; private, lest the loader take another kernel's copy
            if not function.is_declaration and function.linkage == binding.Linkage.linkonce_odr:
                function.linkage = binding.Linkage.internal

    def serialize_using_object_code(self) -> tuple[str, str, tuple[bytes, bytes]]:
        """As numba stores it, with the names that it defines in place of its IR, which nothing links again."""
        self._ensure_finalized()
        names = [
            value.name
            for values in (self._final_module.functions, self._final_module.global_variables)
            for value in values
            if not value.is_declaration
            and value.linkage in (binding.Linkage.external, binding.Linkage.common)
        ]
        stub = binding.parse_assembly("\n".join(f'@"{name}" = global i8 0' for name in names))
        return self.name, "object", (self._get_compiled_object(), stub.as_bitcode())


def _needed(library: JITCodeLibrary) -> list[JITCodeLibrary]:
    """Every library that one needs, itself or through a part: each once, and after all that need it.

    The order matters: LLVM links a function that may be dropped only if something linked before asks for it.
    """
    seen = set()
    callees_first = []
    waiting = [(needed, False) for needed in reversed(library._linking_libraries)]
    while waiting:
        needed, done = waiting.pop()
        if done:
            callees_first.append(needed)
        elif needed not in seen:
            seen.add(needed)
            waiting.append((needed, True))
            if isinstance(needed, Part):
                waiting.extend((callee, False) for callee in reversed(needed._linking_libraries))
    return callees_first[::-1]


_DOUBLE = llvm.DoubleType()


class _FromTyped(lowering.Lower):  # type: ignore[misc]
    """From typed IR to LLVM IR, with two ways of its own.

    An argument that is never set anew is its value. numba gives one that is used in several blocks a place in memory, and
    loads all of it at each use: of a scene with a hundred fields most is work for LLVM to clear away again.

    A product and a sum are rounded once where both stand in one expression, as in C (FP_CONTRACT ON).

    LLVM would do so wherever the optimiser happens to put the two side by side (`contract`), so that last bits changed with
    what is inlined into what, and with the scene. Here they depend on each expression alone: a kernel may be cut into
    functions, or be handed other arguments, and gives the same bits.
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
        """Count one reference more; a value that holds none, as a scene's, is not taken apart to find that out."""
        if _holds_references(self.context, typ):
            super().incref(typ, value)

    def decref(self, typ: Any, value: Any) -> None:
        """Count one reference less."""
        if _holds_references(self.context, typ):
            super().decref(typ, value)

    def lower_binop(self, result_type: Any, expression: Any, operation: Any) -> Any:
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
        """`one` times `other`, plus `added`; two roundings where the target has no such instruction."""
        form = llvm.FunctionType(_DOUBLE, [_DOUBLE] * 3)
        function = self.builder.module.declare_intrinsic("llvm.fmuladd", [_DOUBLE], form)
        return self.builder.call(function, [one, other, added])


@cache
def _holds_references(context: Any, typ: Any) -> bool:
    """Whether values of a type hold anything whose references are counted."""
    return bool(context.data_model_manager[typ].contains_nrt_meminfo())


def _is_product(name: Any, value: Any) -> bool:
    """Whether an operand is a product that stands in the same expression, and has no name of its own."""
    return name.name.startswith("$") and getattr(value, "opname", "") == "fmul"


class _Lowering(typed_passes.NativeLowering):  # type: ignore[misc]
    """From typed IR to LLVM IR, in a library of the wanted class."""

    _library: type[JITCodeLibrary]
    lowering_class = _FromTyped

    def run_pass(self, state: Any) -> bool:
        state.library = self._library(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        return bool(super().run_pass(state))


@register_pass(mutates_CFG=True, analysis_only=False)
class _LowerWhole(_Lowering):
    _name = "damperlab_lower_whole"
    _library = Whole


@register_pass(mutates_CFG=True, analysis_only=False)
class _LowerPart(_Lowering):
    _name = "damperlab_lower_part"
    _library = Part

    def run_pass(self, state: Any) -> bool:
        """As a function without an address, known to its callers by a stand-in that is never called."""
        super().run_pass(state)
        lowered = state["cr"]
        name = lowered.fndesc.qualname
        stand_in = _dynfunc.make_function(
            lowered.fndesc.lookup_module(), name, name, 0, lowered.env, (state.library,)
        )
        state.targetctx.insert_user_function(stand_in, lowered.fndesc, [state.library])
        state["cr"] = lowered._replace(cfunc=stand_in)
        return True


@register_pass(mutates_CFG=False, analysis_only=False)
class _FoldTypeTests(FunctionPass):  # type: ignore[misc]
    """Answer what the types of the arguments decide, so that the branches not taken are dropped before types are inferred.

    numba drops a branch on `x is None` where x is an argument. Here the same holds for the fields of its named tuples, at any
    depth, and for `isinstance(x, C)` of a class of named tuples C. So a kernel reads as plain Python, is handed whole
    scenes, and holds nothing of what its scene lacks.
    """

    _name = "damperlab_fold_type_tests"

    def __init__(self) -> None:
        super().__init__()

    def run_pass(self, state: Any) -> bool:
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
        """The constant that an expression is for these types; None where it is none."""
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
    """What a variable is set to; None where that depends on the way taken."""
    try:
        return code.get_definition(name)
    except KeyError:
        return None


def _type_of(value: Any, code: Any, arguments: Any) -> Any:
    """Type of a variable or expression that is an argument, a field of one, or None; else None."""
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


class _Flags(compiler.Flags):  # type: ignore[misc]
    """numba's flags, compared by the options that were set.

    They are part of the key under which numba keeps the types of each call. Its own class compares all forty options.
    """

    __slots__ = ()
    _ANY = hash(compiler.Flags())  # numba's is that of the names of its options

    def __hash__(self) -> int:
        return self._ANY

    def __eq__(self, other: object) -> bool:
        if type(other) is _Flags:
            return bool(self._values == other._values)
        return bool(super().__eq__(other))


class _Compiler(compiler.CompilerBase):  # type: ignore[misc]
    """The passes that kernels need: no closures, no literal loops, no rewritten array expressions."""

    _lower: type[_Lowering]

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.state.flags = _Flags(self.state.flags)

    def define_pipelines(self) -> list[PassManager]:
        passes = PassManager("damperlab")
        for step in (
            untyped_passes.TranslateByteCode,
            untyped_passes.FixupArgs,
            untyped_passes.IRProcessing,
            _FoldTypeTests,
            untyped_passes.DeadBranchPrune,
            untyped_passes.GenericRewrites,
            untyped_passes.ReconstructSSA,
            _FoldTypeTests,
            untyped_passes.DeadBranchPrune,
            typed_passes.NopythonTypeInference,
            typed_passes.PreLowerStripPhis,
            typed_passes.IRLegalization,
            self._lower,
            typed_passes.NoPythonBackend,
        ):
            passes.add_pass(step, step.__name__)
        passes.finalize()
        return [passes]


class PartCompiler(_Compiler):
    """Compiles what other kernels call."""

    _lower = _LowerPart

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        flags = self.state.flags
        flags.no_cpython_wrapper = flags.no_cfunc_wrapper = flags.no_compile = True


class WholeCompiler(_Compiler):
    """Compiles what Python calls."""

    _lower = _LowerWhole

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.state.flags.no_cfunc_wrapper = True

    def compile_extra(self, function: Any) -> Any:
        """Compile without the garbage collector, which would walk through millions of live nodes again and again."""
        with _no_collection():
            return super().compile_extra(function)


@contextmanager
def _no_collection() -> Iterator[None]:
    """Pause the garbage collector.

    Afterwards all that was made meanwhile counts as old (freeze, unfreeze), so that collections of the young skip it.
    """
    collecting = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collecting:
            gc.freeze()
            gc.unfreeze()
            gc.enable()
