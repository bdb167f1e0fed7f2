"""What is stored, generated or fitted has the same bits on processors for which numpy and OpenBLAS have other code."""

import ast
import os
import platform
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from damperlab.studies.store.solver import SOURCES
from damperlab.worker.provenance import libm

ROOT = Path(__file__).parents[2]
X86_64 = platform.machine() in ("x86_64", "AMD64")
GLIBC = platform.libc_ver()[0] == "glibc"

OF_PROCESSORS = {"exp", "exp2", "expm1", "log", "log2", "log10", "log1p", "sin", "cos", "tan", "sinh", "cosh", "tanh"} | {
    *("arcsin", "arccos", "arctan", "arctan2", "arcsinh", "arccosh", "arctanh", "power", "float_power", "cbrt"),
    *("geomspace", "logspace", "linalg", "dot", "vdot", "inner", "matmul", "cov", "corrcoef", "polyfit", "argpartition"),
    *("polynomial", "roots", "convolve", "correlate", "tensordot", "logaddexp", "sinc"),
}  # fmt: skip
"""What numpy computes with code for a family of processors."""
PORTABLE = (
    *SOURCES,
    "worker/fit",
    "studies/fit",
    "studies/ground/sweep.py",
    "studies/ground/recipe.py",
    "studies/ground/random_vibration.py",
    "studies/ground/shock.py",
    "studies/ground/kanai_tajimi.py",
)
ANSWERS = {"worker/ground/absorber.py", "worker/ground/response_spectrum.py"}
"""Computed when it is asked for, and stored nowhere."""


def older_processor() -> dict[str, str]:
    """Environment in which numpy and OpenBLAS take their code for a processor of 2008.

    Where the processor has AVX-512 that is other code for exponentials and sines too; elsewhere numpy has but one.
    """
    found = np.show_config(mode="dicts")["SIMD Extensions"]["found"]
    assert found
    return {"NPY_DISABLE_CPU_FEATURES": " ".join(found), "OPENBLAS_CORETYPE": "Nehalem"}


def python(*arguments: str, **environment: str) -> str:
    done = subprocess.run(
        [sys.executable, *arguments],
        capture_output=True,
        text=True,
        check=True,
        cwd=ROOT,
        env=os.environ | environment,
    )
    return done.stdout


@pytest.mark.night
@pytest.mark.skipif(not X86_64, reason="for other processors OpenBLAS has no such names")
def test_an_older_processor_has_the_same_bits() -> None:
    here = python("-m", "tests.worker.portable_run")
    older = python("-m", "tests.worker.portable_run", **older_processor())
    assert here.count("\n") == 14
    assert older == here


@pytest.mark.skipif(not (X86_64 and GLIBC), reason="the variable is glibc's")
def test_a_c_library_that_takes_other_functions_is_told_apart() -> None:
    code = "from damperlab.worker.provenance import libm; print(libm())"
    assert python("-c", code).strip() == libm()
    other = python("-c", code, GLIBC_TUNABLES="glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4").strip()
    fused = "fma" in Path("/proc/cpuinfo").read_text()
    assert (other != libm()) == fused


def of_a_processor(tree: ast.AST) -> Iterator[int]:
    for node in ast.walk(tree):
        match node:
            case ast.BinOp(op=ast.MatMult()) | ast.AugAssign(op=ast.MatMult()):
                yield node.lineno
            case ast.ImportFrom(module="numpy") | ast.Call(func=ast.Attribute(attr="dot")):
                yield node.lineno
            case ast.Attribute(value=ast.Name(id="np"), attr=name) if name in OF_PROCESSORS:
                yield node.lineno
            case ast.Call(func=ast.Attribute(attr="argsort"), keywords=given):
                if not any(one.arg == "kind" for one in given):
                    yield node.lineno


def test_what_decides_a_bit_of_a_result_asks_numpy_for_nothing_that_depends_on_the_processor() -> None:
    files = [
        path
        for each in PORTABLE
        for path in ([ROOT / each] if each.endswith(".py") else (ROOT / each).rglob("*.py"))
    ]
    found = [
        f"{path.relative_to(ROOT)}:{line}"
        for path in files
        for line in of_a_processor(ast.parse(path.read_text()))
        if str(path.relative_to(ROOT)) not in ANSWERS
    ]
    assert len(files) > 80
    assert found == []
