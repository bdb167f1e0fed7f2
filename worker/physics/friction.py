"""Coulomb friction between the primary mass and the base: set-valued at rest, Sgn(0) = [−1, 1] in equation (1)."""

from worker.jit import kernel


@kernel
def hold_force(v, base_acceleration, inertia):
    """Force that friction must take to keep the mass on the base, over k Z.

    Parameters
    ----------
    v : float
        Displacement relative to the base [Z].
    base_acceleration : float
        −s'' = r² sin φ [Z ω_n²].
    inertia : float
        1 for the primary mass alone, 1 + β with the particle attached.

    Returns
    -------
    float
        F = inertia · r² sin φ − v; the mass sticks while |F| ≤ γ_F and slips towards sign(F) otherwise.
    """
    return inertia * base_acceleration - v


@kernel
def slip_direction(force, friction_ratio):
    """Direction in which a mass at rest on the base starts to slip: 0.0 where friction holds it (|F| ≤ γ_F)."""
    if force > friction_ratio:
        return 1.0
    if force < -friction_ratio:
        return -1.0
    return 0.0
