"""Transition at an event for a particle with friction: the slip of both bodies is determined together.

Bodies of equal velocity move on together if the force between them gives u'' = p''. A larger force on the particle
reduces u'' and increases p''. So the particle starts to slide if the required force exceeds the largest friction, βκ;
the push of a wall has no upper limit. The friction of the structure is determined for each trial force.
"""

from damperlab.worker.jit import inlined
from damperlab.worker.physics.friction import breakaway
from damperlab.worker.physics.impact import impact_loss, rebound
from damperlab.worker.solver.contact.chatter import is_chatter_over
from damperlab.worker.solver.contact.rest import SPEED_ROUNDING, STILL, meet, slip_at, slip_from_rest
from damperlab.worker.solver.events import (
    ATTACHMENTS,
    FAR_WALL,
    NEAR_WALL,
    RELEASE,
    REST,
    SLIP_ONSET,
    TURN,
    TURNS,
)
from damperlab.worker.solver.excitation.excitation import Phase, largest_forcing
from damperlab.worker.solver.observe.meter import IMPACT_LOSS, Meter
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.sliding import direction_of, fall_of
from damperlab.worker.solver.state import Slide, State


@inlined
def after_event_of_rubbing(
    state: State,
    kind: int,
    phase: Phase,
    scene: Scene,
    particle: Particle,
    friction: float,
    meter: Meter | None,
) -> State:
    """Return the state just after an event for a particle with friction κ (see `reset_map.after_event`)."""
    if kind in (NEAR_WALL, FAR_WALL):
        return _impact(state, kind, phase, scene, particle, friction, meter)
    w, slip, direction = state.w, state.slip, direction_of(state.slide)
    if kind == TURN:
        scene.counts[TURNS] += 1
        w = 0.0
    if kind == REST or state.riding > 0.0:
        moved = state._replace(w=w, p_rate=w + phase.rate)
        loose = _torn_to(moved, phase, scene, particle) if kind == RELEASE else 0.0
        return _together(moved, loose, kind == SLIP_ONSET, phase, scene, particle, friction)
    slip_order = 0
    if w == 0.0:
        pull = _pull(state, direction, particle, friction)
        slip = slip_from_rest(state.v + pull, 0.0, 1.0, kind == SLIP_ONSET, phase, scene)
        slip_order = int(slip != 0.0)
    return state._replace(
        w=w,
        slip=slip,
        riding=0.0,
        slip_order=slip_order,
        gap_order=0,
        slide=_slide(state, direction, 0),
    )


@inlined
def _slide(state: State, direction: float, order: int) -> Slide | None:
    if state.slide is None:
        return None
    return state.slide._replace(direction=direction, order=order)


@inlined
def _pull(state: State, direction: float, particle: Particle, friction: float) -> float:
    """Force of a sliding particle on the mass: the reaction to the particle's acceleration; positive towards −u."""
    rubbing = friction * direction
    return particle.mass_ratio * (rubbing + fall_of(state.slide, particle))


@inlined
def _response(state: State, pull: float, inertia: float, phase: Phase, scene: Scene) -> tuple[float, float]:
    """Slip direction and acceleration u'' of the mass.

    `inertia` includes a particle that moves with the mass, and `pull` is the force of a sliding particle.
    """
    base = scene.base
    slip = 0.0
    offset = pull
    if scene.friction is not None:
        slip = state.slip
        if state.w == 0.0:
            slip = slip_from_rest(state.v + pull, 0.0, inertia, False, phase, scene)
            if slip == 0.0:
                return 0.0, -phase.inertia_force
        offset += slip * scene.friction
    resistance = base.two_zeta * state.w + state.v + offset - phase.force
    return slip, -resistance / inertia


@inlined
def _torn_to(state: State, phase: Phase, scene: Scene, particle: Particle) -> float:
    """Sign of u' − p' of a particle that starts to slide.

    The particle leaves the wall that it touches or, away from walls, lags behind the accelerating mass.
    """
    if state.gap == 0.0:
        return -state.wall
    _, acceleration = _response(state, 0.0, 1.0 + particle.mass_ratio, phase, scene)
    return 1.0 if acceleration > fall_of(state.slide, particle) else -1.0


@inlined
def _together(
    state: State,
    loose: float,
    slips: bool,
    phase: Phase,
    scene: Scene,
    particle: Particle,
    friction: float,
) -> State:
    """Return the state after mass and particle reach equal velocities: either common motion, or the start of a slide.

    Parameters
    ----------
    state : State
        State with the common velocity. The slip in this state is used only if the mass moves; the contact and
        the sliding in this state are not used.
    loose : float
        Direction in which the particle certainly starts to slide; 0 if the direction is to be determined.
    slips : bool
        Whether the mass, at rest on the base, certainly starts to slip.
    """
    limit = breakaway(friction, largest_forcing(scene.base))
    fall = fall_of(state.slide, particle)
    on_wall = state.gap == 0.0
    direction = loose
    if loose == 0.0:
        _, forward = _response(state, _pull(state, 1.0, particle, friction), 1.0, phase, scene)
        _, backward = _response(state, _pull(state, -1.0, particle, friction), 1.0, phase, scene)
        if forward - fall > limit and not (on_wall and state.wall > 0.0):
            direction = 1.0
        elif backward - fall < -limit and not (on_wall and state.wall < 0.0):
            direction = -1.0
    carried = direction == 0.0
    inertia = 1.0 + particle.mass_ratio if carried else 1.0
    pull = 0.0 if carried else _pull(state, direction, particle, friction)
    slip, acceleration = _response(state, pull, inertia, phase, scene)
    if slips:
        slip = slip_from_rest(state.v + pull, 0.0, inertia, True, phase, scene)
    slip_order = int(state.w == 0.0 and slip != 0.0)
    order, gap_order, riding = 0, 0, 1.0
    if not carried:
        gathers = direction * (acceleration - fall) - friction
        scale = largest_forcing(scene.base) + abs(state.w) + abs(state.v) + friction
        order = 1 if gathers > STILL * scale else 2
        gap_order, riding = 1 + order if on_wall else 0, 0.0
    slide = _slide(state, direction, order)
    return state._replace(slip=slip, riding=riding, slip_order=slip_order, gap_order=gap_order, slide=slide)


@inlined
def _impact(
    state: State,
    kind: int,
    phase: Phase,
    scene: Scene,
    particle: Particle,
    friction: float,
    meter: Meter | None,
) -> State:
    """Return the state just after an impact: a flight with sliding friction, or common motion of both bodies."""
    wall = state.wall if kind == NEAR_WALL else -state.wall
    u_rate = state.w + phase.rate
    approach, _ = meet(state, wall, phase, scene, meter)
    jump, p_rate = rebound(u_rate, u_rate - wall * approach, particle.restitution, particle.mass_ratio)
    leaving = particle.restitution * approach
    w = state.w + jump
    after = state._replace(w=w, slip=slip_at(w, state.slip, scene), wall=wall, gap=0.0, p_rate=p_rate)
    rounding = SPEED_ROUNDING * (abs(u_rate) + abs(p_rate) + abs(phase.rate))
    # while the wall approaches the particle again, friction pushes the particle away from the wall
    _, acceleration = _response(after, _pull(state, wall, particle, friction), 1.0, phase, scene)
    closing = wall * (acceleration - fall_of(state.slide, particle)) - friction
    loss = impact_loss(approach, particle.restitution, particle.mass_ratio)
    joins = leaving <= rounding or (
        closing > 0.0 and is_chatter_over(after.w, leaving, acceleration, closing, scene, particle)
    )
    if joins:
        jump, _ = rebound(after.w + phase.rate, p_rate, 0.0, particle.mass_ratio)
        loss += impact_loss(leaving, 0.0, particle.mass_ratio)
        w = after.w + jump
        joined = after._replace(w=w, slip=slip_at(w, state.slip, scene), p_rate=w + phase.rate)
        after = _together(joined, 0.0, False, phase, scene, particle, friction)
        if after.riding > 0.0:
            scene.counts[ATTACHMENTS] += 1
    else:
        after = after._replace(riding=0.0, slip_order=0, gap_order=1, slide=_slide(state, -wall, 0))
    if meter is not None:
        if meter.energies is not None:
            meter.sums[IMPACT_LOSS] += loss
    return after
