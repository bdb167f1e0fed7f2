"""Which peaks of a ranking may lie between the frequencies."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from damperlab.studies.answers.design_question import DesignQuestion
from damperlab.studies.answers.hidden_peak import hidden_note, hidden_of
from damperlab.studies.brief import Note

MOST_PEAKS = 10
"""Designs at the head of a ranking whose peaks are asked about: as many as are listed where nobody says."""


def hidden_peaks(
    cube: xr.Dataset,
    question: DesignQuestion,
    ranked: xr.Dataset,
    active: Mapping[str, Any] | None = None,
    homes: Mapping[str, xr.Dataset] | None = None,
) -> list[Note]:
    """Ask the first designs of a ranking, and the best with impacts; note where the peaks of some may hide."""
    r = question.frequencies
    listed = min(question.top, ranked.sizes["rank"], MOST_PEAKS)
    if question.objective != "peak" or r.size == 1 or not listed:
        return []
    names = [*question.design, *(["study"] if homes else [])]
    designs = [{name: ranked[name].values[rank].item() for name in names} for rank in range(listed)]
    if active is not None and homes is None:
        acting = {name: active[name] for name in question.design}
        designs += [] if acting in designs else [acting]
    where = np.array([hidden_of(homes[each["study"]] if homes else cube, r, each) for each in designs])
    zeta = np.array([each["damping_ratio"] for each in designs])
    return hidden_note(r, where, zeta, whose([bool(each.any()) for each in where], listed))


def whose(hides: Sequence[bool], listed: int) -> dict[str, Any]:
    """Say which of the designs they are: of the first ones that are listed, and the best with impacts behind them."""
    return {
        "designs": sum(hides),
        "listed": sum(hides[:listed]),
        "of": listed,
        "best": hides[0],
        "with_impacts": any(hides[listed:]),
    }
