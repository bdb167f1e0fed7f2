"""Number, status and duration of requests, counted by the access log for the metrics."""

import threading
from bisect import bisect_left
from collections import Counter, defaultdict
from dataclasses import dataclass
from itertools import accumulate

METHODS = frozenset(("GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"))
"""Methods counted by name; others, since a client may send any word, are counted together."""
BOUNDS = (0.005, 0.025, 0.1, 0.5, 2.5, 10.0, 60.0)
"""Upper bounds of the classes of durations [s]; the last class has none."""
NO_ROUTE = "none"
"""Name for requests without a route."""


@dataclass(frozen=True)
class Durations:
    """Durations of one method on one route.

    Parameters
    ----------
    within : tuple of int
        Number of durations up to each of `BOUNDS`, and the total number.
    seconds : float
        Total duration.
    """

    within: tuple[int, ...]
    seconds: float


class Traffic:
    """Requests answered since the start: by method and status, and their durations by method and route."""

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
            As sent.
        status : int
            Status; 0 if the client left before the answer.
        seconds : float
            Time until the answer was complete.
        route : str
            The path with placeholders for its parameters, so that the number of routes is finite.
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
