"""Kernels as processes compile, store and load them."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numba
import numpy as np
import pytest
from numpy.typing import NDArray

from damperlab.worker.compiler.library import Whole
from damperlab.worker.compiler.target import target_of
from damperlab.worker.jit import Kernel, identity, inlined, kernel
from damperlab.worker.kernel_cache import CACHE_FOLDER, cache_folder, folder_name, is_private
from damperlab.worker.scenes import scene_named
from damperlab.worker.solver.addresses import address
from damperlab.worker.warm import warm

ROOT = Path(__file__).parents[2]
RUN = ROOT / "tests" / "worker" / "kernels_run.py"
SCENES = [str(index) for index in range(7)]
HYBRID = "2"
CHECKED = "6"
"""A compliant wall, friction: the scene whose kernel holds most."""


def run(cache: Path, *arguments: str, path: Path = ROOT / "src", **variables: str) -> str:
    environment = {**os.environ, "DAMPERLAB_CACHE_DIR": str(cache), "PYTHONPATH": str(path), **variables}
    return subprocess.run(
        [sys.executable, *arguments], env=environment, check=True, capture_output=True, text=True, cwd=cache
    ).stdout


@pytest.mark.night
def test_kernels_give_the_same_bits_whoever_compiled_them(tmp_path: Path) -> None:
    """Compiled by another process, loaded from another place, compiled anew as they are and with every index checked.

    The kernels are those that `damperlab warm` compiles, so that they are here already, or are kept for who comes next. Every
    index of every scene is checked in plain functions too, where arrays stand in the place of addresses. These round each
    product, and the most irregular of the motions magnifies that 10^11 times in its thirty cycles.
    """
    known = run(CACHE_FOLDER.parent, str(RUN), *SCENES)
    assert [line.split()[0] for line in known.splitlines()] == SCENES
    kept, empty = tmp_path / "kept", tmp_path / "empty"
    (kept / CACHE_FOLDER.name).mkdir(parents=True, mode=0o700)
    for file in CACHE_FOLDER.glob("*.nbc"):
        shutil.copy2(file, kept / CACHE_FOLDER.name)
    copied = {path: path.stat().st_mtime_ns for path in kept.rglob("*.nbc")}
    copy = tmp_path / "elsewhere" / "damperlab"
    shutil.copytree(ROOT / "src" / "damperlab", copy, ignore=shutil.ignore_patterns("__pycache__", "page"))
    # other places, times and order of loading
    assert run(kept, str(RUN), *reversed(SCENES), path=copy.parent) == known
    assert {path: path.stat().st_mtime_ns for path in kept.rglob("*.nbc")} == copied
    empty.mkdir()
    anew = run(empty, str(RUN), HYBRID)
    assert anew in known.splitlines(keepends=True)
    assert len(list(empty.rglob("*.half_cycle-*.nbc"))) == 1
    checked = run(empty, str(RUN), CHECKED, NUMBA_BOUNDSCHECK="1")
    assert checked in known.splitlines(keepends=True)
    assert len(list(empty.rglob("*.half_cycle-*.nbc"))) == 2
    plain = numbers(run(empty, str(RUN), *SCENES, NUMBA_DISABLE_JIT="1"))
    for found, expected in zip(plain, numbers(known), strict=True):
        assert found == pytest.approx(expected, rel=1e-4, abs=1e-4)


def numbers(lines: str) -> list[list[float]]:
    """The numbers of each scene."""
    return [[float.fromhex(word) for word in line.split()[1:]] for line in lines.splitlines()]


def test_kernels_that_are_there_load_nothing_that_compiles() -> None:
    """What numba registers for every function that it can compile takes ten times as long as a kernel to load."""
    ask = (
        f"import sys; sys.path.insert(0, {str(RUN.parent)!r}); import kernels_run\n"
        "kernels_run.bits(*kernels_run.SCENES[2])\n"
        "print([name for name in ('numba.np.arraymath', 'numba.cpython.listobj', 'scipy.linalg') if name in sys.modules])"
    )
    warm(scene_named("transient-friction-particle-instant"))  # so that they are there
    assert run(CACHE_FOLDER.parent, "-c", ask).strip() == "[]"


@kernel
def _plain(x: float) -> float:
    return x + 1.0


@inlined
def _asking(x: float) -> float:
    return 2.0 * _plain(x)


def test_what_is_made_part_of_its_caller_does_not_depend_on_who_asks_first() -> None:
    _asking._part.compile((numba.float64,))  # type: ignore[attr-defined]
    for function, always in ((_asking, True), (_plain, False)):
        (compiled,) = function._part.overloads.values()  # type: ignore[attr-defined]
        assert ("alwaysinline" in compiled.library.get_llvm_str()) is always


@kernel
def _beyond(array: NDArray[np.float64], i: int) -> float:
    return float(array[i])


@kernel
def _beyond_an_address(array: NDArray[np.float64], i: int) -> float:
    return float(address(array, 0)[i])


jitted = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="kernels are plain functions")


def test_a_checked_build_refuses_an_index_beyond_its_array(tmp_path: Path) -> None:
    ask = (
        "import sys; sys.path.insert(0, 'WHERE'); import numpy as np, test_jit\n"
        "for kernel in (test_jit._beyond, test_jit._beyond_an_address):\n"
        "    try: kernel(np.zeros(3), 3)\n"
        "    except IndexError: print('refused')"
    ).replace("WHERE", str(Path(__file__).parent))
    assert run(tmp_path, "-c", ask, NUMBA_BOUNDSCHECK="1").split() == ["refused", "refused"]


@inlined
def _square(x: float) -> float:
    return x * x


@kernel
def _cube(x: float) -> float:
    return x * _square(x)


@kernel
def _fifth(x: float) -> float:
    return _cube(x) * _square(x)


@jitted
def test_what_python_calls_holds_private_copies_of_its_parts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("damperlab.worker.kernel_cache.CACHE_FOLDER", tmp_path)  # compiled here, not loaded
    for function, value in ((_fifth, 1.5**5), (_cube, 1.5**3)):
        assert isinstance(function, Kernel)
        assert function(1.5) == value
        (compiled,) = function.whole.overloads.values()
        assert isinstance(compiled.library, Whole)
        open_names = [
            f.name for f in compiled.library.get_defined_functions() if f.linkage.name == "external"
        ]
        assert sorted(open_names) == sorted(
            (compiled.fndesc.llvm_func_name, compiled.fndesc.llvm_cpython_wrapper_name)
        )


@kernel
def _scaled(x: float, n: int) -> float:
    return x * n


@kernel
def _scales(x: float) -> float:
    return _scaled(x, 2) + _scaled(x, 3) + _scaled(x, n=4)


@jitted
def test_a_part_is_compiled_once_for_all_numbers_that_stand_in_calls_of_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("damperlab.worker.kernel_cache.CACHE_FOLDER", tmp_path)
    assert _scales(1.5) == 13.5
    assert isinstance(_scaled, Kernel)
    assert [signature.args for signature in _scaled._part.nopython_signatures] == [
        (numba.types.float64, numba.types.int64)
    ]


@inlined
def _product(a: float, b: float) -> float:
    return a * b


@kernel
def _rounded_once(a: float, b: float, c: float) -> tuple[float, float, float, float]:
    return a * b - c, c - a * b, a * b + -c, -c + b * a


@kernel
def _rounded_twice(a: float, b: float, c: float) -> tuple[float, float, float]:
    product = a * b
    if c < 0.0:
        product = -product
    return product - c, _product(a, b) - c, (a * b) / 1.0 - c


@jitted
@pytest.mark.skipif(
    "x86-64-v3" not in identity()["target"], reason="no product and sum are rounded once here"
)
def test_a_product_and_a_sum_are_rounded_once_where_they_stand_in_one_expression() -> None:
    a = b = 1.0 + 2.0**-30
    c = a * b  # the square is 1 + 2^-29 + 2^-60: of that the last is lost
    assert _rounded_once(a, b, c) == (2.0**-60, -(2.0**-60), 2.0**-60, 2.0**-60)
    assert _rounded_twice(a, b, c) == (0.0, 0.0, 0.0)


class _Inner(NamedTuple):
    x: float
    y: float | None


class _Other(NamedTuple):
    z: float


class _Outer(NamedTuple):
    inner: _Inner | None
    either: _Inner | _Other
    number: float | None


@inlined
def _whole(outer: _Outer) -> float:
    total = 0.0
    if outer.inner is not None:
        total = outer.inner.x
        if outer.inner.y is not None and outer.number is not None:
            total += outer.inner.y * outer.number
    if isinstance(outer.either, _Other):
        return total + outer.either.z
    return total - outer.either.x


@kernel
def _apart(outer: _Outer) -> float:
    inner, either, number, scale = outer.inner, outer.either, outer.number, 1.0
    found = None if number is None else _Other(number)
    _, kind, _ = outer
    total = _whole(outer) * scale
    if inner is None:
        total *= 2.0
    if isinstance(either, _Other) and isinstance(kind, _Inner):
        total += number  # never: both are one
    if found is not None:
        total += found.z
    return total


@pytest.mark.parametrize("inner", [None, _Inner(1.0, None), _Inner(1.0, 3.0)])
@pytest.mark.parametrize("either", [_Inner(5.0, None), _Other(7.0)])
@pytest.mark.parametrize("number", [None, 11.0])
def test_what_a_tuple_lacks_is_dropped_wherever_it_is_handed_on(
    inner: _Inner | None, either: _Inner | _Other, number: float | None
) -> None:
    """Where a branch that asks for what is absent were kept, numba would refuse the kernel."""
    outer = _Outer(inner, either, number)
    plain = getattr(_apart, "py_func", _apart)
    assert _apart(outer) == plain(outer)


@inlined
def _grown(outer: _Outer, number: float) -> _Outer:
    return outer._replace(number=number, inner=_Inner(number, outer.number))


@pytest.mark.parametrize("number", [None, 11.0])
def test_a_named_tuple_is_replaced_field_by_field_as_in_plain_python(number: float | None) -> None:
    """A field may change its type, as one that was absent does."""

    @kernel
    def replaced(outer: _Outer) -> tuple[_Outer, _Outer]:
        return _grown(outer, 3.0), outer._replace()

    outer = _Outer(None, _Other(7.0), number)
    plain = getattr(replaced, "py_func", replaced)
    assert replaced(outer) == plain(outer)
    with pytest.raises((ValueError, numba.core.errors.TypingError)):
        kernel(lambda outer: outer._replace(other=1.0))(outer)


def test_one_target_for_every_machine_with_avx2() -> None:
    names = ("avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "popcnt")
    level_3 = dict.fromkeys(names, True)
    linux = "x86_64-unknown-linux-gnu"
    assert target_of(linux, level_3) == target_of(linux, level_3 | {"avx512f": True}) == ("x86-64-v3", "")
    for missing in names:
        assert target_of(linux, level_3 | {missing: False}) == ("x86-64", "")
    assert target_of("aarch64-unknown-linux-gnu", level_3) == ("generic", "")
    assert identity()["target"].split()[0] in ("x86-64-v3", "x86-64", "generic")


def test_folders_that_others_can_write_are_not_private(tmp_path: Path) -> None:
    folder = tmp_path / "above" / "kernels"
    folder.mkdir(parents=True)
    folder.chmod(0o700)
    assert is_private(folder)
    for mode in (0o770, 0o707, 0o1777):
        folder.chmod(mode)
        assert not is_private(folder)
    folder.chmod(0o755)
    folder.parent.chmod(0o777)  # another user could put a folder of their own in its place
    assert not is_private(folder)
    folder.parent.chmod(0o1777)  # not so in a sticky one, like /tmp
    assert is_private(folder)
    assert not is_private(tmp_path / "missing")
    if os.getuid() == 0:
        os.chown(folder, 1234, -1)
        assert not is_private(folder)


def test_the_cache_folder_is_never_one_that_others_can_write(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shared = tmp_path / "shared"
    (shared / folder_name()).mkdir(parents=True)
    (shared / folder_name()).chmod(0o777)
    monkeypatch.setenv("DAMPERLAB_CACHE_DIR", str(shared))
    folder = cache_folder()
    assert not folder.is_relative_to(shared)
    assert folder.stat().st_mode & 0o777 == 0o700
