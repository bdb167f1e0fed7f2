"""By whom a study is computed, how that is told apart, and what is kept of it: enough to do it again."""

import json
import re
import subprocess
import sys
from datetime import UTC, datetime, timedelta
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest
from tests.other_solver import ROOT

from damperlab.studies.definition import parse_study
from damperlab.studies.plan import plan_with_chunk
from damperlab.studies.store.solver import SOURCES, identity_of, is_outdated, solver
from damperlab.studies.store.store import Store
from damperlab.worker.provenance import (
    WrongCode,
    computing,
    one_identity,
    provenance,
    require_begun_alike,
    require_identity,
    require_solver,
)

STUDY = parse_study(
    {
        "name": "kept",
        "damping_ratio": 0.01,
        "axes": {
            "clearance_ratio": [2, 4],
            "restitution": 0.5,
            "mass_ratio": 0.1,
            "frequency_ratio": [0.9, 1.0],
        },
        "start": {"kind": "ensemble", "n": 4, "seed": 7},
    }
)


def test_record_and_cube_say_by_what_on_what_by_whom_and_when(store: Store) -> None:
    plan = plan_with_chunk(STUDY, STUDY.shape, lambda _, at: np.ones(len(at["mass_ratio"])))
    record, _ = store.submit(STUDY, plan, provenance())
    cube = store.cube(record.id)
    kept = record.document()["provenance"]
    assert json.loads(cube.attrs["provenance"]) == kept
    assert kept["solver_version"] == cube.attrs["solver_version"] == version("damperlab")
    assert re.fullmatch("[0-9a-f]{64}", kept["sources"])
    assert re.fullmatch("[0-9a-f]+", kept["kernels"])
    for package in (
        "numpy",
        "numba",
        "llvmlite",
        "dask",
        "distributed",
        "xarray",
        "zarr",
        "numcodecs",
        "sqlalchemy",
    ):
        assert kept[package] == version(package)
    for key in ("python", "machine", "processor", "libc", "host", "cores", "user"):
        assert kept[key] not in ("", "unknown"), key
    age = datetime.now(UTC) - datetime.fromisoformat(kept["time"])
    assert timedelta() <= age < timedelta(minutes=5)
    # the seed is part of what was asked, so of the study's identity too
    assert record.definition == json.loads(cube.attrs["study"])
    assert "7" in re.findall(r'"seed": (\d+)', json.dumps(record.definition))
    assert (cube.attrs["digest"], record.digest[:12]) == (STUDY.digest, record.id)


NEUTRAL = {
    # what is said, listed, told apart, read or asked, and where it lies; no stored value goes through it
    "studies": "base_motion decoded digest equal_steps examples faults field guard html kind kinds metrics paper "
    "pydantic_faults questions reads shapes spelled_numbers spelling unit_names user_error written_units",
    # the samples of a record are in the digest
    "studies.ground": "builtin files generated heading kanai_tajimi paper question random_vibration recipe shelf "
    "shock sweep",
    "studies.store": "faults kept_quota provenance record solver",
    "studies.store.cube": "coding decoded definition",
    "studies.store.files": "folder sealed shelf",
    # tuned mass dampers are compared with, not stored
    "studies.tmd": "absorber minimax stationary transfer tunings under_record",
    "worker": "cores fingerprint kernel_cache niceness provenance scenes warm",
}


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


def test_cube_begun_by_another_solver_is_not_continued() -> None:
    require_solver("a" * 12, provenance())
    for change in ({"solver": "0" * 16}, {"solver": ""}):
        with pytest.raises(WrongCode, match="damperlab recompute aaaaaaaaaaaa"):
            require_solver("a" * 12, {**provenance(), **change})
    require_begun_alike("a" * 12, provenance(), computing())
    with pytest.raises(WrongCode, match="damperlab recompute aaaaaaaaaaaa"):
        require_begun_alike("a" * 12, provenance(), {**computing(), "identity": "0" * 16})


def test_unlike_workers_compute_no_study_together() -> None:
    mine = computing()
    other = {**mine, "target": "generic 00000000"}
    other["identity"] = identity_of(other)
    assert other["identity"] != mine["identity"]
    assert one_identity({"tcp://a": mine, "tcp://b": dict(mine)}) == mine
    with pytest.raises(WrongCode, match=r"tcp://b has .* generic 00000000"):
        one_identity({"tcp://a": mine, "tcp://b": other})
    with pytest.raises(WrongCode, match=other["identity"]):
        require_identity(other["identity"])
