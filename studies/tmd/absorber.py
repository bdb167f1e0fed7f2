"""Parameters of a tuned mass damper."""

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Absorber:
    """A tuned mass damper.

    Parameters
    ----------
    mass_ratio : float
        μ = m/M, mass of the absorber divided by the primary mass.
    tuning : float
        γ = ω_a/ω_n, natural frequency of the absorber alone divided by the natural frequency of the structure alone.
    damping_ratio : float
        ζ = c/(2√(m k₁)), the damping ratio of the absorber alone, as in equations (13) and (15).
    """

    mass_ratio: float
    tuning: float
    damping_ratio: float

    @property
    def damping_over_structure(self) -> float:
        """Damping ratio relative to the structure's natural frequency, ζ′ = c/(2 m ω_n) = ζγ, as in Table 4."""
        return self.damping_ratio * self.tuning

    def detuned(self, frequency: float = 0.0, damping: float = 0.0) -> "Absorber":
        """Return the absorber with γ multiplied by 1 + `frequency`, and ζ multiplied by 1 + `damping`."""
        return replace(
            self, tuning=self.tuning * (1 + frequency), damping_ratio=self.damping_ratio * (1 + damping)
        )


NO_DAMPER = Absorber(0.0, 1.0, 1.0)
"""An absorber without mass."""
