"""How numba compiles a kernel: everything that it calls is linked into it once, optimised once and emitted once.

Left to itself numba optimises and emits every function with all that it calls, again at each level of calls: of a kernel that
calls two hundred functions most of that work is thrown away, and a function stands in many libraries, each optimised
differently, of which the loader picks one. Here a function that is called by another kernel stays LLVM IR (`Part`); only what
Python calls becomes machine code (`Whole`), from one private copy of each of its parts. So its bits depend on the sources
and the target alone, not on what else a process has compiled or loaded.

Built from numba's documented `pipeline_class`, by subclasses; nothing of numba is patched.
"""

import gc
import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from llvmlite import binding
from numba import _dynfunc
from numba.core import compiler, config, typed_passes, untyped_passes
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler_machinery import PassManager, register_pass

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


class _Lowering(typed_passes.NativeLowering):  # type: ignore[misc]
    """From typed IR to LLVM IR, in a library of the wanted class."""

    _library: type[JITCodeLibrary]

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


class _Compiler(compiler.CompilerBase):  # type: ignore[misc]
    """The passes that kernels need: no closures, no literal loops, no rewritten array expressions."""

    _lower: type[_Lowering]

    def define_pipelines(self) -> list[PassManager]:
        passes = PassManager("damperlab")
        for step in (
            untyped_passes.TranslateByteCode,
            untyped_passes.FixupArgs,
            untyped_passes.IRProcessing,
            untyped_passes.DeadBranchPrune,
            untyped_passes.GenericRewrites,
            untyped_passes.ReconstructSSA,
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
    """Hold the garbage collector."""
    collecting = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collecting:
            gc.enable()
