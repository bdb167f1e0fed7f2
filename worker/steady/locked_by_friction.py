"""Tests for a locked mass, which friction holds permanently, and for motions that tend to a locked state."""

from math import inf, pi, sqrt

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import inlined, kernel
from damperlab.worker.solver.events import ARRIVED, IMPACTS
from damperlab.worker.solver.excitation.excitation import has_force, largest_forcing
from damperlab.worker.solver.integrate import half_cycle_on_addresses
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.sliding import rubs
from damperlab.worker.solver.state import State
from damperlab.worker.steady.run import begin_probe
from damperlab.worker.steady.section.recurrence import recurrence

_CREEP = 1e-2  # excess displacement, over min(1, P r²), below which creep cannot overshoot the locked range
_TIE = 1e-12
_REPEATS = (
    1e-9  # displacements and the particle's velocity repeat if they change by at most this value in a cycle
)


@inlined
def _edge(friction: float, forcing: float) -> float:
    """Largest |v| at which friction holds the mass permanently, γ_F − P; negative if there is no such position."""
    edge = friction - forcing
    if edge < 0.0 and edge > -_TIE * forcing:
        return 0.0  # γ_F equals P within rounding
    return edge


@inlined
def _creep(forcing: float, frequency_ratio: float) -> float:
    """Excess displacement below which a mass creeps without overshooting."""
    return _CREEP * min(1.0, forcing * (frequency_ratio * frequency_ratio))


@kernel
def creep_limit(state: State, friction: float, scene: Scene) -> tuple[State, bool]:
    """Return the locked state to which a one-sided creep tends, and whether the motion is such a creep.

    Let P be the largest forcing: r² for a shaken base, 1 for a force. For γ_F ≥ P every rest position
    |v| ≤ γ_F − P is locked permanently. From a distance x outside this range, the mass slips inwards by about
    4.5 x²/(P r²) in each cycle. So x falls only as 1/N over N cycles. Therefore the limit is computed
    directly, not by integration. A particle, if there is one, must be at rest and must not be hit by a wall,
    so that the position of the particle does not change.
    """
    forcing = largest_forcing(scene.base)
    edge = _edge(friction, forcing)
    # In each cycle, the forcing exceeds friction by less than x, for the time √(8x/P)/r.
    # The slip lasts one and a half times as long and covers 4.5 x²/(P r²).
    if (
        edge >= 0.0
        and state.slip == 0.0
        and state.p_rate == 0.0
        and state.riding == 0.0
        and edge < abs(state.v) <= edge + _creep(forcing, scene.base.frequency_ratio)
    ):
        v = edge if state.v > 0.0 else -edge
        gap = state.gap
        clear = True
        if scene.particle is not None:
            gap = state.gap - state.wall * (v - state.v)
            farthest = abs(gap - scene.particle.clearance_ratio) + scene.base.displacement
            clear = farthest <= scene.particle.clearance_ratio
        if clear:
            return state._replace(v=v, w=0.0, gap=gap, slip_order=0, gap_order=0), True
    return state, False


@kernel
def dragging_limit(state: State, friction: float, scene: Scene, probe: Scene) -> tuple[State, float]:
    """Return the limit of a one-sided creep on a shaken base, for a particle with friction (compare `creep_limit`).

    A sliding or carried particle adds at most β min(κ, r²) to the largest inertial force. So friction holds the mass
    permanently in the locked range |v| ≤ γ_F − r² − β min(κ, r²). One cycle is integrated with the mass at the edge
    of this range, to test whether the motion of the particle repeats.

    Returns
    -------
    limit : State
        State with the mass at the edge of the locked range, and with the present motion of the particle.
    apart : float
        Distance between `limit` and the state one cycle later; infinite if the creep has no such limit.
    """
    particle = scene.particle
    if particle is not None and particle.friction is not None and particle.gravity is None:
        forcing = largest_forcing(scene.base)
        load = forcing + particle.mass_ratio * min(particle.friction, forcing)
        edge = _edge(friction, load)
        outside = abs(state.v) - edge
        if edge >= 0.0 and state.slip == 0.0 and 0.0 < outside <= _creep(forcing, scene.base.frequency_ratio):
            v = edge if state.v > 0.0 else -edge
            gap = state.gap - state.wall * (v - state.v)
            held = state._replace(v=v, w=0.0, gap=gap, slip_order=0, gap_order=0)
            begin_probe(probe, scene, 2)
            after, arrived = held, ARRIVED
            for _ in range(2):
                if arrived == ARRIVED:
                    after, arrived = half_cycle_on_addresses(after, probe, None, None)
            if arrived == ARRIVED and probe.counts[IMPACTS] == scene.counts[IMPACTS]:
                apart = max(abs(after.v - v), abs(after.gap - gap), abs(after.p_rate - state.p_rate))
                if after.wall == state.wall and apart <= _REPEATS:
                    return held, apart
    return state, inf


@kernel
def is_locked(state: State, friction: float, forcing: float, ring: NDArray[np.float64], half: int) -> bool:
    """Whether the mass is locked: P + |v| ≤ γ_F, the particle at rest, and no motion of the mass for a cycle."""
    return (
        state.slip == 0.0
        and state.p_rate == 0.0
        and forcing + abs(state.v) <= friction
        and recurrence(ring, half, 2) == 0.0
    )


@kernel
def slowing_limit(state: State, friction: float, particle: Particle, scene: Scene) -> tuple[State, float]:
    """Return the locked state to which a mass under a force tends while the particle slows down between the walls.

    Returns
    -------
    limit : State
        State with the particle at rest and the mass at its present position. If the mass still creeps, its position is
        the edge of the locked range, |v| = γ_F − P.
    way_left : float
        Bound on the distance from `limit` to the final position of the mass; infinite if no bound is known.

    Notes
    -----
    Let c be the largest creep speed of the walls, and s the speed of the particle. After an impact, the particle is no
    faster than the larger of s and c (1 + e)/(1 − e). Once |v| ≤ γ_F − P, mass and particle only lose energy. In all
    impacts together, the particle transmits at most the velocity W = β (s + c) (1 + e)/(1 − e) to the mass.

    Let τ be the time from a maximum of the forcing, |rτ| ≤ π. The forcing is below the limit of friction and
    spring by at least P (1 − cos rτ) ≥ 2P (rτ/π)². So a slip that begins with the velocity W and passes one
    maximum ends within the time 2a + W π²/(2P r² a²), for any a up to π/r; here a = W^¼. If |v| is below
    γ_F − P by a margin, W divided by this margin is also a bound on the duration of the slip. The mass can
    also move with the velocity W during a creep slip and during a contact, so the durations of a creep slip
    and of a contact are added. A compliant wall whose largest force stays within the margin does not move the
    mass.

    Impacts that move the mass outwards increase the creep. So, from the first bound b, a second bound is
    computed for a mass displaced outwards by 2b; the smaller of 2b and the second bound is returned. Two
    assumptions are confirmed by integrations, but not proved. First, the impacts during the creep, at most
    one per cycle, move the mass no farther than the bound allows. Second, 2b is a valid bound even if the
    second bound exceeds 2b.
    """
    forcing = largest_forcing(scene.base)
    edge = _edge(friction, forcing)
    between_contacts = state.gap >= 0.0
    if state.dwell is not None:
        between_contacts = between_contacts and state.dwell.left == 0.0 and state.riding == 0.0
    farthest = edge + _creep(forcing, scene.base.frequency_ratio)
    if edge < 0.0 or state.slip != 0.0 or not between_contacts or abs(state.v) > farthest:
        return state, inf
    first = _way_left(state, 0.0, edge, particle, scene)
    if abs(state.v) + first > farthest:
        return state, inf
    way_left = min(_way_left(state, 2.0 * first, edge, particle, scene), 2.0 * first)
    v = state.v
    if abs(v) > edge:
        v = edge if state.v > 0.0 else -edge
    return state._replace(v=v, w=0.0, p_rate=0.0, slip_order=0, gap_order=0), way_left


@kernel
def slows_down(scene: Scene) -> bool:
    """Whether every motion under a force ends with mass and particle at rest: friction withstands the force, and e < 1.

    The mean peak of a motion that ends at rest does not describe a steady response, even if the error of the
    mean is small.
    """
    if scene.friction is not None:
        if scene.particle is not None and has_force(scene.base) and not rubs(scene.particle):
            withstands = _edge(scene.friction, largest_forcing(scene.base)) >= 0.0
            slows: bool = withstands and scene.particle.restitution < 1.0
            return slows
    return False


@kernel
def _way_left(state: State, moved: float, edge: float, particle: Particle, scene: Scene) -> float:
    """Bound on the total distance by which impacts move a locked mass, computed with |v| increased by `moved`."""
    forcing = largest_forcing(scene.base)
    frequency_ratio = scene.base.frequency_ratio
    restitution = _restitution_of_a_held_wall(particle)
    if restitution >= 1.0:
        return inf
    margin = edge - abs(state.v) - moved
    excess = max(-margin, 0.0)
    # longest time for which the forcing exceeds friction
    exceeds = pi * sqrt(2.0 * excess / forcing) / frequency_ratio
    creep_rate = excess * exceeds
    gain = (1.0 + restitution) / (1.0 - restitution)
    speed = max(abs(state.p_rate), gain * creep_rate)
    if particle.wall is not None and margin >= 0.0:
        if speed * (sqrt(particle.wall.stiffness * particle.mass_ratio) + particle.wall.damping) <= margin:
            return 0.0
    given = particle.mass_ratio * gain * (speed + creep_rate)
    a = sqrt(sqrt(given))
    if a * frequency_ratio > pi:
        return inf
    stopping = 2.0 * a + sqrt(given) * (0.5 * pi * pi) / (forcing * frequency_ratio * frequency_ratio)
    if margin > 0.0:
        stopping = min(stopping, given / margin)
    if stopping * frequency_ratio > 2.0 * pi:
        return inf
    way_left: float = given * (1.5 * exceeds + stopping + _longest_contact(particle))
    return way_left


@inlined
def _restitution_of_a_held_wall(particle: Particle) -> float:
    """Largest restitution at a wall while friction holds the mass at rest.

    An impact on a held mass involves the mass β of the particle instead of the reduced mass β/(1 + β). The
    larger mass reduces the damping ratio at a compliant wall by the factor √(1 + β). So the restitution is at
    most eᵃ with a = 1/√(1 + β), and 1 − eᵃ ≥ a (1 − e).
    """
    if particle.wall is not None:
        return 1.0 - (1.0 - particle.restitution) / sqrt(1.0 + particle.mass_ratio)
    return particle.restitution


@inlined
def _longest_contact(particle: Particle) -> float:
    """Longest duration of a contact [1/ω_n]: half a cycle of the particle on the spring of a compliant wall."""
    if particle.wall is not None:
        return pi * sqrt(particle.mass_ratio / particle.wall.stiffness)
    if particle.contact_time is not None:
        return particle.contact_time
    return 0.0
