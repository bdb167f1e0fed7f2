"""Conversion of the points of a block into arguments of kernels."""

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.choices import CompliantContact, Contact, DwellContact
from damperlab.studies.definition import Study
from damperlab.studies.plan import Block
from damperlab.studies.variables import BEFORE, GRAVITY, PARTICLE_FRICTION, dimensions_of
from damperlab.worker.physics.compliant_wall import wall_constants
from damperlab.worker.solver.particle import Particle, Wall
from damperlab.worker.steady.response.measures import ACCELERATION, INTEGRATED

LEAST_REBOUND = 1e-14
"""Coefficient of restitution below which the rebound speed is within the rounding error of the velocities."""


def rebound_of(restitution: float) -> float:
    """Return the coefficient of restitution for the solver, which is 0 below `LEAST_REBOUND`."""
    return restitution if restitution >= LEAST_REBOUND else 0.0


def wants_energies(study: Study) -> bool | None:
    """Return True if a study needs integrals over the motion, else None for kernels without these integrals."""
    return True if (INTEGRATED | ACCELERATION) & set(study.metrics) else None


def wants_acceleration(study: Study) -> bool | None:
    """Return True if a study stores a measure of u'', else None for kernels without u''."""
    return True if ACCELERATION & set(study.metrics) else None


def block_points(study: Study, block: Block) -> dict[str, NDArray[np.float64]]:
    """Return the ratios at every point of a block.

    Returns
    -------
    dict of ndarray, shape (block points,)
        One flat array for each ratio, in C order of the block.
    """
    axes = [axis[part] for axis, part in zip(study.coordinates.values(), block.slices, strict=True)]
    grids = np.meshgrid(*axes, indexing="ij")
    points = {name: grid.reshape(-1) for name, grid in zip(study.coordinates, grids, strict=True)}
    ratios = study.ratios(points)
    return {name: ratios[name] for name in dimensions_of(ratios)}


def has_friction(points: dict[str, NDArray[np.float64]]) -> NDArray[np.bool_]:
    """Return the mask of points with friction, γ_F > 0."""
    return points["friction_ratio"] > 0.0


def has_particle(points: dict[str, NDArray[np.float64]], particle: bool) -> NDArray[np.bool_]:
    """Return the mask of points at which a particle acts: β > 0, and the study has a `particle`."""
    return (points["mass_ratio"] > 0.0) & particle


def contact_time_of(contact: Contact | None) -> float | None:
    """Return the contact time of the model `dwell`, or None for another contact model."""
    return contact.contact_time if isinstance(contact, DwellContact) else None


def wall_of(contact: Contact | None, restitution: float, mass_ratio: float) -> Wall | None:
    """Return the wall of the model `compliant`, or None for another contact model or a particle without mass."""
    if not isinstance(contact, CompliantContact) or mass_ratio == 0.0:
        return None
    return Wall(*wall_constants(float(restitution), contact.contact_time, float(mass_ratio)))


def acting(before: Mapping[str, float]) -> tuple[float | None, float | None]:
    """Return κ and G for the solver. A ratio of 0 becomes None, except that κ remains 0 under gravity without friction.

    Parameters
    ----------
    before : mapping of float
        Ratios by the names in `BEFORE`. A missing ratio is 0.
    """
    rubs, falls = (float(before.get(name, 0.0)) for name in (PARTICLE_FRICTION, GRAVITY))
    return (rubs if rubs > 0.0 or falls > 0.0 else None), (falls if falls > 0.0 else None)


def kernel_arguments(
    study: Study, points: dict[str, NDArray[np.float64]], chosen: NDArray[np.intp]
) -> Iterator[tuple[int, float, float, float | None, Particle | None]]:
    """Yield index, ζ, r, friction and particle of each chosen point. Friction and particle are None at points without
    them.
    """
    contact = study.contact
    contact_time = contact_time_of(contact)
    rubs = has_friction(points)
    rattles = has_particle(points, study.particle)
    before = [name for name in BEFORE if name in points]
    for i in chosen:
        yield (
            int(i),
            float(points["damping_ratio"][i]),
            float(points["frequency_ratio"][i]),
            float(points["friction_ratio"][i]) if rubs[i] else None,
            Particle(
                float(points["clearance_ratio"][i]),
                rebound_of(float(points["restitution"][i])),
                float(points["mass_ratio"][i]),
                contact_time,
                wall_of(contact, float(points["restitution"][i]), float(points["mass_ratio"][i])),
                *acting({name: float(points[name][i]) for name in before}),
            )
            if rattles[i]
            else None,
        )
