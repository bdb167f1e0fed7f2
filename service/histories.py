"""Time histories of a structure under a ground-motion record, for each damper of a comparison."""

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
    """Compute the time history for each case of a comparison.

    Returns
    -------
    dict of dict of ndarray
        Columns of each case by name, for example `time_s` and `relative_displacement_m`.
    """
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
    """Return the scenes that the time histories of a comparison need."""
    return [scene._replace(purpose="record-history") for scene in scenes_of(asked)]


def sampled(asked: Earthquake, most: int) -> dict[str, dict[str, Any]]:
    """Compute the time histories of a comparison, and reduce the number of samples.

    Parameters
    ----------
    asked : Earthquake
        The comparison.
    most : int
        Largest number of samples of a case, at least 2. A longer history is reduced to evenly spaced samples.
        The samples with the largest and the smallest displacement relative to the base are always kept.

    Returns
    -------
    dict
        For each case, the columns of `ground_history` by name, and two further entries. ``thinned`` tells whether
        samples were left out, and ``spectrum`` is the spectrum of the displacement relative to the base.
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
