"""Rate limits. A caller may send the requests of one minute in one burst. The allowance then refills steadily."""

import math
import time
from collections import OrderedDict

_MINUTE = 60.0
_KEPT = 10_000


class Rates:
    """Counts the requests of each caller in the last minute. All calls must come from one event loop.

    Parameters
    ----------
    per_minute : int, optional
        Largest number of requests a minute; None for no limit.
    """

    def __init__(self, per_minute: int | None) -> None:
        self.per_minute = per_minute
        # for each caller: time at which the allowance is full again
        self._spent_until: OrderedDict[str, float] = OrderedDict()

    def wait_seconds(self, who: str) -> int:
        """Count a request and return 0. If the request exceeds the limit, return the time to wait [s]."""
        if self.per_minute is None:
            return 0
        now, each = time.monotonic(), _MINUTE / self.per_minute
        until = max(now, self._spent_until.get(who, now)) + each
        if until > now + _MINUTE + each / 2:  # tolerance for rounding: half a request
            return math.ceil(until - now - _MINUTE)
        self._spent_until[who] = until
        self._spent_until.move_to_end(who)
        if len(self._spent_until) > _KEPT:
            # drop the caller that has sent no request for the longest time
            self._spent_until.popitem(last=False)
        return 0
