"""Functions that Dask tasks call at a worker. They compute and store a block, or compute points without storing."""

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
from damperlab.studies.store.cube.block_file import write_region
from damperlab.studies.store.cube.definition import DefinitionDamaged, parse_stored
from damperlab.studies.store.cube.description import description_of, stored_variables
from damperlab.studies.store.cube.known_points import Source, known_points
from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.files.folder import open_shelf
from damperlab.studies.store.files.shelf import Shelf
from damperlab.studies.store.record import BlockOutcome
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
    """Compute one block of a study and write its results to the cube. A Dask task calls this function.

    The worker reads the study's definition from the cube, because the axes of a study may have a million values.

    Parameters
    ----------
    cube_path : str
        Address of the cube.
    digest : str
        Digest of the study, which is compared with the digest in the cube.
    block : Block
        The block.
    code : str
        Result of `code_hash()` at the coordinator, checked for every block, because workers can join during a run.
    generation : str
        Part of the name of the block's file, unique among all attempts of all runs.
    sources : tuple of Source
        Parts of earlier studies from which points of the block are taken.
    solver : str
        Identity of the study's solver; if empty, the solver of this worker is accepted.

    Returns
    -------
    BlockOutcome
        Report on the block. The field `kernel_seconds` is the CPU time of this thread for the computation, after the
        kernels were loaded.

    Raises
    ------
    WrongCode
        If this worker's sources differ from the coordinator's, or this worker's solver differs from the study's.
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
    """Read a ground-motion record from the copy in the cube, so that workers do not need the folder of records."""
    try:
        return source.read(_shelf(cube_path).get(source.key))
    except (FileNotFoundError, ValueError) as error:
        raise OSError(
            f"the cube's copy of record {source.id} is lost or damaged ({error}); `damperlab store verify --repair` restores it"
        ) from error


def solve_stored(cube_path: str, digest: str, block: Block | None) -> dict[str, np.ndarray] | None:
    """Read a study from its cube, and compute some points without storing the results.

    Returns
    -------
    dict of ndarray or None
        Stored variables at the points of `block`. If `block` is None, the study is only read, and the
        result is None.

    Raises
    ------
    OSError
        If the cube cannot be read.
    """
    study = _study(cube_path, digest)
    return None if block is None else _computed(cube_path, study, block, None)


def failed_values(study: AnyStudy, block: Block) -> dict[str, np.ndarray]:
    """Return the values to store for a block that could not be computed.

    Returns
    -------
    dict of ndarray
        Array of shape `block.shape` for each stored variable. The status is BLOCK_FAILED at all points, and all other
        variables have their fill values.
    """
    values = {
        variable.name: np.full(block.shape, variable.fill, dtype=variable.dtype)
        for variable in stored_variables(study)
    }
    values["status"][...] = Status.BLOCK_FAILED
    return values


def _shelf(cube_path: str) -> Shelf:
    """Open a cube.

    Raise `OSError` if the cube cannot be reached, or if this worker lacks the access keys or the library for the
    store.
    """
    try:
        return open_shelf(cube_path)
    except StoreFault as error:
        # the worker is the cause; OSError prevents the points from being recorded as failed
        raise OSError(str(error)) from error


@lru_cache(maxsize=4)
def _study(cube_path: str, digest: str) -> Study | Suite:
    described = description_of(_shelf(cube_path))
    if described.digest != digest:
        raise OSError(f"the cube {cube_path} holds study {described.digest}, not {digest}")
    try:
        # the check of the digest above ensures that this is the definition of the submitted study
        return parse_stored(json.loads(str(described.attributes["study"])), digest)
    except (DefinitionDamaged, ValueError) as error:
        # the points are not the cause; with OSError the study stops, and no point is recorded as failed
        raise OSError(
            f"the description of the cube {cube_path} is damaged ({error}); `damperlab store verify "
            "--repair` writes it again"
        ) from error
