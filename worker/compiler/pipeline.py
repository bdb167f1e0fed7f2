"""The compiler passes of a kernel."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from numba.core import compiler, typed_passes, untyped_passes
from numba.core.compiler_machinery import PassManager

import damperlab.worker.compiler.replace  # noqa: F401, registers `_replace`
from damperlab.worker.compiler.lowering import Lowering, LowerPart, LowerWhole
from damperlab.worker.compiler.numba_read import ALONE
from damperlab.worker.compiler.type_branches import FoldTypeTests


class _Flags(compiler.Flags):  # type: ignore[misc]
    """Compiler flags of numba. Two instances are equal if the same options are set.

    Flags are compared whenever numba looks up the types of a call. The class of numba compares all forty options, which
    is slow.
    """

    __slots__ = ()
    # in numba, all flags have the same hash, because the hash depends only on the names of the options
    _ANY = hash(compiler.Flags())

    def __hash__(self) -> int:
        return self._ANY

    def __eq__(self, other: object) -> bool:
        if type(other) is _Flags:
            return bool(self._values == other._values)
        return bool(super().__eq__(other))


class _Compiler(compiler.CompilerBase):  # type: ignore[misc]
    """Compiler that omits numba's passes for closures, literal loops and array expressions, which kernels do not
    contain.
    """

    _lower: type[Lowering]

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        if not ALONE:
            self.state.flags = _Flags(self.state.flags)

    def define_pipelines(self) -> list[PassManager]:
        passes = PassManager("damperlab")
        for step in (
            untyped_passes.TranslateByteCode,
            untyped_passes.FixupArgs,
            untyped_passes.IRProcessing,
            FoldTypeTests,
            untyped_passes.DeadBranchPrune,
            untyped_passes.GenericRewrites,
            untyped_passes.ReconstructSSA,
            FoldTypeTests,
            untyped_passes.DeadBranchPrune,
            typed_passes.NopythonTypeInference,
            typed_passes.PreLowerStripPhis,
            typed_passes.IRLegalization,
            typed_passes.NativeLowering if ALONE else self._lower,
            typed_passes.NoPythonBackend,
        ):
            passes.add_pass(step, step.__name__)
        passes.finalize()
        return [passes]


class PartCompiler(_Compiler):
    """Compiles functions called by other kernels."""

    _lower = LowerPart

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        if not ALONE:
            flags = self.state.flags
            flags.no_cpython_wrapper = flags.no_cfunc_wrapper = flags.no_compile = True


class WholeCompiler(_Compiler):
    """Compiles functions called from Python."""

    _lower = LowerWhole

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.state.flags.no_cfunc_wrapper = True

    def compile_extra(self, function: Any) -> Any:
        """Compile a function without garbage collection.

        The collector would repeatedly visit millions of live nodes.
        """
        with _no_collection():
            return super().compile_extra(function)


@contextmanager
def _no_collection() -> Iterator[None]:
    """Pause the garbage collector.

    Afterwards, `gc.freeze` and `gc.unfreeze` move all objects to the oldest generation, which the frequent
    collections of younger generations skip.
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
