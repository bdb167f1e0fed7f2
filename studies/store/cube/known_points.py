"""Reuse of points that earlier studies computed. A worker reads these points without the catalogue."""

from dataclasses import dataclass

import numpy as np

from damperlab.studies.kind import AnyStudy
from damperlab.studies.plan import Block
from damperlab.studies.store.cube.description import stored_variables
from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.files.folder import open_shelf
from damperlab.studies.variables import Status


@dataclass(frozen=True)
class Source:
    """The points of a block that one earlier study has computed.

    Parameters
    ----------
    cube_path : str
        Location of the earlier study's cube.
    generations : dict
        Generation of each done block of the earlier study that contains such points, by the block's index.
    theirs, ours : tuple of ndarray of int
        Indices of the points along each dimension: in the earlier study's cube, and within the block.
    """

    cube_path: str
    generations: dict[int, str]
    theirs: tuple[np.ndarray, ...]
    ours: tuple[np.ndarray, ...]


def known_points(
    sources: tuple[Source, ...], study: AnyStudy, block: Block
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Read the points of a block that earlier studies have computed. A lost or damaged cube contributes no points.

    The sources are the earlier studies, from `damperlab.studies.store.reuse.Overlaps.of`.

    Returns
    -------
    known : ndarray of bool, block.shape
        Mask of the points that were read.
    values : dict of ndarray, each block.shape
        Every stored variable, valid where `known` is true.
    """
    from damperlab.studies.store.cube.opened import open_cube  # imported here, because it imports xarray

    known = np.zeros(block.shape, bool)
    variables = stored_variables(study)
    values = {v.name: np.full(block.shape, v.fill, v.dtype) for v in variables}
    for source in sources:
        try:
            cube = open_cube(open_shelf(source.cube_path), source.generations)
            part = cube.isel(dict(zip(study.coordinates, source.theirs, strict=True)))
            found = {v.name: part[v.name].values for v in variables}
        except (StoreFault, OSError):
            continue
        status = found["status"]
        # the points of a block that failed as a whole have no results
        good = (status != Status.NOT_COMPUTED) & (status != Status.BLOCK_FAILED)
        place = np.ix_(*source.ours)
        good &= ~known[place]
        for name, target in values.items():
            target[place] = np.where(good, found[name], target[place])
        known[place] |= good
    return known, values
