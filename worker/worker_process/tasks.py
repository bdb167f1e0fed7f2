"""The tasks that Dask runs at a worker: to compute and store a block, and to answer the coordinator."""

import json
import time
from dataclasses import replace
from functools import lru_cache

import numpy as np

from damperlab.studies.definition import Study
from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.ground.source import RecordSource
from damperlab.studies.ground.suite import Suite
from damperlab.studies.kind import AnyStudy
from damperlab.studies.plan import Block
from damperlab.studies.store.cube.cube import description_of, stored_variables, write_region
from damperlab.studies.store.cube.definition import DefinitionDamaged, parse_stored
from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.files.folder import open_shelf
from damperlab.studies.store.files.shelf import Shelf
from damperlab.studies.store.record import BlockOutcome
from damperlab.studies.store.reuse.known_points import Source, known_points
from damperlab.studies.variables import Status
from damperlab.worker.block import solve_block
from damperlab.worker.ground.block import solve_suite_block
from damperlab.worker.provenance import computing, require_code, require_identity
from damperlab.worker.scenes import scenes
from damperlab.worker.warm import warm


def run_block(
    cube_path: str,
    digest: str,
    block: Block,
    code: str,
    generation: str,
    sources: tuple[Source, ...] = (),
    solver: str = "",
) -> BlockOutcome:
    """Solve one block and write its region. A Dask task calls this function.

    The study's definition is not sent with the task: it may have axes of a million values, and the worker must reach
    the cube anyway.

    Parameters
    ----------
    cube_path : str
        Address of the cube.
    digest : str
        Digest of the study, so that the definition of another study is never taken from a cache.
    block : Block
        The block.
    code : str
        `code_hash()` of the coordinator. Checked with every block: workers join while a study runs.
    generation : str
        Identifies this attempt's file; no other attempt of any run has the same generation.
    sources : tuple of Source
        Known points of the block in earlier studies.
    solver : str
        The identity of the study's solver; empty for this worker's.

    Returns
    -------
    BlockOutcome
        `kernel_seconds` is CPU time of this thread inside `solve_block`, with kernels already loaded.

    Raises
    ------
    WrongCode
        If this worker's sources differ from the coordinator's, or its results would differ from the study's.
    OSError
        If the cube cannot be read or written.
    """
    require_code(code)
    require_identity(solver or computing()["identity"])
    began = time.perf_counter()
    study = _study(cube_path, digest)
    known, stored = known_points(sources, study, block) if sources else (None, {})
    if known is None or not known.all():
        for scene in scenes(study):
            warm(scene)
    began_kernel = time.thread_time()
    values = _computed(cube_path, study, block, known)
    kernel_seconds = time.thread_time() - began_kernel
    for name, column in stored.items():
        values[name][known] = column[known]
    told = {
        "reused": 0 if known is None else int(np.count_nonzero(known)),
        "seconds": time.perf_counter() - began,
        "kernel_seconds": kernel_seconds,
        "identity": computing()["identity"],
    }
    outcome = write_region(cube_path, block, values, generation, told)
    return replace(outcome, seconds=time.perf_counter() - began)


def _computed(
    cube_path: str, study: Study | Suite, block: Block, known: np.ndarray | None
) -> dict[str, np.ndarray]:
    if isinstance(study, Suite):
        return solve_suite_block(study, block, lambda source: _motion(cube_path, source), known)
    return solve_block(study, block, known)


@lru_cache(maxsize=8)
def _motion(cube_path: str, source: RecordSource) -> GroundMotion:
    """Read a record from the study's own copy: no worker needs the folder of the records."""
    try:
        return source.read(_shelf(cube_path).get(source.key))
    except (FileNotFoundError, ValueError) as error:
        raise OSError(
            f"the cube's copy of record {source.id} is lost or damaged ({error}); `damperlab store verify --repair` restores it"
        ) from error


def solve_stored(cube_path: str, digest: str, block: Block | None) -> dict[str, np.ndarray] | None:
    """Compute some points of a study from its cube, and store nothing.

    Parameters
    ----------
    cube_path, digest : str
        As for `run_block`.
    block : Block, optional
        The points; without them the study is only read.

    Raises
    ------
    OSError
        If the cube cannot be read.
    """
    study = _study(cube_path, digest)
    return None if block is None else _computed(cube_path, study, block, None)


def failed_values(study: AnyStudy, block: Block) -> dict[str, np.ndarray]:
    """Give the values of a block that could not be computed.

    Parameters
    ----------
    study, block : AnyStudy, Block
        The block.

    Returns
    -------
    dict of ndarray
        Every stored variable, shaped `block.shape`: the status is BLOCK_FAILED, all other values are empty.
    """
    values = {
        variable.name: np.full(block.shape, variable.fill, dtype=variable.dtype)
        for variable in stored_variables(study)
    }
    values["status"][...] = Status.BLOCK_FAILED
    return values


def _shelf(cube_path: str) -> Shelf:
    """Open a cube; raise `OSError` also if this worker lacks the keys or the library for it."""
    try:
        return open_shelf(cube_path)
    except StoreFault as error:
        # this is the worker's fault, not that of its points
        raise OSError(str(error)) from error


@lru_cache(maxsize=4)
def _study(cube_path: str, digest: str) -> Study | Suite:
    described = description_of(_shelf(cube_path))
    if described.digest != digest:
        raise OSError(f"the cube {cube_path} holds study {described.digest}, not {digest}")
    try:
        # this is the submitted definition, since its digest is compared
        return parse_stored(json.loads(str(described.attributes["study"])), digest)
    except (DefinitionDamaged, ValueError) as error:
        # the points are not at fault, so the study stops and none of them is recorded as failed
        raise OSError(
            f"the description of the cube {cube_path} is damaged ({error}); `damperlab store verify "
            "--repair` writes it again"
        ) from error
