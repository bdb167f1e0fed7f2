"""Address or network under which the requests of a client are counted."""

from ipaddress import IPv6Address, ip_address

_HOST_BITS = 64


def counted_address(address: str) -> str:
    """Return the address under which requests are counted. An IPv6 address is replaced by its network of 64 bits."""
    try:
        known = ip_address(address)
    except ValueError:
        return address
    if not isinstance(known, IPv6Address):
        return address
    if known.ipv4_mapped is not None:
        return str(known.ipv4_mapped)
    return f"{IPv6Address(int(known) >> _HOST_BITS << _HOST_BITS)}/{_HOST_BITS}"
