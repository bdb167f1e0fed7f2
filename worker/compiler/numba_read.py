"""Check that the compiler was written for the installed version of numba.

The compiler overrides and calls methods outside numba's public interface, reviewed in the version that pyproject.toml
allows. If the installed numba lacks one of these methods or defines the method differently, numba compiles
kernels without this compiler (`ALONE`). Compilation is then slower and is repeated in every process, and the
last digits of results differ.
"""

import hashlib
import inspect
import warnings
from importlib import import_module

import numba

READ: dict[str, str] = {
    "numba.core.codegen:CodeLibrary._ensure_finalized": "fe8a6e1f04e7",
    "numba.core.codegen:CodeLibrary._raise_if_finalized": "1da89a71b49d",
    "numba.core.codegen:CPUCodeLibrary.finalize": "4b4c34b83488",
    "numba.core.codegen:CPUCodeLibrary._optimize_final_module": "e405bd473752",
    "numba.core.codegen:CPUCodeLibrary._get_compiled_object": "13a61024bb35",
    "numba.core.codegen:CPUCodeLibrary.serialize_using_object_code": "a895c26d01ba",
    "numba.core.lowering:Lower._find_singly_assigned_variable": "64279ab677bd",
    "numba.core.lowering:Lower.incref": "e2e2f87b8105",
    "numba.core.lowering:Lower.decref": "e116c5e12395",
    "numba.core.lowering:Lower.lower_binop": "254bcd18aacc",
    "numba.core.typed_passes:NativeLowering.run_pass": "0b482df48654",
    "numba.core.compiler:CompilerBase.__init__": "394d87ab2f36",
    "numba.core.compiler:CompilerBase.compile_extra": "09b90ed8a19d",
    "numba.core.compiler:CompileResult._reduce": "5f86eacfa520",
    "numba.core.compiler:CompileResult._rebuild": "44fa9dc22558",
    "numba.core.targetconfig:TargetConfig.__hash__": "4d15a6c75137",
    "numba.core.targetconfig:TargetConfig.__eq__": "6d8774572d07",
    "numba.core.types:Dispatcher.get_call_type": "ae1ef289d128",
    "numba.core.base:BaseContext.insert_user_function": "f7ed5d870e5a",
}
"""First 12 hexadecimal digits of the SHA-256 hash of each method's source, by the location of the method."""


def differing() -> list[str]:
    """List the methods of `READ` that the installed numba lacks or defines differently."""
    return [where for where, read in READ.items() if _hash(where) != read]


def _hash(where: str) -> str:
    module, _, names = where.partition(":")
    try:
        found = import_module(module)
        for name in names.split("."):
            found = inspect.getattr_static(found, name)
        source = inspect.getsource(getattr(found, "__func__", found))
    except (ImportError, AttributeError, TypeError, OSError):
        return ""
    return hashlib.sha256(source.encode()).hexdigest()[:12]


_DIFFERING = differing()
ALONE = bool(_DIFFERING)
"""Whether numba compiles kernels without this compiler."""
if ALONE:
    warnings.warn(
        f"numba {numba.__version__} differs in {', '.join(_DIFFERING)} from the version that the compiler was written for. "
        "Kernels are compiled by numba alone: slowly, in every process, and with other last digits.",
        RuntimeWarning,
        stacklevel=2,
    )
