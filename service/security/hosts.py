"""Host names under which the service answers. The check of the names prevents DNS rebinding by foreign sites."""

import ipaddress
import re
import socket
from collections.abc import Iterable
from functools import cache

_HOST = re.compile(r"(\[[0-9a-f:.]+\]|[^:\[\]/@?#\s]+)(?::[0-9]{1,5})?")


@cache
def is_loopback(address: str) -> bool:
    """Return whether an address, or every address of a host name, is a loopback address."""
    try:
        found = {entry[4][0] for entry in socket.getaddrinfo(address, None)}
    except OSError:
        return False
    return bool(found) and all(ipaddress.ip_address(str(one).partition("%")[0]).is_loopback for one in found)


def host_name(header: str) -> str | None:
    """Return the name in a Host header, in lower case and without the port; None if the header is malformed."""
    found = _HOST.fullmatch(header.strip().lower())
    return found[1].strip("[]").removesuffix(".") if found else None


class Hosts:
    """Allowed names in a Host header.

    Parameters
    ----------
    listens_on : str
        Address on which the service listens. Loopback names are always allowed. If other machines can reach the
        service, the address, this machine's name and all numeric addresses are allowed too. Numeric addresses are safe,
        because DNS rebinding needs a name.
    names : iterable of str
        Further host names; ``.example.org`` includes every name under it.
    """

    def __init__(self, listens_on: str, names: Iterable[str] = ()) -> None:
        self._names = {"localhost"} | {name.lower() for name in names}
        self._digits = not is_loopback(listens_on)
        if self._digits:
            self._names |= {listens_on.lower(), socket.gethostname().lower()}

    def allows(self, header: str) -> bool:
        """Return whether a Host header contains an allowed name."""
        name = host_name(header)
        if name is None:
            return False
        if name in self._names or any(n.startswith(".") and name.endswith(n) for n in self._names):
            return True
        try:
            address = ipaddress.ip_address(name)
        except ValueError:
            return False
        return self._digits or address.is_loopback

    @property
    def told(self) -> str:
        """The allowed names, separated by commas, for a message."""
        return ", ".join(sorted({"127.0.0.1", "[::1]"} | self._names))
