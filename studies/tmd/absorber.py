"""A tuned mass damper as data, and the two ways in which its damping is quoted."""

from dataclasses import dataclass, replace

CONVENTIONS: dict[str, str] = {
    "own_frequency": "ζ = c/(2√(m k₁)), over the absorber's own natural frequency; equations (13) and (15)",
    "structure_frequency": "ζ′ = c/(2 m ω_n) = ζ·ω_a/ω_n, over the structure's natural frequency; Table 4",
}
"""What a damping ratio of an absorber is a ratio to."""


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
        ζ = c/(2√(m k₁)), the convention "own_frequency".
    """

    mass_ratio: float
    tuning: float
    damping_ratio: float

    @classmethod
    def quoted(cls, mass_ratio: float, tuning: float, damping_ratio: float, convention: str) -> "Absorber":
        """Make an absorber whose damping ratio is quoted in one of `CONVENTIONS`.

        Raises
        ------
        KeyError
            If there is no such convention.
        """
        over = {"own_frequency": 1.0, "structure_frequency": tuning}[convention]
        return cls(mass_ratio, tuning, damping_ratio / over)

    @property
    def damping_over_structure(self) -> float:
        """ζ′ = c/(2 m ω_n), the convention "structure_frequency"."""
        return self.damping_ratio * self.tuning

    def detuned(self, frequency: float = 0.0, damping: float = 0.0) -> "Absorber":
        """Give the absorber with its frequency and its ζ off by these shares; 0.05 is five per cent too high."""
        return replace(
            self, tuning=self.tuning * (1 + frequency), damping_ratio=self.damping_ratio * (1 + damping)
        )


NO_DAMPER = Absorber(0.0, 1.0, 1.0)
"""One without mass."""
