"""Which stored kernel is loaded, and which is compiled anew."""

import enum
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FunctionType
from typing import Any, NamedTuple

import numba
import pytest
from tests.worker.test_jit import ROOT, jitted, run

from damperlab.worker import kernel_cache
from damperlab.worker.fingerprint import UNKNOWN, fingerprint, name_of, of_function
from damperlab.worker.jit import Kernel, kernel
from damperlab.worker.kernel_cache import CACHE_FOLDER, KernelCache, folder_name, identity
from damperlab.worker.physics.friction import hold_force


@kernel
def _plus_one(x: float) -> float:
    return x + 1.0


@pytest.fixture
def stored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[], Any]:
    """Store a kernel in a folder of its own; gives what loads it."""
    monkeypatch.setattr("damperlab.worker.kernel_cache.CACHE_FOLDER", tmp_path)
    tmp_path.chmod(0o700)
    assert isinstance(_plus_one, Kernel)
    signature = (numba.float64,)
    dispatcher = Kernel(_plus_one.py_func, {}).whole
    dispatcher.compile(signature)
    return lambda: KernelCache(_plus_one.py_func).load_overload(signature, dispatcher.targetctx)


@jitted
def test_a_kernel_is_not_loaded_from_a_folder_that_others_can_write(
    stored: Callable[[], Any], tmp_path: Path
) -> None:
    assert stored() is not None
    tmp_path.chmod(0o777)
    assert stored() is None


@jitted
@pytest.mark.parametrize("fault", ["zeros", "empty", "cut", "flipped", "no line", "other sources"])
def test_a_damaged_kernel_counts_as_none(stored: Callable[[], Any], tmp_path: Path, fault: str) -> None:
    (file,) = tmp_path.glob("*.nbc")
    whole = file.read_bytes()
    flipped = bytearray(whole)
    flipped[-100] ^= 4
    file.write_bytes(
        {
            "zeros": bytes(len(whole)),
            "empty": b"",
            "cut": whole[:-1],
            "flipped": bytes(flipped),
            "no line": b"[]\n" + whole,
            "other sources": whole.replace(identity()["sources"].encode(), b"0" * 16),
        }[fault]
    )
    assert stored() is None
    file.write_bytes(whole)
    assert stored() is not None


@pytest.fixture
def forgetful() -> Iterator[None]:
    """Let the identity be asked for anew, now and afterwards."""
    for function in (identity, folder_name):
        function.cache_clear()
    yield
    for function in (identity, folder_name):
        function.cache_clear()


@pytest.mark.parametrize(
    "setting", ["BOUNDSCHECK", "OPT", "LOOP_VECTORIZE", "SLP_VECTORIZE", "ENABLE_AVX", "DEBUGINFO_DEFAULT"]
)
@pytest.mark.usefixtures("forgetful")
def test_what_changes_machine_code_changes_the_folder(monkeypatch: pytest.MonkeyPatch, setting: str) -> None:
    before = CACHE_FOLDER.name
    monkeypatch.setattr(numba.config, setting, 7)
    assert folder_name() != before


@jitted
def test_a_kernel_is_taken_over_while_its_own_functions_stay_as_they_are(tmp_path: Path) -> None:
    """An edit of a law that a kernel does not hold compiles nothing; one of a law that it holds does."""
    cache, copy = tmp_path / "cache", tmp_path / "sources"
    cache.mkdir(mode=0o700)
    for name in ("src", "studies", "worker"):
        ignored = shutil.ignore_patterns("__pycache__", "kernels", "page")
        shutil.copytree(ROOT / name, copy / name, symlinks=True, ignore=ignored)
    (copy / "service").symlink_to(ROOT / "service")
    ask = (
        "import sys; from damperlab.worker.physics.friction import hold_force as f\n"
        "from damperlab.worker.jit import source_hash\n"
        "print(float(f(0.3, 0.2, 1.0)).hex(), 'numba.np.arraymath' in sys.modules, source_hash())"
    )

    def asked() -> list[str]:
        return run(cache, "-c", ask, path=copy / "src").split()

    value, compiled, sources = asked()
    assert compiled == "True"
    wall, friction = (
        copy / "worker" / "physics" / "compliant_wall.py",
        copy / "worker" / "physics" / "friction.py",
    )
    wall.write_text(wall.read_text() + "\nMORE = 1.0\n")
    same, compiled, changed = asked()
    assert (same, compiled) == (value, "False")
    assert changed != sources
    friction.write_text(friction.read_text().replace("return", "return 2.0 *", 1))
    assert asked()[1] == "True"


class _Kind(enum.IntEnum):
    ONE = 1


class _Pair(NamedTuple):
    first: float
    second: float = 0.0


_SCALE = 2.0
_LIMITS = (1.0, 2.0)


@kernel
def _called(x: float) -> float:
    return x


def _law(x: float, more: float = 0.5) -> float:
    """Scale."""
    return _called(x) * _SCALE + more + _LIMITS[0] + _Kind.ONE + _Pair(1.0).second


def _with(**values: Any) -> str:
    """Fingerprint of the same law in a module with other values."""
    return of_function(FunctionType(_law.__code__, globals() | values, "law", _law.__defaults__))


def test_a_function_is_known_by_its_code_and_by_the_values_that_it_takes() -> None:
    known = of_function(_law)
    assert known == _with() == fingerprint(name_of(_law))
    others = [
        _with(_SCALE=3.0),
        _with(_LIMITS=(1.0, 2.5)),
        _with(_called=_plus_one),
        _with(_Kind=enum.IntEnum("_Kind", {"ONE": 2})),
        _with(_Pair=NamedTuple("_Pair", [("first", float), ("other", float)])),
        of_function(FunctionType(_law.__code__, globals(), "law", (0.25,))),
        of_function(FunctionType(_law.__code__.replace(co_consts=(None, 2.0)), globals())),
    ]
    assert len({known, *others}) == 1 + len(others)
    assert UNKNOWN not in others
    documented = _law.__code__.replace(co_consts=("Other words.", *_law.__code__.co_consts[1:]))
    assert of_function(FunctionType(documented, globals(), "law", _law.__defaults__)) == known
    assert _with(_SCALE=object()) == _with(_SCALE=kernel_cache) == UNKNOWN
    assert fingerprint("damperlab.worker.jit:absent") == UNKNOWN


@jitted
def test_another_numba_than_the_one_that_was_read_compiles_alone(tmp_path: Path) -> None:
    ask = (
        "import damperlab.worker.compiler.numba_read as read\n"
        "assert not read.differing(), 'pyproject.toml allows a numba that nobody has read'\n"
        "import importlib, sys, warnings\n"
        "read.READ['numba.core.lowering:Lower.lower_binop'] = read.READ['numba.core.lowering:Lower.absent'] = '0'\n"
        "source = open(read.__file__).read().replace('_DIFFERING = differing()', '_DIFFERING = [\"lower_binop\"]')\n"
        "assert len(read.differing()) == 2\n"
        "with warnings.catch_warnings(record=True) as told:\n"
        "    warnings.simplefilter('always'); exec(compile(source, read.__file__, 'exec'), read.__dict__)\n"
        "from damperlab.worker.physics.friction import hold_force\n"
        "from damperlab.worker.jit import CACHE_FOLDER, identity\n"
        "print(float(hold_force(0.3, 0.2, 1.0)).hex(), len(list(CACHE_FOLDER.glob('*.nbc'))))\n"
        "print(told[0].message, identity()['target'])"
    )
    alone = run(tmp_path, "-c", ask)
    assert alone.split()[:2] == [hold_force(0.3, 0.2, 1.0).hex(), "0"]
    assert "lower_binop" in alone
    assert alone.strip().endswith("alone")


def test_a_kernel_is_told_apart_by_the_order_of_the_fields_that_it_takes() -> None:
    def file(kind: type, *fields: numba.types.Type) -> str:
        named = numba.types.NamedTuple(fields, kind)
        return KernelCache(_law)._file((numba.types.Tuple((named, numba.float64)),))

    two = (numba.float64, numba.float64)
    other = NamedTuple("_Pair", [("second", float), ("first", float)])  # noqa: UP014 - of the same name
    other.__module__ = _Pair.__module__
    assert file(_Pair, *two) == file(_Pair, *two)
    assert file(_Pair, *two) != file(other, *two)
    assert file(_Pair, *two) != file(_Pair, numba.float64, numba.int64)


def test_what_a_class_or_a_status_means_is_a_source_of_kernels() -> None:
    """Their numbers are compiled into kernels."""
    outside = {
        line.split()[1]
        for name in kernel_cache._SOURCES
        for file in sorted((ROOT / name).rglob("*.py")) or [ROOT / name]
        for line in file.read_text().splitlines()
        if name.startswith("worker/") and line.startswith("from damperlab.studies")
    }
    sources = {f"damperlab.{name.removesuffix('.py').replace('/', '.')}" for name in kernel_cache._SOURCES}
    # what is taken from there is called before a march or after it, in Python
    assert outside - sources <= {"damperlab.studies.portable"}
