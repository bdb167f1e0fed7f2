"""How many requests were answered, how, and how fast: what the access log counts for the metrics."""

import threading
from bisect import bisect_left
from collections import Counter, defaultdict
from dataclasses import dataclass
from itertools import accumulate

METHODS = frozenset(("GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"))
"""Counted by name; a client may send any word."""
BOUNDS = (0.005, 0.025, 0.1, 0.5, 2.5, 10.0, 60.0)
"""Upper bounds of the durations that are counted together [s]; a last class has none."""
NO_ROUTE = "none"
"""Stands for the route of a request that none was found for."""


@dataclass(frozen=True)
class Durations:
    """How long the requests of one method to one route took.

    Parameters
    ----------
    within : tuple of int
        How many took no longer than each of `BOUNDS`, and how many there were.
    seconds : float
        All of them together.
    """

    within: tuple[int, ...]
    seconds: float


class Traffic:
    """Requests answered since the start: by method and status, and the time that they took by method and route."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._counts: Counter[tuple[str, int]] = Counter()
        self._classes: dict[tuple[str, str], list[int]] = {}
        self._seconds: defaultdict[tuple[str, str], float] = defaultdict(float)

    def add(self, method: str, status: int, seconds: float, route: str = NO_ROUTE) -> None:
        """Count one request.

        Parameters
        ----------
        method : str
            As it was sent.
        status : int
            Of the answer; 0 where the client left before there was one.
        seconds : float
            Until the answer was complete.
        route : str
            The path with its parameters' names in place of their values, of which there are only so many.
        """
        method = method if method in METHODS else "other"
        with self._lock:
            self._counts[method, status] += 1
            classes = self._classes.setdefault((method, route), [0] * (len(BOUNDS) + 1))
            classes[bisect_left(BOUNDS, seconds)] += 1
            self._seconds[method, route] += seconds

    def read(self) -> tuple[dict[tuple[str, int], int], dict[tuple[str, str], Durations]]:
        """Give the counts by method and status, and the durations by method and route."""
        with self._lock:
            durations = {
                key: Durations(tuple(accumulate(classes)), self._seconds[key])
                for key, classes in self._classes.items()
            }
            return dict(self._counts), durations
