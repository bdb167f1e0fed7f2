"""One block of a study, solved."""

from functools import lru_cache
from time import perf_counter

import numpy as np

from studies.definition import Study
from studies.plan import Block
from studies.variables import VARIABLES
from worker.lower import block_points, has_friction, has_particle, kernel_arguments
from worker.steady.linear import linear_response
from worker.steady.response import Response
from worker.steady.settle import Settings, settle
from worker.warm import scenes, warm


def solve_block(study: Study, block: Block, known: np.ndarray | None = None) -> dict[str, np.ndarray]:
    """Steady response of every point of a block.

    Parameters
    ----------
    study : Study
        The study.
    block : Block
        Which part of its grid.
    known : ndarray of bool, shape block.shape, optional
        Points that the caller has already: they need no computing, and may be left empty.

    Returns
    -------
    dict of ndarray, shape block.shape
        Every stored variable (`study.metrics`). A point that failed has NaN and its status; nothing is raised for it.
    """
    points = block_points(study, block)
    count = points["frequency_ratio"].size
    values = {name: np.full(count, v.fill, dtype=v.dtype) for name, v in VARIABLES.items()}
    linear = ~(has_friction(points) | has_particle(points, study.particle))
    if linear.any():
        began = perf_counter()
        closed = linear_response(points["damping_ratio"][linear], points["frequency_ratio"][linear])
        for name, column in closed.items():
            values[name][linear] = column
        values["run_time"][linear] = (perf_counter() - began) / np.count_nonzero(linear)
    settings = Settings(study.steady.max_cycles, study.steady.tolerance, study.steady.periodic_tolerance)
    chosen = np.flatnonzero(~linear if known is None else ~(linear | known.reshape(-1)))
    if chosen.size:
        _prepare(study)
    arguments = kernel_arguments(points, study.particle, chosen, study.contact)
    for i, damping, frequency, friction, particle in arguments:
        began = perf_counter()
        response = settle(damping, frequency, friction, particle, settings)
        values["run_time"][i] = perf_counter() - began
        for name, number in zip(Response._fields, response, strict=True):
            values[name][i] = number
    return {name: values[name].reshape(block.shape) for name in VARIABLES if name in study.metrics}


@lru_cache(maxsize=8)
def _prepare(study: Study) -> None:
    """Have the study's kernels ready before a point is timed."""
    for scene in scenes(study):
        warm(scene)
