"""What a solver is: every source between a study and its values."""

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.other_solver import ROOT

from damperlab.studies.store.solver import SOURCES, is_outdated, solver
from damperlab.studies.store.store import Store

NEUTRAL = {
    # what is said, listed, told apart, read or asked, and where it lies; no stored value goes through it
    "studies": "base_motion digest examples faults field guard html kind kinds metrics paper pydantic_faults questions reads "
    "spelled_numbers unit_names user_error",
    # the samples of a record are in the digest
    "studies.ground": "builtin files generated kanai_tajimi paper question response_spectrum shelf sweep sweep_reading",
    "studies.store": "faults kept_quota record solver submitter",
    "studies.store.cube": "checksum coding cube chunks decoded definition",
    "studies.store.files": "durable sealed shelf",
    "studies.store.reuse": "reuse",
    "studies.tmd": "absorber minimax stationary transfer tunings",  # tuned mass dampers are compared with, not stored
    "worker": "cores kernel_cache niceness provenance scenes warm",
}


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    store = Store.open(tmp_path / "data")
    yield store
    store.close()


def test_every_source_between_a_study_and_its_values_is_counted() -> None:
    code = (
        "import sys, json, damperlab.worker.block, damperlab.worker.ground.block\n"
        "print(json.dumps({n: m.__file__ for n, m in sys.modules.items() if n.startswith('damperlab.')}))"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True, cwd=ROOT)
    neutral = {f"damperlab.{parent}.{name}" for parent, names in NEUTRAL.items() for name in names.split()}
    for name, file in json.loads(done.stdout).items():
        path = Path(file).as_posix()
        counted = any(f"/{source}" in path for source in SOURCES)
        assert counted or name in neutral or path.endswith("__init__.py"), name
    assert all((ROOT / source).exists() for source in SOURCES)
    assert is_outdated({}), "what was not written down"
    assert not is_outdated({"solver": solver()})
