"""Regimes and segments of the motion between events."""

from typing import NamedTuple

from damperlab.worker.jit import inlined
from damperlab.worker.solver.excitation.excitation import Excitation, Phase, phase_at, phase_until
from damperlab.worker.solver.linear_motion import LinearMotion
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.sliding import with_pull
from damperlab.worker.solver.state import State


class Regime(NamedTuple):
    """The linear equation of motion between two events.

    Attributes
    ----------
    sticks : bool
        Whether friction holds the mass on the base.
    offset : float
        Offset of the spring centre: ±γ_F in slip, plus the pull of a particle with friction; 0 if friction holds the
        mass.
    motion : LinearMotion
        The motion in slip, for the mass alone or with the particle in sustained contact.
    """

    sticks: bool
    offset: float
    motion: LinearMotion


class MotionBounds(NamedTuple):
    """Bounds on |w| and |u''| over a span."""

    w: float
    u2: float


class Span(NamedTuple):
    """The part of a panel that remains to be integrated.

    Attributes
    ----------
    phase, end : Phase
        Phase at the start of the span, and at the end of the panel.
    remaining : float
        Time from `phase` to `end` [1/ω_n].
    whole : bool
        Whether the span is the complete panel.
    """

    phase: Phase
    end: Phase
    remaining: float
    whole: bool


class Segment(NamedTuple):
    """A part of the motion in one regime.

    Attributes
    ----------
    start, end : State
        States at the start and at the end. Before the search for events, `end` of a complete panel is its end state
        without events, and `end` of a shorter segment is not valid.
    phase, phase_end : Phase
        Phase at the start and at the end of the segment.
    regime : Regime
        Regime of the segment.
    time : float
        Length of the segment [1/ω_n].
    bounds : MotionBounds
        Bounds on the motion over the segment.
    """

    start: State
    end: State
    phase: Phase
    phase_end: Phase
    regime: Regime
    time: float
    bounds: MotionBounds


@inlined
def window_at(base: Excitation, k: int) -> Span:
    """Panel k as a `Span` that begins at the start of the panel."""
    return Span(phase_at(base, k), phase_until(base, k), base.window, True)


@inlined
def slip_regime(slip: float, friction: float | None) -> tuple[bool, float]:
    """Return whether friction holds the mass, and the offset of the spring centre: ±γ_F in slip, else 0."""
    if friction is not None:
        return slip == 0.0, slip * friction
    return False, 0.0


@inlined
def regime_of(state: State, scene: Scene) -> Regime:
    """Regime of a state without the force of a compliant wall."""
    sticks, offset = slip_regime(state.slip, scene.friction)
    if not sticks:
        offset = with_pull(offset, state, scene.particle)
    return Regime(sticks, offset, motion_of(state.riding, scene))


@inlined
def motion_of(riding: float, scene: Scene) -> LinearMotion:
    """Motion of the mass alone, or of mass and particle in sustained contact with a rigid wall."""
    if scene.particle is not None and scene.particle.wall is None:
        return _choose(scene.free, scene.loaded, riding)
    return scene.free


@inlined
def _choose(free: LinearMotion, loaded: LinearMotion, riding: float) -> LinearMotion:
    return free if riding < 1.0 else loaded  # usually the first branch, which reads only the fields of `free`
