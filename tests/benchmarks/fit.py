"""Whether fits give back the parameters of made-up prototypes within their stated intervals: `run` counts how often."""

import sys
from typing import Any

import numpy as np
from tests.synthetic import RANGES, made

from damperlab.worker.fit.estimate import fit_response

SETS = {"friction": 40, "particle": 40, "hybrid": 40}


def run() -> dict[str, Any]:
    """Fit seeded data sets of every kind; of 40 intervals of 95 % two are expected to miss."""
    found: dict[str, Any] = {}
    for kind, sets in SETS.items():
        held = dict.fromkeys(RANGES[kind], 0)
        missed, widths, chi = [], {name: [] for name in held}, []
        for seed in range(sets):
            one = made(kind, seed)
            fitted = fit_response(one.question)
            chi.append(fitted.chi_square / fitted.freedom)
            for each in fitted.estimates:
                true = one.truth[each.name]
                widths[each.name].append((each.high - each.low) / true)
                if each.low <= true <= each.high:
                    held[each.name] += 1
                else:
                    missed.append(f"{seed} {each.name} {true:.4g} not in {each.low:.4g} to {each.high:.4g}")
            print(kind, seed, fitted.evaluations, held, missed[-1:], file=sys.stderr, flush=True)
        for name, number in held.items():
            found[f"{kind}, intervals of {name} that hold, of {sets}"] = number
            found[f"{kind}, median width of the interval of {name} over its value"] = float(
                np.median(widths[name])
            )
        found[f"{kind}, mean of chi-square over its degrees of freedom"] = float(np.mean(chi))
        found[f"{kind}, missed"] = missed
    return found
