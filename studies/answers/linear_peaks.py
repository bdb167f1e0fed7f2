"""Peaks over a band with a tuned mass damper and without any damper, for comparison with a study's damper."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import isfinite, isnan, nan

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.answers.comparing import clearly_less
from damperlab.studies.brief import Note
from damperlab.studies.tmd.transfer import amplitude_ratio, highest, without_absorber
from damperlab.studies.tmd.tunings import tuned
from damperlab.studies.vocabulary import Excitation

STEPS = 4001
"""Number of frequencies at which the response with a tuned mass damper is computed where its peak has no closed form."""
UNBOUNDED = "grows without bound"
"""Text that replaces an infinite peak."""


@dataclass(frozen=True)
class LinearPeaks:
    """Peaks with a tuned mass damper and without any damper, in the unit of the compared value.

    Parameters
    ----------
    tuned, bare : float
        Peak with a tuned mass damper, and peak without any damper; NaN if the peak was not computed.
    mass_ratio : float
        Mass ratio of the tuned mass damper.
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
        order: int = 0,
    ) -> "LinearPeaks":
        """Compute both peaks for structures with different damping ratios, and return the largest of each.

        Parameters
        ----------
        r : ndarray, (n,)
            Ascending frequency ratios. The band extends from the first to the last frequency ratio. For a
            single frequency ratio, no peaks are computed.
        damping_ratios : sequence of float
            Damping ratios of the structures.
        mass_ratio : float
            Mass ratio of the tuned mass damper. The damper is tuned for the smallest peak over all frequencies on the
            least damped structure. The peak is computed only for a mass ratio above 0 and below 1.
        excitation : str
            Excitation of the structures.
        scale : float
            Factor that converts an amplitude ratio at r = 1 to the compared value.
        order : int
            Power of 1/r with which the base amplitude falls: 1 or 2 if its velocity or acceleration is constant.
        """
        if r.size == 1:
            return cls()
        at = np.unique(np.append(r, np.clip(1.0, r[0], r[-1])))
        falls = at**-order
        bare = max(float((falls * without_absorber(at, zeta, excitation)).max()) for zeta in damping_ratios)
        if not 0 < mass_ratio < 1:
            return cls(bare=bare * scale)
        absorber = tuned("minimax", mass_ratio, min(damping_ratios), excitation)
        band = float(r[0]), float(r[-1])
        if order:  # no closed form: the steps are far smaller than the bandwidth of an absorber
            at = np.linspace(*band, STEPS)
            curves = (amplitude_ratio(at, absorber, zeta, excitation) for zeta in damping_ratios)
            return cls(
                max(float((at**-order * each).max()) for each in curves) * scale, bare * scale, mass_ratio
            )
        peak = max(highest(absorber, zeta, excitation, band).value for zeta in damping_ratios)
        return cls(peak * scale, bare * scale, mass_ratio)

    def beats(self, value: float) -> bool:
        """Whether the peak with the tuned mass damper is clearly smaller than `value`."""
        return clearly_less(self.tuned, value)

    def note(self) -> Note:
        """Return the note that the tuned mass damper is better."""
        return Note("tuned_mass_damper", "danger", {"value": self.tuned, "mass_ratio": self.mass_ratio})

    def rows(
        self, write: Callable[[float], str], write_mass: Callable[[float], str], beaten: bool
    ) -> list[tuple[str, str, str]]:
        """Return the rows of a short answer.

        If `beaten` is True, the tuned mass damper has no row, because a sentence of the answer names
        this damper.
        """
        found = []
        if not (beaten or isnan(self.tuned)):
            found.append(("tuned mass damper", write(self.tuned), write_mass(self.mass_ratio)))
        if not isnan(self.bare):
            found.append(("without damper", write(self.bare) if isfinite(self.bare) else UNBOUNDED, ""))
        return found
