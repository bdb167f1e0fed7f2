"""Reduce values and accompanying variables, such as errors and status, along one dimension, slab by slab."""

from collections.abc import Mapping

import numpy as np

from damperlab.studies.variables import ResponseClass, Status


class Extremum:
    """The largest value (sign 1) or the smallest value (sign −1) along the first axis, with accompanying variables.

    If a point failed, the largest value is unknown, because the response at this point may be unbounded. For
    an unknown largest value, the accompanying variables are taken at the failed point. The smallest value is
    taken over the points that have a value. If several points have the same value, a point at which the mass
    moves is preferred.
    """

    def __init__(self, sign: float) -> None:
        self._sign = sign
        self._best: dict[str, np.ndarray] = {}

    def take(self, start: int, values: np.ndarray, beside: Mapping[str, np.ndarray]) -> None:
        """Process one slab whose first index along the axis is `start`."""
        ranked = np.where(np.isnan(values), -np.inf, self._sign * values)
        if self._sign > 0.0:
            ranked[beside["status"] > Status.MAX_CYCLES] = np.inf
        first = ranked.argmax(axis=0)
        moving = _moves(beside, ranked)
        if moving is not None:
            equal = (ranked == ranked.max(axis=0)) & moving
            first = np.where(equal.any(axis=0), equal.argmax(axis=0), first)
        place = first[None]

        def pick(array: np.ndarray) -> np.ndarray:
            return np.asarray(np.take_along_axis(array, place, axis=0)[0])

        found = {"rank": pick(ranked), "value": pick(values), "at": start + place[0]}
        found |= {name: pick(array) for name, array in beside.items()}
        if not self._best:
            self._best = found
            return
        better = found["rank"] > self._best["rank"]
        before, now = _moves(self._best, self._best["rank"]), _moves(found, found["rank"])
        if before is not None and now is not None:
            better |= (found["rank"] == self._best["rank"]) & now & ~before
        for name, array in found.items():
            self._best[name] = np.where(better, array, self._best[name])

    def result(self) -> dict[str, np.ndarray]:
        """Return the extreme value, its index along the axis, and the accompanying variables."""
        return {name: array for name, array in self._best.items() if name != "rank"}


def _moves(beside: Mapping[str, np.ndarray], ranked: np.ndarray) -> np.ndarray | None:
    """Mark each point that has a value and a response class in which the mass moves.

    Return None if `beside` contains no response classes.
    """
    if "response_class" not in beside:
        return None
    held = (ResponseClass.UNKNOWN, ResponseClass.LOCKED)
    moves: np.ndarray = np.isfinite(ranked) & ~np.isin(beside["response_class"], held)
    return moves


class Mean:
    """The mean along the first axis over the points that have a value, with the mean error and the worst status."""

    def __init__(self) -> None:
        self._sums: dict[str, np.ndarray] = {}
        self._worst: np.ndarray | None = None

    def take(self, start: int, values: np.ndarray, beside: Mapping[str, np.ndarray]) -> None:
        """Process one slab."""
        known = ~np.isnan(values)
        parts = {"value": np.where(known, values, 0.0).sum(axis=0), "count": known.sum(axis=0)}
        for name in beside.keys() & {"amplitude_error", "amplitude_error_m"}:
            parts[name] = np.where(known, beside[name], 0.0).sum(axis=0)
        for name, array in parts.items():
            self._sums[name] = self._sums[name] + array if name in self._sums else array
        # the order from good to bad is converged, not computed, failed
        status = beside["status"].astype(np.int64)
        badness = np.where(status == Status.NOT_COMPUTED, 1.5, status).max(axis=0)
        self._worst = badness if self._worst is None else np.maximum(self._worst, badness)

    def result(self) -> dict[str, np.ndarray]:
        """Return the mean, the mean error and the worst status."""
        assert self._worst is not None
        number = self._sums.pop("count")
        means = {
            name: np.where(number > 0, total / np.maximum(number, 1), np.nan)
            for name, total in self._sums.items()
        }
        means["status"] = np.where(self._worst == 1.5, Status.NOT_COMPUTED, self._worst).astype(np.int8)
        return means
