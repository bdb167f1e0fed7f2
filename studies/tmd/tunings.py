"""Optimal tunings of a mass damper, in closed form where one exists."""

import math

from damperlab.studies.tmd.absorber import Absorber
from damperlab.studies.tmd.minimax import minimax
from damperlab.studies.vocabulary import Criterion, Excitation


def den_hartog(mass_ratio: float) -> Absorber:
    """Return Den Hartog's optimum, (14) and (15): equal heights at the fixed points of an undamped structure.

    The damping ratio of the absorber alone is ζ = √(3μ/(8(1+μ))). With the natural frequency of the structure, the
    damping ratio is √(3μ/(8(1+μ)³)), which for μ = 0.1 is the 0.1679 of the paper's Table 4.
    """
    return Absorber(mass_ratio, 1 / (1 + mass_ratio), math.sqrt(3 * mass_ratio / (8 * (1 + mass_ratio))))


def den_hartog_table4(mass_ratio: float) -> Absorber:
    """Return Den Hartog's tuning with the damping ratio of Table 4.

    Table 4 gives ζ′ = c/(2 m ω_n). Here ζ′ is used as ζ in equation (13), so the dashpot is too weak by the
    factor 1 + μ.
    """
    right = den_hartog(mass_ratio)
    return Absorber(mass_ratio, right.tuning, right.damping_over_structure)


def exact_hinf(mass_ratio: float) -> Absorber:
    """Return the exact H∞ optimum for an undamped structure, under base or force excitation.

    O. Nishihara, T. Asami, Closed-form solutions to the exact optimizations of dynamic vibration absorbers,
    J. Vib. Acoust. 124 (2002) 576.
    """
    mu = mass_ratio
    root = math.sqrt(4 + 3 * mu)
    tuning = 16 + 23 * mu + 9 * mu**2 + 2 * (2 + mu) * root
    tuning = 2 / (1 + mu) * math.sqrt(2 * tuning / (3 * (64 + 80 * mu + 27 * mu**2)))
    # 8 + 9μ − 4√(4 + 3μ), rearranged to avoid cancellation at small μ
    excess = mu * (96 + 81 * mu) / (8 + 9 * mu + 4 * root)
    return Absorber(mu, tuning, math.sqrt(excess / (1 + mu)) / 4)


MOST_UNDER_BASE = 2.0
"""Mass ratio from which, under a base acceleration, a softer spring of the absorber is always better."""


def h2(mass_ratio: float, excitation: Excitation) -> Absorber:
    """Return the optimum for the least mean square displacement of an undamped structure under white noise.

    Under a force, the absolute displacement of the structure is minimised, which also minimises ∫|X/Z|² dω for a base
    displacement. Under an acceleration of the base, the displacement relative to the base is minimised, and μ must be
    below `MOST_UNDER_BASE`.

    G. B. Warburton, Optimum absorber parameters for various combinations of response and excitation
    parameters, Earthquake Eng. Struct. Dyn. 10 (1982) 381.
    """
    mu = mass_ratio
    if excitation == "base":
        tuning = math.sqrt((2 - mu) / 2) / (1 + mu)
        return Absorber(mu, tuning, math.sqrt(mu * (4 - mu) / (8 * (1 + mu) * (2 - mu))))
    tuning = math.sqrt((2 + mu) / 2) / (1 + mu)
    return Absorber(mu, tuning, math.sqrt(mu * (4 + 3 * mu) / (8 * (1 + mu) * (2 + mu))))


def tuned(
    criterion: Criterion, mass_ratio: float, structural_damping: float = 0.0, excitation: Excitation = "base"
) -> Absorber:
    """Tune an absorber of a given mass.

    Parameters
    ----------
    criterion : str
        One of `vocabulary.CRITERIA`. Only "minimax" uses the damping of the structure. Only "minimax" and "h2" use the
        excitation.
    mass_ratio : float
        μ > 0.
    structural_damping, excitation
        Damping ratio and excitation of the structure, see `transfer.amplitude_ratio`.
    """
    match criterion:
        case "den_hartog":
            return den_hartog(mass_ratio)
        case "den_hartog_table4":
            return den_hartog_table4(mass_ratio)
        case "hinf":
            return exact_hinf(mass_ratio)
        case "h2":
            return h2(mass_ratio, excitation)
        case "minimax":
            return minimax(mass_ratio, structural_damping, excitation)
