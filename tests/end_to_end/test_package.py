"""The wheel beside what it asks for and nothing else: one import name, a light client, the main job."""

import json
import os
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from importlib.metadata import Distribution, PackageNotFoundError, PathDistribution, distribution
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

import damperlab

if TYPE_CHECKING:
    from damperlab.worker.point import Design

ROOT = Path(__file__).parents[2]
VERSION = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
PUBLIC = {"Client", "Study", "__version__", "open_store", "read_study"}
STUDY = {
    "name": "decay",
    "particle": False,
    "axes": {"friction_ratio": 0, "frequency_ratio": [0.5, 1.0, 2.0]},
}
FOREIGN = 'raise RuntimeError("the foreign package was imported")\n'


@pytest.fixture(scope="module")
def archives(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Build the source archive and the wheel from the tree, as `make dist` does."""
    folder = tmp_path_factory.mktemp("dist")
    tree = folder / "tree"
    tree.mkdir()
    for name in ("pyproject.toml", "README.md", "LICENSE", "src", "service", "worker", "studies"):
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        options = {"symlinks": True} if (ROOT / name).is_dir() else {}
        copy(ROOT / name, tree / name, **options)
    source, wheel = _backend(tree, folder, "build_sdist", "build_wheel")
    return wheel, source


def _backend(tree: Path, folder: Path, *hooks: str) -> list[Path]:
    script = f"from setuptools import build_meta as b; print('', *(getattr(b, each)({str(folder)!r}) for each in {hooks}))"
    ended = subprocess.run([sys.executable, "-c", script], cwd=tree, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stderr
    return [folder / name for name in ended.stdout.splitlines()[-1].split()]


@pytest.fixture(scope="module")
def client_packages(archives: tuple[Path, Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What `pip install damperlab` makes of an empty folder of packages."""
    return _installed(archives[0], tmp_path_factory.mktemp("client"), "")


def _installed(wheel: Path, packages: Path, extra: str) -> Path:
    """Unpack the wheel, and link what its metadata ask for with an extra; no network."""
    zipfile.ZipFile(wheel).extractall(packages)
    ours = PathDistribution(next(packages.glob("damperlab-*.dist-info")))
    for needed in _closure(ours, extra):
        for top in {
            file.parts[0] for file in needed.files or () if file.parts[0] not in ("..", "__pycache__")
        }:
            link, target = packages / top, Path(str(needed.locate_file(top)))
            if not link.exists():
                link.symlink_to(target)
    return packages


def _closure(root: Distribution, extra: str) -> list[Distribution]:
    """Give every distribution that one with an extra asks for on this machine, directly or not."""
    found: dict[str, Distribution] = {}
    waiting = [(root, {extra})]
    while waiting:
        current, extras = waiting.pop()
        for line in current.requires or ():
            asked = Requirement(line)
            if asked.marker and not any(asked.marker.evaluate({"extra": each}) for each in extras | {""}):
                continue
            try:
                needed = distribution(asked.name)
            except PackageNotFoundError:
                pytest.fail(f"{current.name} asks for {line}, which is not installed here")
            assert asked.specifier.contains(needed.version, prereleases=True), line
            key = canonicalize_name(asked.name)
            if key not in found or asked.extras:
                found[key] = needed
                waiting.append((needed, set(asked.extras)))
    return list(found.values())


def _run(packages: Path, *arguments: str, cwd: Path, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run Python with a folder of packages and the standard library, but no site-packages."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    return subprocess.run(
        [sys.executable, "-S", *arguments],
        cwd=cwd,
        env=kept | {"PYTHONPATH": str(packages)} | variables,
        capture_output=True,
        text=True,
    )


def test_the_wheel_holds_one_name_and_its_files_and_the_source_archive_all_that_it_is_made_of(
    archives: tuple[Path, Path],
) -> None:
    wheel, source = archives
    names = set(zipfile.ZipFile(wheel).namelist())
    described = {name for name in names if ".dist-info/" in name}
    assert {name.split("/")[0] for name in names - described} == {"damperlab"}
    assert {
        "damperlab/py.typed",
        "damperlab/service/page/index.html",
        "damperlab/studies/paper.yaml",
    } <= names
    assert not [name for name in names if "/tests/" in name or "__pycache__" in name]
    parts = (ROOT / part for part in ("service", "worker", "studies"))
    tree = {path.relative_to(ROOT).as_posix() for part in parts for path in part.rglob("*.py")}
    assert {f"damperlab/{name}" for name in tree} <= names
    with tarfile.open(source) as archive:
        members = archive.getmembers()
    assert not [member.name for member in members if member.issym()]
    held = {member.name.partition("/")[2] for member in members}
    assert {f"src/{name}" for name in names - described} | {"pyproject.toml", "README.md", "LICENSE"} <= held


def test_the_version_comes_from_one_place_and_every_public_name_is_there() -> None:
    assert set(damperlab.__all__) == {name for name in PUBLIC if getattr(damperlab, name) is not None}
    assert f"version: {VERSION}" in (ROOT / "CITATION.cff").read_text()
    assert f"## {VERSION}" in (ROOT / "CHANGELOG.md").read_text()


def test_import_is_light_and_the_client_needs_neither_compiler_nor_cluster_nor_web(
    client_packages: Path, tmp_path: Path
) -> None:
    script = """
import sys
before = set(sys.modules)
import damperlab
print(damperlab.__version__)
assert {name.partition(".")[0] for name in set(sys.modules) - before} <= {"damperlab", *sys.stdlib_module_names}
from importlib.util import find_spec
for absent in ("numba", "dask", "distributed", "fastapi", "sqlalchemy", "typer", "uvicorn", "pyarrow"):
    assert find_spec(absent) is None, absent
from damperlab import Client, Study, read_study
from damperlab.service.client import Unreachable
assert not {"xarray", "zarr", "matplotlib", "damperlab.worker"} & set(sys.modules)
from damperlab.service.client.answers import ResonanceMap
import damperlab.service.client.earthquake
import xarray, aiohttp, fsspec, zarr
assert read_study("figure-11").points == Study(**read_study("figure-11").document()).points
try:
    Client("http://127.0.0.1:9", timeout=1).submit("figure-11")
except Unreachable as error:
    print(error)
try:
    Study(axes={"clearance_ratio": [-1]})
except ValueError as error:
    print(type(error).__name__, error)
try:
    damperlab.open_store()
except ImportError as error:
    print(error)
"""
    ended = _run(client_packages, "-c", script, cwd=tmp_path)
    assert ended.returncode == 0, ended.stderr
    version, *refused = ended.stdout.splitlines()
    assert version == VERSION
    assert "http://127.0.0.1:9" in refused[0]
    assert "StudyFaults `axes.clearance_ratio[0]` must be a number" in ended.stdout
    assert "pip install 'damperlab[service]'" in refused[-1]


def test_a_command_without_the_service_says_what_to_install(client_packages: Path, tmp_path: Path) -> None:
    ended = _run(client_packages, "-m", "damperlab", "studies", cwd=tmp_path)
    assert ended.returncode == 1
    assert "pip install 'damperlab[service]'" in ended.stderr
    assert "Traceback" not in ended.stderr
    told = _run(client_packages, "-m", "damperlab", "--version", cwd=tmp_path)
    assert told.stdout == f"damperlab {VERSION}\n", told.stderr


@pytest.mark.night
def test_the_main_job_runs_beside_foreign_packages_of_our_folders_names(
    archives: tuple[Path, Path], tmp_path: Path
) -> None:
    (tmp_path / "study.json").write_text(json.dumps(STUDY))
    packages = _installed(archives[0], tmp_path / "packages", "service")
    for name in ("worker", "service", "studies"):
        (packages / name).mkdir()
        (packages / name / "__init__.py").write_text(FOREIGN)
    command = ("-m", "damperlab", "run", "study.json", "--data-dir", "data", "--json")
    ended = _run(packages, *command, cwd=tmp_path)
    assert ended.returncode == 0, ended.stderr
    record = json.loads(ended.stdout)
    assert (record["state"], record["points_done"], record["points_failed"]) == ("done", 3, 0)
    script = """
from damperlab import open_store
store = open_store("data")
cube = store.cube(store.find("decay").id)
print(cube.amplitude_ratio.sel(frequency_ratio=2.0).item())
"""
    asked = _run(packages, "-c", script, cwd=tmp_path)
    # |X/Z| of the linear structure under base excitation
    r, damping = 2.0, 0.0038
    exact = abs((1 + 2j * damping * r) / (1 - r**2 + 2j * damping * r))
    assert float(asked.stdout) == pytest.approx(exact, rel=1e-12), asked.stderr


def _hybrid() -> "Design":
    from damperlab.worker.point import Design
    from damperlab.worker.solver.particle import Particle

    return Design(0.0038, 1.0, 0.3, Particle(5.0, 0.47, 0.1))


@pytest.fixture
def swift(tmp_path: Path, archives: tuple[Path, Path]) -> Path:
    """A wheel that the source archive makes beside kernels, as `make dist` puts them there.

    What is put there is what this machine has compiled for the same sources; `make kernels` compiles it anew.
    """
    from damperlab.worker.jit import CACHE_FOLDER, shipped_folder
    from damperlab.worker.simulate import scenes_of
    from damperlab.worker.warm import warm

    for scene in scenes_of(_hybrid()):
        warm(scene)
    subprocess.run(["tar", "-xzf", archives[1], "-C", tmp_path], check=True)
    tree = tmp_path / archives[1].name.removesuffix(".tar.gz")
    place = tree / "src" / "damperlab" / "worker" / shipped_folder().relative_to(shipped_folder().parents[1])
    place.mkdir(parents=True, exist_ok=True)
    found = shipped_folder() if shipped_folder().exists() else CACHE_FOLDER
    for file in (*found.glob("*.nbc"), *found.glob("*.ready")):
        shutil.copyfile(file, place / file.name)
    return _backend(tree, tmp_path, "build_wheel")[0]


@pytest.mark.night
def test_a_wheel_with_kernels_answers_without_compiling(swift: Path, tmp_path: Path) -> None:
    from damperlab.worker.simulate import simulate

    empty = tmp_path / "cache"
    options = ("--clearance-ratio", "5", "--friction-ratio", "0.3", "--json")
    script = (
        "from numba.core.event import install_recorder; from damperlab.__main__ import main; import sys\n"
        "with install_recorder('numba:compile') as compiled:\n"
        "    try:\n        main()\n    except SystemExit:\n        pass\n"
        "print(len(compiled.buffer), file=sys.stderr)\n"
    )
    packages = _installed(swift, tmp_path / "packages", "service")
    ended = _run(packages, "-c", script, "simulate", *options, cwd=tmp_path, DAMPERLAB_CACHE_DIR=str(empty))
    assert ended.returncode == 0, ended.stderr
    assert ended.stderr.splitlines()[-1] == "0", ended.stderr
    assert [file for file in empty.rglob("*") if file.is_file()] == []
    here = simulate(_hybrid())
    assert json.loads(ended.stdout)["metrics"]["amplitude_ratio"] == here.metrics["amplitude_ratio"]
