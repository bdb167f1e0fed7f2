"""Conditions for serving a request: host name, origin, and the caller's key."""

import time
from collections.abc import Callable
from hashlib import sha256

from anyio import CapacityLimiter
from anyio.to_thread import run_sync
from starlette.datastructures import Headers
from starlette.requests import cookie_parser

from damperlab.service.security.audit import AUDIT_FILE, Audit
from damperlab.service.security.caller import ANYBODY, Caller
from damperlab.service.security.hosts import Hosts, is_loopback
from damperlab.service.security.proxy import Proxies
from damperlab.service.security.rates import Rates
from damperlab.service.security.sessions import COOKIE, Sessions
from damperlab.service.settings import Settings
from damperlab.studies.store.catalogue.access_keys import AccessKey, AccessKeys

KEPT_SECONDS = 5.0
"""Time after which a recognised key is looked up again, so that a revoked key is refused [s]."""
_KEPT = 1000
_AT_ONCE = 4


def needs_keys(settings: Settings) -> bool:
    """Return whether a service requires keys. By default, keys are required if the service listens beyond loopback."""
    return settings.access == "keys" or (settings.access == "auto" and not is_loopback(settings.host))


class Guard:
    """Identifies the callers of a service, and holds the limits, allowed hosts and allowed origins.

    Parameters
    ----------
    settings : Settings
        Settings of the service.
    """

    def __init__(self, settings: Settings) -> None:
        self.needs_keys = needs_keys(settings)
        self.hosts = Hosts(settings.host, settings.hosts)
        self.origins = frozenset(settings.cors_origins)
        self.proxies = Proxies(settings.trusted_proxies, settings.proxy_user_header, settings.proxy_scope)
        self.audit = Audit(settings.data_dir / AUDIT_FILE)
        self.sessions = Sessions()
        self.rates = Rates(settings.key_requests_per_minute)
        self.rate_of_all = Rates(settings.requests_per_minute)
        self.keys: AccessKeys | None = None
        """The access keys; None until the catalogue is open."""
        self._limiter: CapacityLimiter | None = None
        self._kept: dict[bytes, tuple[Caller, float]] = {}

    async def identify(self, headers: Headers, peer: str | None) -> Caller | None:
        """Return the caller of a request; None if the caller is unknown.

        Parameters
        ----------
        headers : Headers
            Headers of the request; a key takes precedence over a session, and a session over a proxy's header.
        peer : str, optional
            Address of the other end of the connection.
        """
        if not self.needs_keys:
            return ANYBODY
        kind, _, secret = headers.get("authorization", "").partition(" ")
        if kind.lower() == "bearer":
            return await self._known(secret.strip(), self.of_key)
        session = cookie_parser(headers.get("cookie", "")).get(COOKIE)
        if session and (caller := await self._known(session, self._of_session)):
            return caller
        return self.proxies.user(headers) if self.proxies.believes(peer) else None

    def end_session(self, headers: Headers) -> None:
        """End the session of a request."""
        if value := cookie_parser(headers.get("cookie", "")).get(COOKIE):
            self.sessions.end(value)
            self._kept.pop(_hashed(value), None)

    def of_key(self, secret: str) -> AccessKey | None:
        """Return the valid access key with the given secret; None if there is no such key."""
        return self.keys.recognise(secret) if self.keys else None

    def _of_session(self, value: str) -> AccessKey | None:
        key_id = self.sessions.key_id(value)
        key = self.keys.find(key_id) if self.keys and key_id else None
        return key if key and key.valid and self.sessions.stands_for(value, key) else None

    async def _known(self, secret: str, look: Callable[[str], AccessKey | None]) -> Caller | None:
        digest = _hashed(secret)
        caller, until = self._kept.get(digest, (None, 0.0))
        now = time.monotonic()
        if caller is not None and now < until:
            return caller
        self._limiter = self._limiter or CapacityLimiter(_AT_ONCE)
        key = await run_sync(look, secret, limiter=self._limiter)
        self._kept.pop(digest, None)
        if key is None:
            return None
        if len(self._kept) >= _KEPT:
            self._kept.clear()
        caller = Caller(key.owner, key.scopes, "key" if look == self.of_key else "session", key.id)
        ends = now + KEPT_SECONDS
        if key.expires is not None:
            ends = min(ends, now + key.expires.timestamp() - time.time())
        if look == self.of_key or self.sessions.key_id(secret):  # the session may have been ended meanwhile
            self._kept[digest] = (caller, ends)
        return caller


def _hashed(secret: str) -> bytes:
    return sha256(secret.encode("utf-8", "surrogatepass")).digest()
