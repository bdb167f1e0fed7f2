"""Trusted reverse proxies, which can name the authenticated caller of a request in a header."""

import ipaddress
from collections.abc import Iterable

from starlette.datastructures import Headers

from damperlab.service.security.caller import Caller
from damperlab.studies.vocabulary import SCOPES, Scope


class Proxies:
    """The trusted reverse proxies.

    Parameters
    ----------
    networks : iterable of str
        Addresses or networks of the proxies, as in ``10.0.0.0/8``.
    user_header : str, optional
        Header in which a proxy names the authenticated user.
    scope : str
        Highest scope of a user whom a proxy names, one of `SCOPES`.

    Raises
    ------
    ValueError
        If an item of `networks` is neither an address nor a network.
    """

    def __init__(self, networks: Iterable[str], user_header: str | None, scope: Scope) -> None:
        self._networks = [ipaddress.ip_network(one, strict=False) for one in networks]
        self._header = user_header
        self._scopes = SCOPES[: SCOPES.index(scope) + 1]

    @property
    def sign_in(self) -> bool:
        """Whether a proxy is trusted to name users."""
        return bool(self._networks and self._header)

    def believes(self, peer: str | None) -> bool:
        """Return whether an address belongs to a trusted proxy."""
        if not self._networks or peer is None:
            return False
        try:
            address = ipaddress.ip_address(peer.partition("%")[0])
        except ValueError:
            return False
        mapped = getattr(address, "ipv4_mapped", None) or address
        return any(mapped in network for network in self._networks)

    def user(self, headers: Headers) -> Caller | None:
        """Return the user that a trusted proxy names; None if the header is missing, repeated or invalid."""
        if not self._header:
            return None
        named = headers.getlist(self._header)
        if len(named) != 1 or not (name := named[0].strip()) or len(name) > 100 or not name.isprintable():
            return None
        return Caller(name, self._scopes, "proxy")

    def client(self, headers: Headers) -> str | None:
        """Return the client's address: the last address in X-Forwarded-For, which the trusted proxy added."""
        last = headers.get("x-forwarded-for", "").rpartition(",")[2].strip()
        return last[:60] or None
