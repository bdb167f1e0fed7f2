"""How many requests were answered, and how: what the access log counts for the metrics."""

import threading
from collections import Counter

METHODS = frozenset(("GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"))
"""Counted by name; a client may send any word."""


class Traffic:
    """Requests answered since the start, by method and status, and the time that they took."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._counts: Counter[tuple[str, int]] = Counter()
        self._seconds = 0.0

    def add(self, method: str, status: int, seconds: float) -> None:
        """Count one request; `status` 0 is one that the client left before it was answered."""
        method = method if method in METHODS else "other"
        with self._lock:
            self._counts[method, status] += 1
            self._seconds += seconds

    def read(self) -> tuple[dict[tuple[str, int], int], float]:
        """Give the counts, and all their seconds together."""
        with self._lock:
            return dict(self._counts), self._seconds
