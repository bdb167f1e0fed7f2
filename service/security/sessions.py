"""Sessions of the page: a cookie that stands for a key for some hours, so that no script ever holds the key."""

import hmac
import re
import secrets
import time
from hashlib import sha256

from damperlab.studies.store.catalogue.access_keys import AccessKey

COOKIE = "damperlab_session"
LASTS_SECONDS = 8 * 3600

_VALUE = re.compile(r"([0-9a-f]{12})\.([0-9]{1,12})\.([0-9a-f]{64})")


class Sessions:
    """Makes and checks the values of the cookie; they end with the process, with their key, and after eight hours."""

    def __init__(self) -> None:
        self._secret = secrets.token_bytes(32)

    def begin(self, key: AccessKey) -> tuple[str, int]:
        """Give the value of a new session's cookie, and how long it lasts [s]."""
        now = int(time.time())
        ends = now + LASTS_SECONDS
        if key.expires is not None:
            ends = min(ends, int(key.expires.timestamp()))
        return f"{key.id}.{ends}.{self._seal(key, ends)}", ends - now

    def key_id(self, value: str) -> str | None:
        """Give the id of the key that a session claims to stand for; None where it is none, or over."""
        found = _VALUE.fullmatch(value)
        return found[1] if found and int(found[2]) > time.time() else None

    def stands_for(self, value: str, key: AccessKey) -> bool:
        """Whether a session was begun here with this key."""
        found = _VALUE.fullmatch(value)
        return found is not None and hmac.compare_digest(self._seal(key, int(found[2])), found[3])

    def _seal(self, key: AccessKey, ends: int) -> str:
        return hmac.new(self._secret, f"{key.id}.{ends}.{key.hash}".encode(), sha256).hexdigest()
