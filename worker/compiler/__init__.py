"""Compilation of kernels with numba: a kernel and all functions that it calls are linked, optimised and emitted once.

By default, numba optimises and emits each function together with all functions that it calls, and repeats this work for
each caller. A kernel calls some two hundred functions, so most of this work would be wasted. Many libraries would also
contain the same function, each with different optimisations, and the loader would select one of these versions.

In this package, a function that other kernels call remains LLVM IR (`Part`). Only a function that Python calls becomes
machine code (`Whole`), with one private copy of each called function. So the bits of a result depend only on the
sources and the target, not on other functions that the process has compiled or loaded.

The compiler differs from numba in three other respects. Whether a field is None is tested at compile time, so
that a function can receive a complete scene (`FoldTypeTests`). A product and a sum in one expression of the
source are rounded once (`FromTyped`). A kernel may call `_replace` of a named tuple (`replace`).

The compiler uses numba's documented `pipeline_class`; numba is not patched.
"""
