"""Sessions of the web page. A cookie replaces the access key for some hours, so the page need not store the key."""

import secrets
import time
from collections import OrderedDict
from hashlib import sha256

from damperlab.studies.store.catalogue.access_keys import AccessKey

COOKIE = "damperlab_session"
LASTS_SECONDS = 8 * 3600
OF_ONE_KEY = 100
"""Largest number of sessions of one key; a further session ends the oldest session."""


class Sessions:
    """The active sessions. A session ends after eight hours, at the sign-out, or when its key becomes invalid."""

    def __init__(self) -> None:
        # by the hash of the cookie's value: id of the session's key, hash of the key, and end of the session
        self._open: OrderedDict[bytes, tuple[str, str, float]] = OrderedDict()

    def begin(self, key: AccessKey) -> tuple[str, int]:
        """Begin a session, and return the value and the lifetime of its cookie [s]."""
        now = int(time.time())
        ends = now + LASTS_SECONDS
        if key.expires is not None:
            ends = min(ends, int(key.expires.timestamp()))
        self._forget(now, key.id)
        value = f"{key.id}.{ends}.{secrets.token_hex(32)}"
        self._open[_hashed(value)] = (key.id, key.hash, ends)
        return value, ends - now

    def key_id(self, value: str) -> str | None:
        """Return the id of the key with which a session began; None if the session is unknown or has ended."""
        key_id, _, ends = self._open.get(_hashed(value), ("", "", 0.0))
        return key_id if ends > time.time() else None

    def stands_for(self, value: str, key: AccessKey) -> bool:
        """Return whether a session began with the given key."""
        return self._open.get(_hashed(value), ("", "", 0.0))[:2] == (key.id, key.hash)

    def end(self, value: str) -> None:
        """End a session."""
        self._open.pop(_hashed(value), None)

    def _forget(self, now: float, key_id: str) -> None:
        """Drop ended sessions. Also drop the oldest sessions of a key until the key may have one more."""
        for each in [each for each, (_, _, ends) in self._open.items() if ends <= now]:
            del self._open[each]
        of_key = [each for each, (of, _, _) in self._open.items() if of == key_id]
        for each in of_key[: max(0, len(of_key) + 1 - OF_ONE_KEY)]:
            del self._open[each]


def _hashed(value: str) -> bytes:
    return sha256(value.encode("utf-8", "surrogatepass")).digest()
