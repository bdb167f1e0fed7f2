"""Counts requests by status and duration, for the metrics of the service."""

import threading
from bisect import bisect_left
from collections import Counter, defaultdict
from dataclasses import dataclass
from itertools import accumulate

METHODS = frozenset(("GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"))
"""HTTP methods that are counted separately. All other methods, which may be any words, are counted together."""
BOUNDS = (0.005, 0.025, 0.1, 0.5, 2.5, 10.0, 60.0)
"""Upper bounds of the histogram's duration classes [s].

A further class contains all durations above the largest bound.
"""
NO_ROUTE = "none"
"""Name under which requests without a route are counted."""


@dataclass(frozen=True)
class Durations:
    """Durations of the requests with one method and one route.

    Parameters
    ----------
    within : tuple of int
        Number of requests with a duration up to each value in `BOUNDS`, and total number of requests.
    seconds : float
        Sum of the durations [s].
    """

    within: tuple[int, ...]
    seconds: float


class Traffic:
    """Counts the requests since the start by method and status, and their durations by method and route."""

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
            Method of the request, as the client sent it.
        status : int
            Status of the response; 0 if the client closed the connection before the response.
        seconds : float
            Time from the beginning of the request to the end of the response [s].
        route : str
            Path of the route, in which parameters are placeholders.
        """
        method = method if method in METHODS else "other"
        with self._lock:
            self._counts[method, status] += 1
            classes = self._classes.setdefault((method, route), [0] * (len(BOUNDS) + 1))
            classes[bisect_left(BOUNDS, seconds)] += 1
            self._seconds[method, route] += seconds

    def read(self) -> tuple[dict[tuple[str, int], int], dict[tuple[str, str], Durations]]:
        """Return the numbers of requests by method and status, and the durations by method and route."""
        with self._lock:
            durations = {
                key: Durations(tuple(accumulate(classes)), self._seconds[key])
                for key, classes in self._classes.items()
            }
            return dict(self._counts), durations
