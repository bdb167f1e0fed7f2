"""Impact between the primary mass and the particle, equations (5) to (8). The impact is instantaneous, or the bodies
stay attached for the contact time and then separate.
"""

from damperlab.worker.jit import inlined


@inlined
def rebound(u_rate: float, p_rate: float, restitution: float, mass_ratio: float) -> tuple[float, float]:
    """Return the velocities after an impact, in which momentum is conserved.

    Parameters
    ----------
    u_rate, p_rate : float
        Velocities of primary mass and particle before the impact [Z ω_n].
    restitution : float
        Coefficient of restitution e; 0 gives both bodies the same velocity.
    mass_ratio : float
        β = m/M.

    Returns
    -------
    jump : float
        Change of the primary mass's velocity. The velocity relative to the base changes by the same amount. The change
        is exactly 0 for a particle without mass.
    p_rate_after : float
        Particle velocity after the impact.

    Notes
    -----
    Equations (7) and (8), written with the approach speed factored out:
    u'⁺ = u'⁻ − β(1+e)/(1+β) (u'⁻ − p'⁻),  p'⁺ = p'⁻ + (1+e)/(1+β) (u'⁻ − p'⁻).
    """
    exchanged = (1.0 + restitution) / (1.0 + mass_ratio) * (u_rate - p_rate)
    return -mass_ratio * exchanged, p_rate + exchanged


@inlined
def part(leaving_speed: float, mass_ratio: float) -> tuple[float, float]:
    """Return the velocity changes of two attached bodies that separate with a given relative speed; momentum is
    conserved.

    Parameters
    ----------
    leaving_speed : float
        Particle velocity minus primary velocity afterwards [Z ω_n].
    mass_ratio : float
        β.

    Returns
    -------
    jump, p_jump : float
        Velocity changes of the primary mass and of the particle.
    """
    p_jump = leaving_speed / (1.0 + mass_ratio)
    return -mass_ratio * p_jump, p_jump


@inlined
def kept_energy(approach_speed: float, restitution: float, mass_ratio: float) -> float:
    """Energy recovered when the bodies separate, over M (Z ω_n)²: ½ β/(1+β) e² (approach speed)²."""
    return 0.5 * mass_ratio / (1.0 + mass_ratio) * (restitution * approach_speed) ** 2


@inlined
def impact_loss(approach_speed: float, restitution: float, mass_ratio: float) -> float:
    """Energy lost in an impact, over M (Z ω_n)²: ½ β/(1+β) (1−e²) (approach speed)²."""
    return 0.5 * mass_ratio / (1.0 + mass_ratio) * (1.0 - restitution * restitution) * approach_speed**2
