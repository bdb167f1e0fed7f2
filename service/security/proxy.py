"""A reverse proxy in front of the service: the trusted peers, and the callers that they name."""

import ipaddress
from collections.abc import Iterable

from starlette.datastructures import Headers

from damperlab.service.security.caller import Caller
from damperlab.studies.vocabulary import SCOPES, Scope


class Proxies:
    """The peers whose word counts.

    Parameters
    ----------
    networks : iterable of str
        Addresses or networks, as in ``10.0.0.0/8``.
    user_header : str, optional
        Header in which they name the user that they have let in.
    scope : str
        The highest of `SCOPES` that such a user has.

    Raises
    ------
    ValueError
        If one is no network.
    """

    def __init__(self, networks: Iterable[str], user_header: str | None, scope: Scope) -> None:
        self._networks = [ipaddress.ip_network(one, strict=False) for one in networks]
        self._header = user_header
        self._scopes = SCOPES[: SCOPES.index(scope) + 1]

    @property
    def sign_in(self) -> bool:
        """Whether anybody may be let in by a proxy."""
        return bool(self._networks and self._header)

    def believes(self, peer: str | None) -> bool:
        """Whether a peer is one of them."""
        if not self._networks or peer is None:
            return False
        try:
            address = ipaddress.ip_address(peer.partition("%")[0])
        except ValueError:
            return False
        mapped = getattr(address, "ipv4_mapped", None) or address
        return any(mapped in network for network in self._networks)

    def user(self, headers: Headers) -> Caller | None:
        """Give the user whom a believed peer names; None where it names none, or several."""
        if not self._header:
            return None
        named = headers.getlist(self._header)
        if len(named) != 1 or not (name := named[0].strip()) or len(name) > 100 or not name.isprintable():
            return None
        return Caller(name, self._scopes, "proxy")

    def client(self, headers: Headers) -> str | None:
        """Give the address that a believed peer was asked from: the last one in X-Forwarded-For, which it added itself."""
        last = headers.get("x-forwarded-for", "").rpartition(",")[2].strip()
        return last[:60] or None
