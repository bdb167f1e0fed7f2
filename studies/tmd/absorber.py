"""A tuned mass damper as data."""

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Absorber:
    """A tuned mass damper.

    Parameters
    ----------
    mass_ratio : float
        μ = m/M, absorber over primary mass.
    tuning : float
        γ = ω_a/ω_n, natural frequency of the absorber alone over that of the structure alone.
    damping_ratio : float
        ζ = c/(2√(m k₁)), over the absorber's own natural frequency: equations (13) and (15).
    """

    mass_ratio: float
    tuning: float
    damping_ratio: float

    @property
    def damping_over_structure(self) -> float:
        """ζ′ = c/(2 m ω_n) = ζγ, over the structure's natural frequency, as in Table 4."""
        return self.damping_ratio * self.tuning

    def detuned(self, frequency: float = 0.0, damping: float = 0.0) -> "Absorber":
        """Give the absorber with relative deviations of its frequency and its ζ; 0.05 is five per cent too high."""
        return replace(
            self, tuning=self.tuning * (1 + frequency), damping_ratio=self.damping_ratio * (1 + damping)
        )


NO_DAMPER = Absorber(0.0, 1.0, 1.0)
"""An absorber without mass."""
