"""The regime of a motion in contact with a compliant wall."""

from typing import NamedTuple

from damperlab.worker.jit import inlined
from damperlab.worker.solver.motion.compliant_motion import Buffers, CompliantMotion
from damperlab.worker.solver.particle import Wall
from damperlab.worker.solver.regime import Regime, slip_regime
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.state import State


class CompliantRegime(NamedTuple):
    """The linear motion while a compliant wall pushes the particle.

    Attributes
    ----------
    sticks, offset
        Whether friction holds the mass, and the offset of the centre of the motion, as in `Regime`.
    motion, between : CompliantMotion
        The motion in contact, and the same motion with only y' as a fast coordinate.
    """

    sticks: bool
    offset: float
    motion: CompliantMotion
    between: CompliantMotion


AnyRegime = Regime | CompliantRegime


@inlined
def wall_of(scene: Scene) -> Wall:
    """The compliant wall of a scene."""
    assert scene.particle is not None
    assert scene.particle.wall is not None
    return scene.particle.wall


@inlined
def buffers_of(scene: Scene) -> Buffers:
    """Buffers for the Taylor polynomials of the motion in contact."""
    buffers: Buffers = scene.loaded.buffers
    return buffers


@inlined
def compliant_regime_of(state: State, scene: Scene) -> CompliantRegime:
    """Regime of a state in compliant contact."""
    contact = scene.loaded
    sticks, offset = slip_regime(state.slip, scene.friction)
    motion = contact.slipping
    between = contact.slipping_between
    if scene.friction is not None:
        if sticks:
            motion = contact.held
            between = contact.held_between
    return CompliantRegime(sticks, offset, motion, between)
