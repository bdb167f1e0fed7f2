"""What an event changes where the particle rubs on its cavity: which of the two bodies slip, decided together.

Where both have the same velocity, what friction passes on between them, f, is the one at which u'' = p'': the more of it, the
smaller is u'' and the larger is p'' = f/β. So the particle is torn loose where the largest f, βκ, is too little; a wall that
pushes has no largest one to its side. The friction of the structure is judged with each f that is tried.
"""

from damperlab.worker.jit import inlined
from damperlab.worker.physics.friction import breakaway, slip_direction
from damperlab.worker.physics.impact import impact_loss, rebound
from damperlab.worker.solver.contact.chatter import is_chatter_over
from damperlab.worker.solver.events import (
    ATTACHMENTS,
    FAR_WALL,
    IMPACTS,
    NEAR_WALL,
    RELEASE,
    REST,
    SLIP_ONSET,
    TURN,
    TURNS,
)
from damperlab.worker.solver.excitation.excitation import (
    Phase,
    force_to_hold,
    largest_forcing,
    largest_to_hold,
    net_resistance,
)
from damperlab.worker.solver.observe.meter import IMPACT_LOSS, SPEED, Meter
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.sliding import direction_of
from damperlab.worker.solver.state import Slide, State

_SPEED_ROUNDING = 1e-14  # relative: below this an outgoing speed is rounding
_STILL = 1e-9  # share of the accelerations at hand below which that of a beginning slide is rounding


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
    """The state just after an event, as `reset_map.after_event` gives it, of a particle with friction κ."""
    if kind in (NEAR_WALL, FAR_WALL):
        return _impact(state, kind, phase, scene, particle, friction, meter)
    w, p_rate = state.w, state.p_rate
    if kind == TURN:
        scene.counts[TURNS] += 1
        w = 0.0
    if kind == REST or state.riding > 0.0:
        p_rate = w + phase.rate
        moved = State(state.v, w, state.slip, state.wall, state.gap, p_rate, 0.0, 0, 0, None, Slide(0.0, 0))
        loose = _torn_to(moved, phase, scene, particle) if kind == RELEASE else 0.0
        return _together(moved, loose, kind == SLIP_ONSET, phase, scene, particle, friction)
    pull = particle.mass_ratio * friction * direction_of(state.slide)
    slip = state.slip
    slip_order = 0
    if w == 0.0:
        slip = _onset(state.v + pull, 1.0, phase, scene, kind == SLIP_ONSET)
        slip_order = 1 if slip != 0.0 else 0
    slide = Slide(direction_of(state.slide), 0)
    return State(state.v, w, slip, state.wall, state.gap, p_rate, 0.0, slip_order, 0, None, slide)


@inlined
def _onset(v: float, inertia: float, phase: Phase, scene: Scene, slips: bool) -> float:
    """Direction in which a mass at rest on the base slips, 0 where friction holds it and it is not known to slip."""
    if scene.friction is None:
        return 0.0
    force = force_to_hold(scene.base, phase, v, inertia)
    if slips:
        return 1.0 if force > 0.0 else -1.0
    return slip_direction(force, breakaway(scene.friction, largest_to_hold(scene.base, inertia)))


@inlined
def _response(state: State, pull: float, inertia: float, phase: Phase, scene: Scene) -> tuple[float, float]:
    """Slip of the mass and u'' under a pull of the particle, with the inertia of what moves along."""
    base = scene.base
    slip = 0.0
    offset = pull
    if scene.friction is not None:
        slip = state.slip
        if state.w == 0.0:
            slip = _onset(state.v + pull, inertia, phase, scene, False)
            if slip == 0.0:
                return 0.0, -phase.inertia_force
        offset += slip * scene.friction
    slips = net_resistance(base, phase, base.two_zeta * state.w + state.v + offset)
    return slip, -slips / inertia


@inlined
def _torn_to(state: State, phase: Phase, scene: Scene, particle: Particle) -> float:
    """Direction of the slide of a particle that is known to be torn loose: away from its wall, or with u''."""
    if state.gap == 0.0:
        return -state.wall
    _, acceleration = _response(state, 0.0, 1.0 + particle.mass_ratio, phase, scene)
    return 1.0 if acceleration > 0.0 else -1.0


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
    """Mass and particle with one velocity: the particle is carried, or slides from now on.

    Parameters
    ----------
    state : State
        With the particle's velocity; its slip counts where the mass moves.
    loose : float
        Direction in which the particle is known to be torn loose; 0 where that is to be judged.
    slips : bool
        Whether the mass, at rest on the base, is known to slip.
    """
    most = particle.mass_ratio * friction
    limit = breakaway(friction, largest_forcing(scene.base))
    on_wall = state.gap == 0.0
    slide = loose
    if loose == 0.0:
        _, forward = _response(state, most, 1.0, phase, scene)
        _, backward = _response(state, -most, 1.0, phase, scene)
        if forward > limit and not (on_wall and state.wall > 0.0):
            slide = 1.0
        elif backward < -limit and not (on_wall and state.wall < 0.0):
            slide = -1.0
    inertia = 1.0 + particle.mass_ratio if slide == 0.0 else 1.0
    slip, acceleration = _response(state, slide * most, inertia, phase, scene)
    if slips:
        slip = _onset(state.v + slide * most, inertia, phase, scene, True)
    slip_order = 1 if state.w == 0.0 and slip != 0.0 else 0
    if slide == 0.0:
        return State(
            state.v,
            state.w,
            slip,
            state.wall,
            state.gap,
            state.p_rate,
            1.0,
            slip_order,
            0,
            None,
            Slide(0.0, 0),
        )
    gathers = slide * acceleration - friction
    scale = largest_forcing(scene.base) + abs(state.w) + abs(state.v) + friction
    order = 1 if gathers > _STILL * scale else 2
    gap_order = 1 + order if on_wall else 0
    return State(
        state.v,
        state.w,
        slip,
        state.wall,
        state.gap,
        state.p_rate,
        0.0,
        slip_order,
        gap_order,
        None,
        Slide(slide, order),
    )


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
    """An impact, and what follows at once: a flight in which the particle rubs, or moving on together."""
    wall = state.wall if kind == NEAR_WALL else -state.wall
    u_rate = state.w + phase.rate
    approach = max(wall * (u_rate - state.p_rate), 0.0)
    if approach > _SPEED_ROUNDING * (abs(u_rate) + abs(state.p_rate) + abs(phase.rate)):
        scene.counts[IMPACTS] += 1
    jump, p_rate = rebound(u_rate, u_rate - wall * approach, particle.restitution, particle.mass_ratio)
    leaving = particle.restitution * approach
    w = state.w + jump
    slip = state.slip
    if scene.friction is not None and w != 0.0:
        slip = 1.0 if w > 0.0 else -1.0
    rounding = _SPEED_ROUNDING * (abs(u_rate) + abs(p_rate) + abs(phase.rate))
    after = State(state.v, w, slip, wall, 0.0, p_rate, 0.0, 0, 1, None, Slide(-wall, 0))
    # on its way back to the wall friction pushes the particle towards it
    _, acceleration = _response(after, wall * particle.mass_ratio * friction, 1.0, phase, scene)
    closing = wall * acceleration - friction
    loss = impact_loss(approach, particle.restitution, particle.mass_ratio)
    joins = leaving <= rounding or (
        closing > 0.0 and is_chatter_over(w, leaving, acceleration, closing, scene, particle)
    )
    if joins:
        jump, p_rate = rebound(w + phase.rate, p_rate, 0.0, particle.mass_ratio)
        loss += impact_loss(leaving, 0.0, particle.mass_ratio)
        w += jump
        if scene.friction is not None and w != 0.0:
            slip = 1.0 if w > 0.0 else -1.0
        p_rate = w + phase.rate
        after = State(state.v, w, slip, wall, 0.0, p_rate, 0.0, 0, 0, None, Slide(0.0, 0))
        after = _together(after, 0.0, False, phase, scene, particle, friction)
        if after.riding > 0.0:
            scene.counts[ATTACHMENTS] += 1
    if meter is not None:
        meter.sums[SPEED] = max(meter.sums[SPEED], approach)
        if meter.energies is not None:
            meter.sums[IMPACT_LOSS] += loss
    return after
