"""Time histories of a structure with each damper of a comparison under one record."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from damperlab.service.motions import drift_spectrum
from damperlab.studies.ground.question import Earthquake
from damperlab.worker.ground.absorber import absorber_history
from damperlab.worker.ground.comparison import absorber_of, damper_of, scenes_of, structure_of
from damperlab.worker.ground.response import ground_history
from damperlab.worker.scenes import Scene


def histories_of(asked: Earthquake) -> dict[str, dict[str, NDArray[np.float64]]]:
    """Compute `time_s`, `relative_displacement_m` and the other columns of the motion with each damper, by its case."""
    structure, absorber = structure_of(asked), absorber_of(asked)
    factor, tail = asked.values["scale"], asked.values["tail_s"]
    histories = {}
    for case in asked.cases:
        if case == "tmd":
            histories[case] = absorber_history(structure, absorber, asked.motion, factor, tail)
        else:
            histories[case] = ground_history(structure, damper_of(asked, case), asked.motion, factor, tail)[1]
    return histories


def history_scenes(asked: Earthquake) -> list[Scene]:
    """Scenes that these histories need."""
    return [scene._replace(purpose="record-history") for scene in scenes_of(asked)]


def sampled(asked: Earthquake, most: int) -> dict[str, dict[str, Any]]:
    """Give the histories with at most `most` samples each.

    Parameters
    ----------
    asked : Earthquake
        The comparison.
    most : int
        Largest number of samples of a case, at least 2. If there are more, evenly spaced ones are given, together with
        those of the largest and the smallest displacement against the base, so that peaks stay.

    Returns
    -------
    dict
        For each case the columns, with the names of `ground_history`. ``thinned`` says whether some were left out, and
        ``spectrum`` is the displacement against the base over frequency.
    """
    found: dict[str, dict[str, Any]] = {}
    natural = asked.values["natural_frequency_hz"]
    for case, columns in histories_of(asked).items():
        count = columns["time_s"].size
        rows = np.arange(count)
        if count > most:
            x = columns["relative_displacement_m"]
            even = np.linspace(0, count - 1, max(2, most - 2)).astype(int)
            rows = np.unique([*even, int(x.argmax()), int(x.argmin())])
        found[case] = {name: column[rows] for name, column in columns.items()}
        found[case] |= {"thinned": count > most, "spectrum": drift_spectrum(columns, natural)}
    return found
