"""Compiling a kernel with numba: all called functions are linked into it once, optimised once and emitted once.

By itself, numba optimises and emits each function together with all functions that it calls, and repeats this for each
caller. A kernel calls some two hundred functions, so most of that work would be wasted. Besides, the same function
would be in many libraries, optimised differently in each, and the loader would pick one of them.

Here a function that other kernels call stays LLVM IR (`Part`). Only functions called from Python become machine code
(`Whole`), with one private copy of each called function. So the bits of a result depend only on the sources and the
target, not on other functions compiled or loaded in the process.

Two more things differ from numba. A branch on a field that is None is dropped, so that a function can receive a
complete scene (`FoldTypeTests`). And a product and a sum in one expression of the source are rounded once
(`FromTyped`).

All of this uses numba's documented `pipeline_class`; numba is not patched.
"""
