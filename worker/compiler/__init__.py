"""How numba compiles a kernel: everything that it calls is linked into it once, optimised once and emitted once.

numba alone optimises and emits each function together with all functions that it calls, and does so for each of its callers
again. A kernel calls some two hundred functions, so most of that work is thrown away. Besides, the same function is then
in many libraries, optimised differently in each, and the loader picks one of them.

Here a function that other kernels call stays LLVM IR (`Part`). Only what Python calls becomes machine code (`Whole`), from one
private copy of each part. So the bits of a result depend on the sources and the target alone, not on what else the process
has compiled or loaded.

Two more things differ from numba. A branch on a field that is None is dropped, so that a function can be handed a whole scene
(`FoldTypeTests`). And a product and a sum are rounded once where the source has them in one expression (`FromTyped`).

All of this is done by subclasses, for numba's documented `pipeline_class`; nothing of numba is patched.
"""
