"""The target processor of kernels: the same on every machine with AVX2."""

import os

from llvmlite import binding
from numba.core import config

_V3 = ("avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "popcnt")
"""Features of a processor of level x86-64-v3, as LLVM names them."""


def target_of(triple: str, features: dict[str, bool], wanted: str = "") -> tuple[str, str]:
    """Processor and features of the target: the same on every machine with AVX2.

    Parameters
    ----------
    triple : str
        LLVM's name of the platform, for example x86_64-unknown-linux-gnu.
    features : dict of bool
        Features of the machine's processor.
    wanted : str
        `generic` for the baseline of the architecture, on any processor: equal bits in a cluster that includes
        machines without AVX2.

    Returns
    -------
    processor, features : str
        In LLVM's notation. Older x86-64 processors get the baseline of their architecture, other architectures
        `generic`. This is portable and slower, and gives different last bits, since a product and a sum are then
        rounded twice.
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
