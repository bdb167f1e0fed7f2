"""Transfer function (13), Den Hartog's optimum and the exact H-infinity optimum of a tuned mass damper.

The mass ratio is mu = m/M, the tuning omega_a/omega_n, and the damping ratio zeta = c/(2 sqrt(m k_1)). The base excites
the primary mass, which is undamped unless a structural damping ratio is given.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import minimize, minimize_scalar  # type: ignore[import-untyped]


def amplitude_ratio(
    r: np.ndarray | float, mu: float, tuning: float, zeta: float, structural: float = 0.0
) -> np.ndarray:
    """Return X/Z at frequency ratio r, the complex solution of the two equations of motion.

    (1 - r^2 + 2i zs r) x - r^2 mu y = (1 + 2i zs r) z, with the structural damping ratio zs, the tuning g and the
    damper's motion y = x (g^2 + 2i zeta g r)/(g^2 - r^2 + 2i zeta g r). Equation (13) of the paper is the case zs = 0.
    """
    lam = np.asarray(r, dtype=float)
    link = tuning**2 + 2j * zeta * tuning * lam
    base = 1 + 2j * structural * lam
    return np.asarray(np.abs(base / (base - lam**2 - mu * lam**2 * link / (link - lam**2))))


def equation_13(r: np.ndarray | float, mu: float, tuning: float, zeta: float) -> np.ndarray:
    """Return X/Z of an undamped primary mass as in equation (13) of the paper."""
    lam = np.asarray(r, dtype=float)
    spring, dash = tuning**2 - lam**2, 2 * tuning * lam * zeta
    top = spring**2 + dash**2
    bottom = ((1 - lam**2) * spring - mu * tuning**2 * lam**2) ** 2 + (dash * (1 - lam**2 - mu * lam**2)) ** 2
    return np.asarray(np.sqrt(top / bottom))


def den_hartog(mu: float) -> tuple[float, float]:
    """Return tuning and damping of the fixed-point optimum from equations (14) and (15)."""
    return 1 / (1 + mu), math.sqrt(3 * mu / (8 * (1 + mu)))


def exact_optimum(mu: float) -> tuple[float, float, float]:
    """Return tuning, damping and peak X/Z of the exact H-infinity optimum of an undamped primary mass.

    O. Nishihara and T. Asami, Closed-form solutions to the exact optimizations of dynamic vibration
    absorbers, J. Vib. Acoust. 124 (2002). With q = sqrt(4 + 3 mu):
    tuning = 2/(1+mu) sqrt{2 [16 + 23 mu + 9 mu^2 + 2 (2 + mu) q] / (3 (64 + 80 mu + 27 mu^2))},
    zeta = 1/4 sqrt{(8 + 9 mu - 4 q)/(1 + mu)},
    peak = 1/(3 mu) sqrt{[(8 + 9 mu)^2 (16 + 9 mu) - 128 q^3]/[3 (32 + 27 mu)]}.
    """
    q = math.sqrt(4 + 3 * mu)
    inner = 2 * (16 + 23 * mu + 9 * mu**2 + 2 * (2 + mu) * q) / (3 * (64 + 80 * mu + 27 * mu**2))
    peak = ((8 + 9 * mu) ** 2 * (16 + 9 * mu) - 128 * q**3) / (3 * (32 + 27 * mu))
    return (
        2 / (1 + mu) * math.sqrt(inner),
        math.sqrt((8 + 9 * mu - 4 * q) / (1 + mu)) / 4,
        math.sqrt(peak) / (3 * mu),
    )


def peak(mu: float, tuning: float, zeta: float, structural: float = 0.0) -> float:
    """Return max X/Z over r in (0, 2.5]: every maximum of a dense scan is refined by golden section."""

    def height(r: np.ndarray | float) -> np.ndarray:
        return amplitude_ratio(r, mu, tuning, zeta, structural)

    r = np.linspace(1e-3, 2.5, 2501)
    y = height(r)
    tops = np.flatnonzero((y[1:-1] >= y[:-2]) & (y[1:-1] >= y[2:])) + 1
    best = 0.0
    for top in tops:
        found = minimize_scalar(
            lambda x: -float(height(x)), bracket=(r[top - 1], r[top], r[top + 1]), method="golden", tol=1e-9
        )
        best = max(best, -float(found.fun))
    return best


def minimax(mu: float, structural: float = 0.0) -> tuple[float, float, float]:
    """Return the tuning and damping with the smallest peak X/Z, and this peak (Nelder-Mead from `den_hartog`)."""
    found = minimize(
        lambda x: peak(mu, x[0], abs(x[1]), structural),
        den_hartog(mu),
        method="Nelder-Mead",
        options={"xatol": 1e-9, "fatol": 1e-12, "maxiter": 2000},
    )
    return float(found.x[0]), abs(float(found.x[1])), float(found.fun)
