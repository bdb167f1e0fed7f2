"""Coulomb friction between the primary mass and the base.

The friction force is set-valued at rest: Sgn(0) = [−1, 1] in equation (1).
"""

from damperlab.worker.jit import inlined


@inlined
def hold_force(v: float, base_acceleration: float, inertia: float) -> float:
    """Friction force required to hold the mass on the base, over k Z.

    Parameters
    ----------
    v : float
        Displacement relative to the base [Z].
    base_acceleration : float
        −s'' = r² sin φ [Z ω_n²].
    inertia : float
        Inertia over M: 1 for the primary mass alone, 1 + β with the particle attached.

    Returns
    -------
    float
        F = inertia · r² sin φ − v; the mass sticks while |F| ≤ γ_F and otherwise slips in the direction of F.
    """
    return inertia * base_acceleration - v


_ROUNDING = 1e-14


@inlined
def breakaway(friction_ratio: float, force_most: float) -> float:
    """Force at which a sticking mass starts to slip: γ_F, plus a margin for the rounding of the force.

    If the largest force equals γ_F, for example at γ_F = r² and v = 0, rounding errors would start and stop the mass
    endlessly without this margin. `force_most` is the largest excitation of the mass.
    """
    return friction_ratio + _ROUNDING * (friction_ratio + force_most)


@inlined
def slip_direction(force: float, breakaway_force: float) -> float:
    """Direction in which a mass at rest on the base starts to slip; 0.0 if friction holds the mass."""
    if force > breakaway_force:
        return 1.0
    if force < -breakaway_force:
        return -1.0
    return 0.0
