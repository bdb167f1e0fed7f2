"""Computes one block of a study."""

from time import thread_time

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.amplitudes import base_amplitudes
from damperlab.studies.choices import Continuation, Ensemble, Rk4Solver
from damperlab.studies.definition import Study
from damperlab.studies.plan import Block
from damperlab.studies.variables import DIMENSIONS, VARIABLES, Status
from damperlab.worker.kernel_arguments import (
    block_points,
    has_friction,
    has_particle,
    kernel_arguments,
    wants_acceleration,
    wants_energies,
)
from damperlab.worker.scenes import scenes
from damperlab.worker.solver.state import State
from damperlab.worker.steady.ensemble import drawn_starts, ensemble_values
from damperlab.worker.steady.fixed_steps import settle_stepped
from damperlab.worker.steady.response.closed_form import linear_response
from damperlab.worker.steady.response.measures import Response
from damperlab.worker.steady.settle import Settings, settle
from damperlab.worker.steady.start import at_rest, carried
from damperlab.worker.warm import warm

Points = dict[str, NDArray[np.float64]]
Values = dict[str, NDArray[np.generic]]


def solve_block(study: Study, block: Block, known: np.ndarray | None = None) -> dict[str, np.ndarray]:
    """Compute the steady response at every point of a block.

    Parameters
    ----------
    study : Study
        The study that contains the block.
    block : Block
        Part of the grid of the study. For a continuation, the part must have all frequencies.
    known : ndarray of bool, shape block.shape, optional
        Mask of points with known results. If such a point is skipped, it keeps its fill values.

    Returns
    -------
    dict of ndarray, shape block.shape
        Every stored variable (`study.metrics`). The values at a failed point are NaN, and the status states why.
    """
    points = block_points(study, block)
    count = points["frequency_ratio"].size
    values = {name: np.full(count, v.fill, dtype=v.dtype) for name, v in VARIABLES.items()}
    if isinstance(study.solver, Rk4Solver):
        for scene in scenes(study):
            warm(scene)
        _solve_stepped(study, study.solver, points, known, values)
        return {name: values[name].reshape(block.shape) for name in VARIABLES if name in study.metrics}
    linear = ~(has_friction(points) | has_particle(points, study.particle))
    if linear.any():
        began = thread_time()
        closed = linear_response(
            points["damping_ratio"][linear], points["frequency_ratio"][linear], study.forced
        )
        if isinstance(study.start, Ensemble):
            closed |= _one_response(closed["amplitude_ratio"])
        for name, column in closed.items():
            values[name][linear] = column
        values["run_time"][linear] = (thread_time() - began) / np.count_nonzero(linear)
    chosen = np.flatnonzero(~linear if known is None else ~(linear | known.reshape(-1)))
    if chosen.size:
        # compile the kernels before a point is timed
        for scene in scenes(study):
            warm(scene)
    if isinstance(study.start, Continuation):
        # known points are computed too, because the next frequency starts from their final state
        _solve_rows(study, points, np.flatnonzero(~linear), values, block.shape[-1])
    elif isinstance(study.start, Ensemble):
        _solve_ensembles(study, study.start, points, chosen, values)
    else:
        _solve_from_rest(study, points, chosen, values)
    return {name: values[name].reshape(block.shape) for name in VARIABLES if name in study.metrics}


def _settings(study: Study) -> Settings:
    steady = study.steady
    return Settings(
        steady.max_cycles,
        steady.tolerance,
        steady.periodic_tolerance,
        wants_energies(study),
        wants_acceleration(study),
    )


def _solve_from_rest(study: Study, points: Points, chosen: NDArray[np.intp], values: Values) -> None:
    """Compute each point from rest."""
    settings = _settings(study)
    for i, zeta, r, friction, particle in kernel_arguments(study, points, chosen):
        began = thread_time()
        start = at_rest(r, friction, particle, study.forced)
        response, _ = settle(zeta, r, friction, particle, settings, start, study.forced)
        values["run_time"][i] = thread_time() - began
        for name, number in zip(Response._fields, response, strict=True):
            values[name][i] = number


def _solve_stepped(
    study: Study, solver: Rk4Solver, points: Points, known: NDArray[np.bool_] | None, values: Values
) -> None:
    """Compute each point from rest with fixed steps, even if a closed form exists."""
    settings = _settings(study)._replace(
        energies=None
    )  # the fixed-step method computes no energies, so one kernel serves every study
    every = np.arange(points["frequency_ratio"].size)
    chosen = every if known is None else every[~known.reshape(-1)]
    for i, zeta, r, friction, particle in kernel_arguments(study, points, chosen):
        began = thread_time()
        response = settle_stepped(zeta, r, friction, particle, solver.steps_per_cycle, settings)
        values["run_time"][i] = thread_time() - began
        for name, number in zip(Response._fields, response, strict=True):
            values[name][i] = number


def _solve_rows(
    study: Study, points: Points, chosen: NDArray[np.intp], values: Values, frequencies: int
) -> None:
    """Compute each point from the final state at the previous frequency; the first point of a row starts from rest.

    After a failure, the next point also starts from rest.
    """
    settings = _settings(study)
    if isinstance(study.start, Continuation) and study.start.direction == "down":
        chosen = chosen[np.lexsort((-chosen, chosen // frequencies))]
    last: tuple[int, float, State] | None = None  # row, frequency and end of the previous point
    for i, zeta, r, friction, particle in kernel_arguments(study, points, chosen):
        began = thread_time()
        row = i // frequencies
        start = at_rest(r, friction, particle, study.forced)
        if last is not None and last[0] == row:
            start = carried(last[2], last[1], r, _shrinks(study, last[1], r), study.forced)
        response, end = settle(zeta, r, friction, particle, settings, start, study.forced)
        values["run_time"][i] = thread_time() - began
        for name, number in zip(Response._fields, response, strict=True):
            values[name][i] = number
        last = (row, r, end) if response.status <= Status.MAX_CYCLES else None


def _shrinks(study: Study, r_before: float, r: float) -> float:
    """Return the ratio of the base displacements at two frequencies; 1 for a constant displacement."""
    constant = study.physical.constant if study.physical is not None else None
    if constant is None or study.forced:
        return 1.0
    return float(base_amplitudes(1.0, r_before, constant) / base_amplitudes(1.0, r, constant))


def _solve_ensembles(
    study: Study, ensemble: Ensemble, points: Points, chosen: NDArray[np.intp], values: Values
) -> None:
    """Compute each point from rest and from random states."""
    settings = _settings(study)
    for i, zeta, r, friction, particle in kernel_arguments(study, points, chosen):
        began = thread_time()
        place = [float(points[name][i]) for name in DIMENSIONS]
        starts = drawn_starts(ensemble.n, ensemble.seed, place, zeta, r, friction, particle, study.forced)
        responses = [
            settle(zeta, r, friction, particle, settings, start, study.forced)[0] for start in starts
        ]
        for name, number in ensemble_values(responses).items():
            values[name][i] = number
        values["run_time"][i] = thread_time() - began


def _one_response(amplitude: NDArray[np.float64]) -> dict[str, np.ndarray]:
    """Return the variables of an ensemble whose starts all lead to the same response."""
    bounded = np.isfinite(amplitude)
    return {
        "amplitude_ratio_mean": amplitude,
        "amplitude_ratio_spread": np.where(bounded, 0.0, np.nan),
        "amplitude_ratio_worst": amplitude,
        "attractors": bounded.astype(np.int32),
        "attractor_share": bounded.astype(float),
        "attractor_share_second": np.zeros(amplitude.size),
        "attractor_share_third": np.zeros(amplitude.size),
    }
