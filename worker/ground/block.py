"""Computes one block of a suite. Dampers and scales under the same record share the data of the record."""

from collections.abc import Callable

import numpy as np

from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.ground.source import RecordSource
from damperlab.studies.ground.suite import Suite
from damperlab.studies.ground.variables import SPREAD, STATISTICS, VARIABLES, measure_name, spread_name
from damperlab.studies.plan import Block
from damperlab.worker.ground.comparison import spread
from damperlab.worker.ground.design import Damper, Structure
from damperlab.worker.ground.response import Ready, ground_response, made_ready
from damperlab.worker.scenes import scenes
from damperlab.worker.warm import warm


def solve_suite_block(
    suite: Suite,
    block: Block,
    motion_of: Callable[[RecordSource], GroundMotion],
    known: np.ndarray | None = None,
) -> dict[str, np.ndarray]:
    """Compute the response of every point of a block.

    Parameters
    ----------
    suite : Suite
        The suite to which the block belongs.
    block : Block
        Part of the grid of the suite.
    motion_of : callable
        Function that returns the samples of a given record.
    known : ndarray of bool, shape block.shape, optional
        Mask of points with known results. The masked points are skipped, so they keep their fill values.

    Returns
    -------
    dict of ndarray, shape block.shape
        Every stored variable. At a failed point the values are NaN, and the status states the failure.
    """
    values = {name: np.full(block.shape, v.fill, v.dtype) for name, v in VARIABLES.items()}
    _, *axes = (
        axis[part].tolist() for axis, part in zip(suite.coordinates.values(), block.slices, strict=True)
    )
    sources = suite.records[block.slices[0]]
    shared: tuple[int, ...] = ()
    for scene in scenes(suite):
        warm(scene)
    for place in np.ndindex(block.shape):
        if known is not None and known[place]:
            continue
        source = sources[place[0]]
        point = [axis[at] for axis, at in zip(axes, place[1:], strict=True)]
        frequency, damping, scale, restitution, mass, clearance, force = point
        # record and structure vary most slowly, so most points reuse the data of the previous point
        if place[:3] != shared:
            shared = place[:3]
            structure = Structure(suite.numbers["mass_kg"], frequency, damping)
            motion = motion_of(source)
            ready = made_ready(structure, motion, 1.0, suite.numbers["tail_s"])
        damper = Damper(force, mass, clearance, restitution, suite.contact, suite.cavity)
        found = _point(suite, structure, damper, motion, scale, ready, draw_of(suite, source, point))
        for name, number in found.items():
            values[name][place] = number
    return {name: values[name] for name in suite.metrics}


def draw_of(suite: Suite, source: RecordSource, point: list[float]) -> list[int]:
    """Return the seed for the perturbed starts of a point. The seed of a point is the same in all blocks and studies.

    The seed combines the seed of the suite, the hash of the record and the coordinates of the point.
    """
    bits = np.asarray(point, dtype="<f8").view("<u8")
    return [suite.seed, int(source.sha256[:16], 16), *map(int, bits)]


def _point(
    suite: Suite,
    structure: Structure,
    damper: Damper,
    motion: GroundMotion,
    scale: float,
    ready: Ready,
    draw: list[int],
) -> dict[str, float]:
    tail = suite.numbers["tail_s"]
    response = ground_response(structure, damper, motion, scale, tail, None, ready)
    values: dict[str, float] = dict(response.values())
    if suite.starts:
        size = suite.numbers["perturbation_m"]
        over = spread(structure, damper, motion, response, scale, tail, suite.starts, size, draw, ready)
        values["growth"] = over["growth"]
        for measure in SPREAD:
            for statistic in STATISTICS:
                values[spread_name(measure, statistic)] = over[measure_name(measure)][statistic]
    return values
