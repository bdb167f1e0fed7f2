"""What mass and particle move in while they touch: one body on a rigid wall, two pressed together on a compliant one."""

from typing import Any

from numba import types

from damperlab.worker.jit import by_type, inlined, kernel
from damperlab.worker.solver.contact.compliant.motion import Contact, make_contact, point_contact
from damperlab.worker.solver.motion.propagator import Medium, make_medium, point_medium
from damperlab.worker.solver.state import Particle, Wall


@kernel
def _make_medium(base, particle, energies):
    return make_medium(base, 1.0 + particle.mass_ratio, energies)


@inlined
def _choose(free, loaded, riding):
    return loaded if riding > 0.0 else free


def make_loaded(base: Any, particle: Particle, wall: Wall | None, energies: bool | None) -> Medium | Contact:
    """`Medium` of both bodies as one, or the `Contact` of a compliant wall.

    Parameters
    ----------
    base : Base
        The base.
    particle : Particle
        The particle.
    wall : Wall or None
        `particle.wall`, once more by itself: its type tells the compiler which of the two it is.
    energies : True or None
        As for `propagator.make_base`.
    """
    made: Medium | Contact = (
        _make_medium(base, particle, energies) if wall is None else make_contact(base, particle, wall)
    )
    return made


@by_type(make_loaded)
def _make_loaded(base, particle, wall, energies):
    if isinstance(wall, types.NoneType):
        return lambda base, particle, wall, energies: _make_medium(base, particle, energies)
    return lambda base, particle, wall, energies: make_contact(base, particle, wall)


def point_loaded(loaded: Any, wall: Wall | None) -> Any:
    """The same with addresses for arrays; the arrays must outlive it."""
    return point_medium(loaded) if wall is None else point_contact(loaded)


@by_type(point_loaded)
def _point_loaded(loaded, wall):
    if isinstance(wall, types.NoneType):
        return lambda loaded, wall: point_medium(loaded)
    return lambda loaded, wall: point_contact(loaded)


def medium_of(free: Any, loaded: Any, riding: float, wall: Wall | None) -> Any:
    """The medium of a window; in a compliant wall `compliant.phase.through_wall` goes on instead."""
    return _choose(free, loaded, riding) if wall is None else free


@by_type(medium_of)
def _medium_of(free, loaded, riding, wall):
    if isinstance(wall, types.NoneType):
        return lambda free, loaded, riding, wall: _choose(free, loaded, riding)
    return lambda free, loaded, riding, wall: free
