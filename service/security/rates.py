"""Rate limits: the requests of a minute may be sent together, and the allowance then refills."""

import math
import time
from collections import OrderedDict

_MINUTE = 60.0
_KEPT = 10_000


class Rates:
    """Requests of the last minute, by caller; for one event loop.

    Parameters
    ----------
    per_minute : int, optional
        Largest number of requests a minute; None for no limit.
    """

    def __init__(self, per_minute: int | None) -> None:
        self.per_minute = per_minute
        # time at which a caller's requests no longer count
        self._spent_until: OrderedDict[str, float] = OrderedDict()

    def wait_seconds(self, who: str) -> int:
        """Count a request; if it exceeds the limit, give the time to wait, and do not count it."""
        if self.per_minute is None:
            return 0
        now, each = time.monotonic(), _MINUTE / self.per_minute
        until = max(now, self._spent_until.get(who, now)) + each
        if until > now + _MINUTE + each / 2:  # half a request is allowed for rounding
            return math.ceil(until - now - _MINUTE)
        self._spent_until[who] = until
        self._spent_until.move_to_end(who)
        if len(self._spent_until) > _KEPT:
            # drop the caller with the oldest request; without a request for a minute, a caller has its full allowance
            # anyway
            self._spent_until.popitem(last=False)
        return 0
