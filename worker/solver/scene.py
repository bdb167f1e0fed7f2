"""A scene: all data for an integration over half a cycle or over a record."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import inlined, kernel
from damperlab.worker.solver.addresses import Floats, address
from damperlab.worker.solver.array_loops import zero_counts
from damperlab.worker.solver.events import COUNTS
from damperlab.worker.solver.excitation.excitation import contact_forcing
from damperlab.worker.solver.excitation.sine import make_sine
from damperlab.worker.solver.linear_motion import LinearMotion, make_linear_motion
from damperlab.worker.solver.motion.compliant_equations import make_contact
from damperlab.worker.solver.motion.taylor import TERMS
from damperlab.worker.solver.particle import Particle


class Scene(NamedTuple):
    """Data of an integration.

    An absent element is None, and the compiler omits its code in every function that receives the scene.

    Attributes
    ----------
    base : Sine or RecordBase
        The excitation.
    free : LinearMotion
        The motion of the primary mass alone.
    loaded : LinearMotion, Contact or None
        The motion in sustained contact with a rigid wall, or in contact with a compliant wall; None without a particle.
    friction : float or None
        γ_F; None without friction.
    particle : Particle or None
        The particle.
    scratch : array, shape (4, TERMS)
        Polynomials of the present segment (`Curves`).
    counts : int64 array, shape (COUNTS,)
        Event counts, which an integration increases; counts[BUDGET] is the largest allowed number of segments.
    """

    base: Any
    free: LinearMotion
    loaded: Any
    friction: float | None
    particle: Particle | None
    scratch: NDArray[np.float64]
    counts: NDArray[np.int64]


class Curves(NamedTuple):
    """Polynomials of a segment: x, x + s and the excitation (s or the force), and a work array."""

    relative: Floats
    absolute: Floats
    excitation: Floats
    scratch: Floats


@inlined
def curves_of(scene: Scene) -> Curves:
    """Buffers for the polynomials of a segment."""
    return Curves(
        address(scene.scratch, 0),
        address(scene.scratch, TERMS),
        address(scene.scratch, 3 * TERMS),
        address(scene.scratch, 2 * TERMS),
    )


@kernel
def make_scene(
    damping_ratio: float,
    frequency_ratio: float,
    friction: float | None,
    particle: Particle | None,
    energies: bool | None,
    forced: bool = False,
) -> Scene:
    """Make the scene of one design point under a harmonic excitation.

    Parameters
    ----------
    damping_ratio, frequency_ratio : float
        ζ and r.
    friction : float or None
        γ_F; None without friction.
    particle : Particle or None
        The particle.
    energies : True or None
        True if a meter needs integrals (`observe.meter.Meter`), else None.
    forced : bool
        Whether a force on the structure replaces the shaken base. Lengths are then divided by F₀/k.
    """
    base = make_sine(damping_ratio, frequency_ratio, energies, forced)
    return scene_on(base, friction, particle, energies)


@kernel
def scene_on(base: Any, friction: float | None, particle: Particle | None, energies: bool | None) -> Scene:
    """Make a scene under a given excitation, with all counts at 0."""
    free = make_linear_motion(base, 1.0, energies)
    loaded = None
    if particle is not None:
        loaded = make_loaded(base, particle, energies)
    return Scene(base, free, loaded, friction, particle, np.empty((4, TERMS)), zero_counts(COUNTS))


@kernel
def make_loaded(base: Any, particle: Particle, energies: bool | None) -> Any:
    """Make the `LinearMotion` of mass and particle together, or the `Contact` with a compliant wall."""
    if particle.wall is None:
        return make_linear_motion(base, 1.0 + particle.mass_ratio, energies)
    return make_contact(contact_forcing(base), particle, particle.wall)
