"""The target processor of kernels, which is the same on every machine with AVX2."""

import os

from llvmlite import binding
from numba.core import config

_V3 = ("avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "popcnt")
"""Features of a processor of level x86-64-v3, by their names in LLVM."""


def target_of(triple: str, features: dict[str, bool], wanted: str = "") -> tuple[str, str]:
    """Return processor and features of the target, which are the same on every machine with AVX2.

    Parameters
    ----------
    triple : str
        LLVM's name of the platform, for example x86_64-unknown-linux-gnu.
    features : dict of bool
        Features of the machine's processor.
    wanted : str
        `generic` selects the baseline of the architecture on every processor. Machines with and without AVX2 then
        compute equal bits.

    Returns
    -------
    processor, features : str
        Processor and features in LLVM's notation. An x86-64 processor without AVX2 gets the baseline
        `x86-64`. Code for the baseline is slower and gives different last bits, because a product and a sum
        are rounded twice. Other architectures get `generic`.
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
# Read by numba when it compiles for the first time.
config.CPU_NAME, config.CPU_FEATURES = PROCESSOR, FEATURES
