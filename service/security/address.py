"""The name under which requests of an address are counted."""

from ipaddress import IPv6Address, ip_address

_HOST_BITS = 64


def counted_address(address: str) -> str:
    """Name the network under which an address is counted. A host of IPv6 has 2**64 addresses, so its network part is
    used.
    """
    try:
        known = ip_address(address)
    except ValueError:
        return address
    if not isinstance(known, IPv6Address):
        return address
    if known.ipv4_mapped is not None:
        return str(known.ipv4_mapped)
    return f"{IPv6Address(int(known) >> _HOST_BITS << _HOST_BITS)}/{_HOST_BITS}"
