"""Whether fits of time histories give back the parameters of made-up prototypes within their intervals: `run` counts."""

import sys
from typing import Any

import numpy as np
from tests.synthetic_history import RANGES, made_history

from damperlab.studies.faults import StudyFaults
from damperlab.worker.fit.history.estimate import fit_history

SETS = 24


def run() -> dict[str, Any]:
    """Fit seeded histories of every kind; of 20 intervals of 95 % one is expected to miss."""
    found: dict[str, Any] = {}
    for kind in RANGES:
        for shaken in (False, True):
            held, refused, missed, stretches = 0, 0, [], []
            widths: dict[str, list[float]] = {}
            for seed in range(SETS):
                one = made_history(kind, seed, shaken=shaken)
                try:
                    fitted = fit_history(one.question)
                except StudyFaults:
                    refused += 1
                    continue
                stretches.append(fitted.stretch_s)
                for each in fitted.estimates:
                    true, width = one.truth[each.name], each.high - each.low
                    widths.setdefault(each.name, []).append(width / true)
                    if each.low <= true <= each.high:
                        held += 1
                    else:
                        off = max(each.low - true, true - each.high) / max(width, 1e-300)
                        missed.append(f"{seed} {each.name} by {off:.2g} of its width")
            label = f"{kind}, {'shaken' if shaken else 'released'}"
            print(label, held, len(missed), refused, file=sys.stderr, flush=True)
            found[f"{label}: intervals that hold, of {held + len(missed)}"] = held
            found[f"{label}: histories refused, of {SETS}"] = refused
            found[f"{label}: median stretch [s]"] = float(np.median(stretches))
            for name, every in widths.items():
                found[f"{label}: median width of the interval of {name} over its value"] = float(
                    np.median(every)
                )
            found[f"{label}: missed"] = missed
    return found
