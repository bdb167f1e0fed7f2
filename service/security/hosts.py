"""Names that the service answers to: a page elsewhere can make its own name point here, but not change the name."""

import ipaddress
import re
import socket
from collections.abc import Iterable
from functools import cache

_HOST = re.compile(r"(\[[0-9a-f:.]+\]|[^:\[\]/@?#\s]+)(?::[0-9]{1,5})?")


@cache
def is_loopback(address: str) -> bool:
    """Whether an address, or every address of a name, reaches this machine alone."""
    try:
        found = {entry[4][0] for entry in socket.getaddrinfo(address, None)}
    except OSError:
        return False
    return bool(found) and all(ipaddress.ip_address(str(one).partition("%")[0]).is_loopback for one in found)


def host_name(header: str) -> str | None:
    """Give the name in a Host header, in small letters and without the port; None where there is none."""
    found = _HOST.fullmatch(header.strip().lower())
    return found[1].strip("[]").removesuffix(".") if found else None


class Hosts:
    """What a Host header may say.

    Parameters
    ----------
    listens_on : str
        The address that the service listens on. Loopback names are always right. Beyond loopback they are also the address
        itself, this machine's name, and any numeric address: others can point only a name here. names : iterable of str More
        names; ``.example.org`` stands for every name under it.
    """

    def __init__(self, listens_on: str, names: Iterable[str] = ()) -> None:
        self._names = {"localhost"} | {name.lower() for name in names}
        self._digits = not is_loopback(listens_on)
        if self._digits:
            self._names |= {listens_on.lower(), socket.gethostname().lower()}

    def allows(self, header: str) -> bool:
        """Whether a Host header names this service."""
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
        """The names, for a message."""
        return ", ".join(sorted({"127.0.0.1", "[::1]"} | self._names))
