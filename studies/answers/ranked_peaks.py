"""Which peaks of a ranking may lie between the frequencies."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from damperlab.studies.answers.design_question import DesignQuestion
from damperlab.studies.answers.hidden_peak import advised_axis, hidden_of, say_hidden
from damperlab.studies.answers.phrases import Phrases

MOST_PEAKS = 10
"""Designs at the head of a ranking whose peaks are asked about: as many as are listed where nobody says."""


@dataclass(frozen=True)
class RankedPeaks:
    """Where the peaks of a ranking may lie between the frequencies.

    Parameters
    ----------
    listed : int
        How many of the first designs were asked about; behind them may stand the best with impacts.
    r, where, damping_ratio : ndarray
        Of `say_hidden`.
    """

    listed: int
    r: NDArray[np.float64]
    where: NDArray[np.bool_]
    damping_ratio: NDArray[np.float64]

    @classmethod
    def of(
        cls,
        cube: xr.Dataset,
        question: DesignQuestion,
        ranked: xr.Dataset,
        active: Mapping[str, Any] | None = None,
        homes: Mapping[str, xr.Dataset] | None = None,
    ) -> "RankedPeaks":
        """Ask the first designs of a ranking, and the best with impacts."""
        r = question.frequencies
        listed = min(question.top, ranked.sizes["rank"], MOST_PEAKS) if question.objective == "peak" else 0
        names = [*question.design, *(["study"] if homes else [])]
        designs = [
            {name: ranked[name].values[rank].item() for name in names}
            for rank in range(listed if r.size > 1 else 0)
        ]
        if designs and active is not None and homes is None:
            acting = {name: active[name] for name in question.design}
            designs += [] if acting in designs else [acting]
        where = [hidden_of(homes[each["study"]] if homes else cube, r, each) for each in designs]
        zeta = np.array([each["damping_ratio"] for each in designs])
        return cls(listed, r, np.array(where, np.bool_).reshape(len(designs), r.size - 1), zeta)

    def axis(self, phrases: Phrases) -> str:
        """Write the frequencies that would show them; only where some hide."""
        return advised_axis(self.r, 2.0 * float(self.damping_ratio[self.where.any(axis=1)].min()), phrases)

    def say(self, phrases: Phrases, noun: str = "design") -> str:
        """Say whose peaks they are, and what to compute; nothing where none hides."""
        hides = np.asarray(self.where.any(axis=1))
        count = int(hides[: self.listed].sum())
        whose = []
        if count == 1 and hides[0]:
            whose.append(f"the largest value of the best {noun}")
        elif count:
            among = f", the best {noun} among them," if hides[0] else ""
            values = "value" if count == 1 else "values"
            whose.append(f"the largest {values} of {count} of the first {self.listed} {noun}s{among}")
        if hides[self.listed :].any():
            whose.append(
                f"that of the best {noun} with impacts"
                if whose
                else f"the largest value of the best {noun} with impacts"
            )
        words = " and ".join(whose)
        return say_hidden(f"{words[:1].upper()}{words[1:]}", self.r, self.where, self.damping_ratio, phrases)
