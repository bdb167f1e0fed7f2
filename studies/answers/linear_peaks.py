"""What a damper is compared with over a band: the peaks of a tuned mass damper, and of the structure alone."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import isfinite, isnan, nan

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.answers.comparing import clearly_less
from damperlab.studies.brief import Note
from damperlab.studies.tmd.transfer import highest, without_absorber
from damperlab.studies.tmd.tunings import tuned
from damperlab.studies.vocabulary import Excitation

UNBOUNDED = "grows without bound"
"""Text for an infinite peak."""


@dataclass(frozen=True)
class LinearPeaks:
    """The two peaks, in the unit of the compared value.

    Parameters
    ----------
    tuned, bare : float
        With a tuned mass damper and without any damper; NaN if the study has no such peak.
    mass_ratio : float
        Of the tuned mass damper.
    """

    tuned: float = nan
    bare: float = nan
    mass_ratio: float = nan

    @classmethod
    def over(
        cls,
        r: NDArray[np.float64],
        damping_ratios: Sequence[float],
        mass_ratio: float,
        excitation: Excitation,
        scale: float = 1.0,
    ) -> "LinearPeaks":
        """Compute the largest peaks over structures of several damping ratios.

        Parameters
        ----------
        r : ndarray, (n,)
            Frequency ratios, rising; the band reaches from the first to the last. A single one gives no peaks.
        damping_ratios : sequence of float
            Of the structures.
        mass_ratio : float
            Of the tuned mass damper, which has the least peak over all frequencies for the least damped structure.
            There is none for 0, and for 1 and more.
        excitation : str
            What moves the structures.
        scale : float
            Factor from an amplitude ratio to the compared value.
        """
        if r.size == 1:
            return cls()
        at = np.unique(np.append(r, np.clip(1.0, r[0], r[-1])))
        bare = max(float(without_absorber(at, zeta, excitation).max()) for zeta in damping_ratios)
        if not 0 < mass_ratio < 1:
            return cls(bare=bare * scale)
        absorber = tuned("minimax", mass_ratio, min(damping_ratios), excitation)
        band = float(r[0]), float(r[-1])
        peak = max(highest(absorber, zeta, excitation, band).value for zeta in damping_ratios)
        return cls(peak * scale, bare * scale, mass_ratio)

    def beats(self, value: float) -> bool:
        """Whether the tuned mass damper is clearly better than a value."""
        return clearly_less(self.tuned, value)

    def note(self) -> Note:
        """Give as data that the tuned mass damper is better."""
        return Note("tuned_mass_damper", "danger", {"value": self.tuned, "mass_ratio": self.mass_ratio})

    def rows(
        self, write: Callable[[float], str], write_mass: Callable[[float], str], beaten: bool
    ) -> list[tuple[str, str, str]]:
        """Give the rows of a short answer; a tuned mass damper that has beaten the study's damper is named elsewhere."""
        found = []
        if not (beaten or isnan(self.tuned)):
            found.append(("tuned mass damper", write(self.tuned), write_mass(self.mass_ratio)))
        if not isnan(self.bare):
            found.append(("without damper", write(self.bare) if isfinite(self.bare) else UNBOUNDED, ""))
        return found
