"""Who computes: one solver a cube, and results of another one known as such."""

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.other_solver import ROOT, SCALE, OtherSolver
from tests.worker.run_here import run_here

from damperlab.studies.definition import Study, parse_study
from damperlab.studies.plan import plan_with_chunk
from damperlab.studies.store.catalogue.tables import done_blocks
from damperlab.studies.store.record import BlockOutcome, Record
from damperlab.studies.store.solver import SOURCES, is_outdated, solver
from damperlab.studies.store.store import Store
from damperlab.worker.dispatch.cost_model import seconds_per_point
from damperlab.worker.provenance import computing, provenance

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


def study_of(frequencies: int = 12, **changes: Any) -> Study:
    document = {
        "damping_ratio": 0.05,
        "axes": {"friction_ratio": 0, "frequency_ratio": {"start": 0.5, "stop": 1.6, "num": frequencies}},
        "particle": False,
    }
    return parse_study({**document, **changes})


@pytest.fixture(scope="module")
def other(tmp_path_factory: pytest.TempPathFactory) -> OtherSolver:
    return OtherSolver(tmp_path_factory.mktemp("other"))


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    store = Store.open(tmp_path / "data")
    yield store
    store.close()


def submit(store: Store, study: Study, chunk: int = 4) -> Record:
    plan = plan_with_chunk(study, (1, 1, 1, 1, 1, chunk), seconds_per_point)
    return store.submit(study, plan, provenance())[0]


def identities(store: Store, record: Record) -> set[str]:
    with store.catalogue.reading() as connection:
        number = store.number(connection, record.id)
        query = done_blocks.select().where(done_blocks.c.study == number)
        return {row.identity for row in connection.execute(query)}


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


def test_a_study_that_waited_while_the_solver_changed_is_the_new_ones_alone(
    store: Store, other: OtherSolver
) -> None:
    record = submit(store, study_of())
    began = other.run("resume", record.id, "--data-dir", str(store.data_dir))
    assert (began["state"], began["outdated"]) == ("done", False)
    # the solver is its sources and not its place: nothing else differs
    assert began["provenance"]["solver"] != solver()
    for name in ("target", "libc", "numpy", "numba", "llvmlite", "kernels"):
        assert began["provenance"][name] == computing()[name]
    assert is_outdated({}), "it was not written down"
    assert not is_outdated({"solver": solver()})
    kept = store.find(record.id)
    assert kept.document()["outdated"]
    assert kept.provenance["identity"] == began["provenance"]["identity"] != computing()["identity"]
    assert json.loads(store.cube(record.id).attrs["provenance"])["identity"] == kept.provenance["identity"]
    assert identities(store, kept) == {kept.provenance["identity"]}
    # and its points go into no study of today's solver
    finer = run_here(store, submit(store, study_of(23)).id)
    assert (finer.state, finer.points_reused, finer.outdated) == ("done", 0, False)
    assert identities(store, finer) == {computing()["identity"]}
    ours = store.cube(finer.id)["amplitude_ratio"].values[..., ::2]
    np.testing.assert_array_equal(store.cube(kept.id)["amplitude_ratio"].values, ours * SCALE)


def test_no_solver_finishes_what_another_began(store: Store, other: OtherSolver) -> None:
    record = submit(store, study_of())
    done = run_here(store, record.id)
    taken = store.forget(record.id, [1], "to be computed again")
    assert taken.blocks_done == done.blocks_total - 1
    refused = other.run("resume", record.id, "--data-dir", str(store.data_dir), allowed=(1,))
    assert f"damperlab recompute {record.id}" in json.dumps(refused)
    assert store.find(record.id).blocks_done == done.blocks_total - 1
    again = run_here(store, record.id)
    assert again.state == "done"
    assert identities(store, again) == {computing()["identity"]}


def test_the_catalogue_takes_no_block_of_another_solver(store: Store) -> None:
    record = submit(store, study_of())
    with pytest.raises(ValueError, match="0000000000000000"):
        store.mark(record.id, BlockOutcome(0, 4, 0, 0.1, 0.1, generation="g", identity="0" * 16))
    assert store.find(record.id).blocks_done == 0
