"""A compliant wall: a spring and a dashpot in parallel that push but never pull.

The force of the wall is max(0, K pen + C pen') while the particle penetrates the wall by pen > 0, and 0 otherwise.
After an impact in free space with pen' = v, the force falls to 0 at the end of the contact time, and the bodies
separate with speed e v. The energy that remains in the spring is lost. Let T be the contact time, ζ_c the damping ratio
of the reduced mass on the wall, and θ = acos ζ_c. Then ln e = −2 θ cot θ and ω_c = 2θ/(T sin θ). For an overdamped
wall, hyperbolic functions replace the trigonometric functions.
"""

from math import cos, cosh, inf, log, pi, sin, sinh, tan, tanh

from damperlab.worker.jit import kernel

# Largest number of bisections; the search ends earlier if the bounds are neighbouring floating-point numbers.
_BISECTIONS = 200


@kernel
def reduced_mass(mass_ratio: float) -> float:
    """Reduced mass of particle and primary mass, divided by M: β/(1 + β)."""
    return mass_ratio / (1.0 + mass_ratio)


@kernel
def calibrate(restitution: float, contact_time: float) -> tuple[float, float]:
    """Return the natural frequency and the damping ratio of the reduced mass on a wall.

    Parameters
    ----------
    restitution : float
        e in (0, 1]. The damping is 0 for e = 1 and grows as e falls towards 0 (ζ_c ≈ 1/(2√e)).
    contact_time : float
        Contact time of an impact in free space [1/ω_n].

    Returns
    -------
    rate, damping : float
        Natural frequency ω_c [ω_n] and damping ratio ζ_c.
    """
    half = -0.5 * log(restitution)
    if half <= 0.0:
        return pi / contact_time, 0.0
    # `half` = θ cot θ falls from 1 to 0 over (0, π/2]; for an overdamped wall, `half` = b coth b rises from 1
    stiff = half <= 1.0
    low = 0.0
    high = 0.5 * pi if stiff else half
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        if stiff:
            if middle / tan(middle) > half:
                low = middle
            else:
                high = middle
        elif middle / tanh(middle) < half:
            low = middle
        else:
            high = middle
    angle = high
    if angle < 1e-9:
        return 2.0 / contact_time, 1.0
    if stiff:
        return 2.0 * angle / (contact_time * sin(angle)), cos(angle)
    return 2.0 * angle / (contact_time * sinh(angle)), cosh(angle)


@kernel
def wall_constants(restitution: float, contact_time: float, mass_ratio: float) -> tuple[float, float]:
    """Return stiffness K/k and damping C ω_n/k of a wall with a given e and contact time."""
    rate, damping = calibrate(restitution, contact_time)
    mass = reduced_mass(mass_ratio)
    return mass * rate * rate, 2.0 * mass * damping * rate


@kernel
def contact_time_of_stiffness(restitution: float, stiffness: float, mass_ratio: float) -> float:
    """Return the contact time [1/ω_n] of a wall with a given e and stiffness K/k; inf for a stiffness of 0."""
    if stiffness <= 0.0:
        return inf
    unit, _ = calibrate(restitution, 1.0)
    root: float = (reduced_mass(mass_ratio) / stiffness) ** 0.5
    return unit * root


@kernel
def wall_force(stiffness: float, damping: float, depth: float, depth_rate: float) -> float:
    """Force of the wall on a particle at penetration `depth`, divided by k Z. The wall never pulls."""
    if depth <= 0.0:
        return 0.0
    return max(stiffness * depth + damping * depth_rate, 0.0)


@kernel
def spring_energy(stiffness: float, depth: float) -> float:
    """Energy of the wall's spring, divided by k Z²; 0 for a particle outside the wall."""
    return 0.5 * stiffness * max(depth, 0.0) ** 2
