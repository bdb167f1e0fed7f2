"""Criteria for tuning a mass damper, by name: what each one minimises, for which structure, and its closed form, if
any.
"""

import math

from damperlab.studies.tmd.absorber import Absorber
from damperlab.studies.tmd.minimax import minimax
from damperlab.studies.vocabulary import Criterion, Excitation


def den_hartog(mass_ratio: float) -> Absorber:
    """Den Hartog's optimum, (14) and (15): equal heights at the fixed points of an undamped structure.

    ζ = √(3μ/(8(1+μ))) over the absorber's own frequency. Over the structure's it is √(3μ/(8(1+μ)³)), the 0.1679
    of the paper's Table 4 for μ = 0.1: the same dashpot.
    """
    return Absorber(mass_ratio, 1 / (1 + mass_ratio), math.sqrt(3 * mass_ratio / (8 * (1 + mass_ratio))))


def den_hartog_table4(mass_ratio: float) -> Absorber:
    """Table 4's damping put into (13) unconverted: a dashpot (1 + μ) times too weak."""
    right = den_hartog(mass_ratio)
    return Absorber(mass_ratio, right.tuning, right.damping_over_structure)


def exact_hinf(mass_ratio: float) -> Absorber:
    """Exact H∞ optimum of an undamped structure, base or force excited.

    O. Nishihara, T. Asami, Closed-form solutions to the exact optimizations of dynamic vibration absorbers,
    J. Vib. Acoust. 124 (2002) 576.
    """
    mu = mass_ratio
    root = math.sqrt(4 + 3 * mu)
    tuning = 16 + 23 * mu + 9 * mu**2 + 2 * (2 + mu) * root
    tuning = 2 / (1 + mu) * math.sqrt(2 * tuning / (3 * (64 + 80 * mu + 27 * mu**2)))
    # 8 + 9μ − 4√(4 + 3μ), written without the cancellation that small μ would suffer
    excess = mu * (96 + 81 * mu) / (8 + 9 * mu + 4 * root)
    return Absorber(mu, tuning, math.sqrt(excess / (1 + mu)) / 4)


MOST_UNDER_BASE = 2.0
"""Mass ratio above which no spring of an absorber is optimal under a base acceleration: the softer, the better."""


def h2(mass_ratio: float, excitation: Excitation = "base") -> Absorber:
    """Least mean square displacement of an undamped structure under white noise.

    Under a force, the displacement is that of the structure; ∫|X/Z|² dω for a base displacement has the same optimum.
    Under an acceleration of the base, it is the displacement against the base, and μ must be below `MOST_UNDER_BASE`.

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
        One of `vocabulary.CRITERIA`. Only "minimax" uses the structure's damping; it and "h2" use the excitation.
    mass_ratio : float
        μ > 0.
    structural_damping, excitation
        Of the structure, see `transfer.amplitude_ratio`.
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
