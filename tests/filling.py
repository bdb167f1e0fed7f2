"""Studies of sixty points in twelve blocks, entered into a store and filled with values that name their block."""

import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from damperlab.studies.definition import Study, parse_study
from damperlab.studies.plan import Block, Plan, plan_with_chunk
from damperlab.studies.store.catalogue.catalogue import SQLITE_FILE
from damperlab.studies.store.cube.block_file import write_region
from damperlab.studies.store.cube.description import stored_variables
from damperlab.studies.store.record import BlockOutcome, Record
from damperlab.studies.store.store import Store

CHUNK = (1, 1, 1, 2, 2, 3)


def make_study(name: str = "sample", **changes: Any) -> Study:
    axes = {
        "clearance_ratio": [1.0, 2.0, 3.0, 5.0, 8.0],
        "friction_ratio": [0.0, 0.2, 0.4],
        "restitution": 0.47,
        "mass_ratio": [0.1],
        "frequency_ratio": [0.8, 0.9, 1.0, 1.1],
    }
    return parse_study({"name": name, "damping_ratio": 0.0038, "axes": axes, **changes})


def make_plan_of(study: Study, chunk: tuple[int, ...] = CHUNK) -> Plan:
    return plan_with_chunk(study, chunk, lambda _, coordinates: np.full(len(coordinates["mass_ratio"]), 1e-3))


def enter(store: Store, study: Study, chunk: tuple[int, ...] = CHUNK, **provenance: str) -> Record:
    """Submit a study."""
    return store.submit(study, make_plan_of(study, chunk), provenance)[0]


def entered(store: Store, chunk: tuple[int, ...] = CHUNK, **changes: Any) -> tuple[Study, Plan, str]:
    """Submit a study that is changed so; the study, its plan and its id."""
    study = make_study(**changes)
    return study, make_plan_of(study, chunk), enter(store, study, chunk).id


def values_of(study: Study, block: Block) -> dict[str, np.ndarray]:
    """Values that name their block: every variable of a block holds the block's index; converged throughout."""
    values = {v.name: np.full(block.shape, block.index, v.dtype) for v in stored_variables(study)}
    return values | {"status": np.zeros(block.shape, np.int8)}


def outcome_of(block: Block, failed: int = 0, message: str | None = None) -> BlockOutcome:
    return BlockOutcome(block.index, block.points, failed, 0.5, 0.4, message)


def write(
    store: Store,
    study_id: str,
    block: Block,
    values: dict[str, np.ndarray],
    generation: str = "",
    told: dict[str, Any] | None = None,
) -> None:
    """Write one attempt at a block, and mark it as done."""
    store.mark(study_id, write_region(store.cube_path(study_id), block, values, generation, told))


def put(store: Store, study: Study, *indices: int, generation: str = "") -> None:
    """Write blocks of a study and mark them as done."""
    record = store.find(study.digest[:12])
    for block in map(make_plan_of(study, record.chunk).block, indices):
        write(store, record.id, block, values_of(study, block), generation)


def write_behind(data_dir: Path, *statements: str) -> None:
    """Change a catalogue in SQLite behind the backs of all who have it open."""
    with closing(sqlite3.connect(data_dir / SQLITE_FILE)) as catalogue, catalogue:
        for statement in statements:
            catalogue.execute(statement)


def flip(file: Path, at: int | None = None, bits: int = 1) -> None:
    """Damage one byte of a file, by default that in its middle."""
    content = bytearray(file.read_bytes())
    content[len(content) // 2 if at is None else at] ^= bits
    file.write_bytes(content)


def lose_catalogue(data_dir: Path) -> None:
    for file in data_dir.glob("catalogue.sqlite*"):
        file.unlink()


def fill(store: Store, study: Study, generation: str = "g", **provenance: str) -> Record:
    """Submit a study and do all of it."""
    record = enter(store, study, **provenance)
    put(store, study, *range(record.blocks_total), generation=generation)
    return store.set_state(record.id, "done")
