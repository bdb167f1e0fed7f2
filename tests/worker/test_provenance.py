"""What is kept of how a study was computed: enough to do it again, and the same wherever it is read."""

import json
import re
from datetime import UTC, datetime, timedelta
from importlib.metadata import version
from pathlib import Path

import numpy as np

from damperlab.studies.definition import parse_study
from damperlab.studies.plan import plan_with_chunk
from damperlab.studies.store.store import Store
from damperlab.worker.provenance import provenance

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


def test_record_and_cube_say_by_what_on_what_by_whom_and_when(tmp_path: Path) -> None:
    store = Store.open(tmp_path)
    plan = plan_with_chunk(STUDY, STUDY.shape, lambda _, at: np.ones(len(at["mass_ratio"])))
    record, _ = store.submit(STUDY, plan, provenance())
    cube = store.cube(record.id)
    store.close()
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
