"""Computes the displacement of a prototype at the samples of a time history."""

from collections.abc import Mapping
from math import pi

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.cavity import cavity_of
from damperlab.studies.fit.history.question import RELEASE, HistoryQuestion
from damperlab.studies.variables import MADE_BY
from damperlab.worker.ground.design import Damper, Scale, Structure, friction_of, particle_of
from damperlab.worker.ground.response import Perturbation, Ready, run_on_record
from damperlab.worker.scenes import Scene, contact_name
from damperlab.worker.solver.events import ARRIVED
from damperlab.worker.solver.excitation.record_base import RecordBase, make_record_base
from damperlab.worker.solver.linear_motion import make_linear_motion
from damperlab.worker.solver.segment_log import Logged, empty_log, stored_rows

Column = NDArray[np.float64]

EVENTS_PER_PERIOD = 200
"""Largest number of events per period of the structure. Parameters that cause more events are rejected."""
LEAST = 1e-9
"""Smallest value of a parameter whose range begins at 0, so that one kernel serves the whole range."""
NOMINAL_KG = 1.0
"""Mass of the structure [kg] if the question gives no mass. Displacements then do not depend on the mass."""


def displacement(question: HistoryQuestion, values: Mapping[str, float], rows: int | None = None) -> Column:
    """Compute the displacement at the first samples of a time history.

    Parameters
    ----------
    question : HistoryQuestion
        Question with the known values and the measured samples.
    values : mapping of float
        Values of the estimated parameters.
    rows : int, optional
        Number of samples; by default all samples.

    Returns
    -------
    ndarray, shape (rows,)
        Displacement [m], relative to the base if the measured displacement is relative. NaN if the integration failed.
    """
    measured = question.measured
    given = question.given(values)
    structure, damper = built(question, given)
    rows = question.measured.rows if rows is None else rows
    base, scale = _shaken(question, structure, rows)
    friction, particle = friction_of(damper, scale), particle_of(damper, scale)
    ready = Ready(base, make_linear_motion(base, 1.0, None))
    periods = base.windows * base.window / (2.0 * pi)
    budget = base.windows + int(EVENTS_PER_PERIOD * (periods + 10.0))
    start = Perturbation(given.get(RELEASE, 0.0) / scale.length_m)
    log = empty_log(budget + 1000)
    run = run_on_record(ready, friction, particle, start, budget, log)
    if run.outcome != ARRIVED or log.cursor[0] > log.capacity:
        return np.full(rows, np.nan)
    # every sample is the start of a panel, and every start of a panel is the start of a segment
    logged = Logged(*stored_rows(log).T)
    starts, v = logged.start, logged.v
    pieces = base.windows // (rows - 1)
    windows = np.arange(0, base.windows, pieces)
    at = np.searchsorted(starts, windows * base.window - 1e-9 * base.window)
    found = np.append(v[at], run.end.v)
    if not measured.relative:
        found += base.position[::pieces]
    return np.asarray(found * scale.length_m)


def built(question: HistoryQuestion, given: Mapping[str, float]) -> tuple[Structure, Damper]:
    """Return the structure and the damper for given values of the parameters of a study."""
    mass = given.get("mass_kg", NOMINAL_KG)
    structure = Structure(mass, given["natural_frequency_hz"], given.get("damping_ratio", 0.0))
    if "damping_n_s_per_m" in given:
        damping = given["damping_n_s_per_m"] / (2.0 * mass * structure.omega)
        structure = Structure(mass, structure.natural_frequency_hz, damping)
    free = {each.name for each in question.free}
    force = given.get("friction_force_n", 0.0)
    if "friction_force_n" in free:
        force = max(force, LEAST * mass * structure.omega**2 * question.measured.largest_m)
    if not question.particle:
        return structure, Damper(force)
    particle = given.get("particle_mass_kg", given.get("mass_ratio", 0.0) * mass)
    if free & {"particle_mass_kg", "mass_ratio"}:
        particle = max(particle, LEAST * mass)
    least = dict.fromkeys(free.intersection(MADE_BY.values()), LEAST)
    cavity = cavity_of({name: max(given.get(name, 0.0), least.get(name, 0.0)) for name in MADE_BY.values()})
    clearance, restitution = given.get("clearance_m", 0.0), given.get("restitution", 0.0)
    return structure, Damper(force, particle, clearance, restitution, question.contact, cavity)


def scenes_of(question: HistoryQuestion) -> list[Scene]:
    """Return the scene that a fit of a time history needs. The scene does not depend on the ranges."""
    given = question.given(question.values(np.full(len(question.free), 0.5)))
    structure, damper = built(question, given)
    scale = Scale(1.0, structure.omega, structure.mass_kg)
    return [Scene("record-history", damper.friction_force_n > 0.0, contact_name(particle_of(damper, scale)))]


def _shaken(question: HistoryQuestion, structure: Structure, rows: int) -> tuple[RecordBase, Scale]:
    """Return the dimensionless base motion and its scale. One panel begins at each sample."""
    measured = question.measured
    step = structure.omega * measured.step_s
    if measured.base_m_s2 is None:
        base = make_record_base(np.zeros(rows), step, structure.damping_ratio)
        # without a base acceleration, the force of the spring at the release is the scale for rounding
        length = measured.largest_m
        return base._replace(largest=1.0), Scale(length, structure.omega, structure.mass_kg)
    peak = float(np.abs(measured.base_m_s2).max())
    base = make_record_base(measured.base_m_s2[:rows] / peak, step, structure.damping_ratio)
    return base, Scale(peak / structure.omega**2, structure.omega, structure.mass_kg)
