"""Output of the compiler: LLVM IR of a function that other kernels call, or machine code of a complete kernel."""

from collections.abc import Callable
from typing import Any

from llvmlite import binding
from numba.core.codegen import JITCodeLibrary

_ENVIRONMENT = "_ZN08NumbaEnv"


class Part(JITCodeLibrary):  # type: ignore[misc]
    """LLVM IR of a function that other kernels call. The IR is linked into each of these kernels."""

    function: Callable[..., Any]
    """Python function from which this code is compiled."""

    def finalize(self) -> None:
        """Mark the part as complete, without optimisation and without machine code."""
        self._raise_if_finalized()
        self._finalized = True


class Whole(JITCodeLibrary):  # type: ignore[misc]
    """Machine code of a function that Python calls, with its own copy of all called functions."""

    function: Callable[..., Any]
    """Python function from which this code is compiled."""

    @property
    def functions(self) -> list[Callable[..., Any]]:
        """The Python functions of the kernel and of all its parts."""
        parts = (library for library in self._linking_libraries if isinstance(library, Part))
        return [self.function, *(part.function for part in parts)]

    def finalize(self) -> None:
        """Link every part once, then optimise the module and emit machine code."""
        self._own = {variable.name for variable in self._final_module.global_variables}
        self._linking_libraries = _needed(self)
        super().finalize()

    def _optimize_final_module(self) -> None:
        for variable in self._final_module.global_variables:
            # only a Python wrapper uses numba's environment of a function, and a part has no Python wrapper
            if variable.name.startswith(_ENVIRONMENT) and variable.name not in self._own:
                variable.linkage = binding.Linkage.internal
        super()._optimize_final_module()
        for function in self._final_module.functions:
            # The functions become private, so that the loader does not use another kernel's copy.
            # The functions remain public during the optimisation, so that inlining is unaffected.
            if not function.is_declaration and function.linkage == binding.Linkage.linkonce_odr:
                function.linkage = binding.Linkage.internal

    def serialize_using_object_code(self) -> tuple[str, str, tuple[bytes, bytes]]:
        """Serialise the machine code in numba's storage format.

        A stub with only the defined names replaces the IR, because the IR is not linked again.
        """
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
    """List the libraries that `library` needs, directly or through a part.

    In the list, a library comes after all libraries that use it.

    The order matters, because LLVM links a discardable (linkonce) function only if an earlier library needs the
    function.
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
