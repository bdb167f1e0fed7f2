"""Kernel arguments for the points of a study's block. Absent elements are None."""

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.choices import CompliantContact, Contact, DwellContact
from damperlab.studies.definition import Study
from damperlab.studies.plan import Block
from damperlab.studies.variables import BEFORE, GRAVITY, PARTICLE_FRICTION, dimensions_of
from damperlab.worker.physics.compliant_wall import wall_constants
from damperlab.worker.solver.excitation.sine_base import Forced
from damperlab.worker.solver.particle import Particle, Wall
from damperlab.worker.steady.response.measures import ACCELERATION, INTEGRATED

LEAST_REBOUND = 1e-14
"""Restitution below which the rebound speed is lower than the rounding of the velocities."""


def rebound_of(restitution: float) -> float:
    """Return e for the solver. A value below rounding is replaced by 0, so that the bodies move on together."""
    return restitution if restitution >= LEAST_REBOUND else 0.0


def wants_energies(study: Study) -> bool | None:
    """True if a study stores a measure that needs integrals over the motion; None removes them from its kernels."""
    return True if (INTEGRATED | ACCELERATION) & set(study.metrics) else None


def wants_acceleration(study: Study) -> bool | None:
    """True if a study stores a measure of u''; None removes u'' from its kernels."""
    return True if ACCELERATION & set(study.metrics) else None


def excitation_of(frequency_ratio: float, forced: bool) -> float | Forced:
    """Return a frequency for kernels: plain for a shaken base, wrapped for a force on the structure."""
    return Forced(frequency_ratio) if forced else frequency_ratio


def block_points(study: Study, block: Block) -> dict[str, NDArray[np.float64]]:
    """Coordinates of every point of a block.

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
    """Mask of friction: γ_F > 0."""
    return points["friction_ratio"] > 0.0


def has_particle(points: dict[str, NDArray[np.float64]], particle: bool) -> NDArray[np.bool_]:
    """Mask of a particle that acts on the structure: the scene has one, and β > 0."""
    return (points["mass_ratio"] > 0.0) & particle


def contact_time_of(contact: Contact | None) -> float | None:
    """Contact time of the contact model; None if impacts take no time."""
    return contact.contact_time if isinstance(contact, DwellContact) else None


def wall_of(contact: Contact | None, restitution: float, mass_ratio: float) -> Wall | None:
    """Compliant wall of the contact model; None if walls are rigid, or the particle has no mass."""
    if not isinstance(contact, CompliantContact) or mass_ratio == 0.0:
        return None
    return Wall(*wall_constants(float(restitution), contact.contact_time, float(mass_ratio)))


def acting(before: Mapping[str, float]) -> tuple[float | None, float | None]:
    """Return κ and G for the solver, None for one that does not act; but κ is 0 for a particle under gravity alone.

    Parameters
    ----------
    before : mapping of float
        Ratios by the names of `BEFORE`; a missing one is 0.
    """
    rubs, falls = (float(before.get(name, 0.0)) for name in (PARTICLE_FRICTION, GRAVITY))
    return (rubs if rubs > 0.0 or falls > 0.0 else None), (falls if falls > 0.0 else None)


def kernel_arguments(
    study: Study, points: dict[str, NDArray[np.float64]], chosen: NDArray[np.intp]
) -> Iterator[tuple[int, float, float | Forced, float | None, Particle | None]]:
    """Give index, ζ, excitation, friction and particle of each chosen point of a study; absent elements are None."""
    contact = study.contact
    contact_time = contact_time_of(contact)
    rubs = has_friction(points)
    rattles = has_particle(points, study.particle)
    before = [name for name in BEFORE if name in points]
    for i in chosen:
        yield (
            int(i),
            float(points["damping_ratio"][i]),
            excitation_of(float(points["frequency_ratio"][i]), study.forced),
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
