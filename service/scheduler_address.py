"""Checks the format of the address of a Dask scheduler."""

import re

FORM = "tcp://HOST:8786 or tls://HOST:8786"
_WRITTEN = re.compile(r"(?:[a-z]+://)?(?:\[[0-9a-fA-F:.%]+\]|[^\s:/\[\]]+):(\d{1,5})")
_MOST = 65535


def is_address(text: str) -> bool:
    """Return whether a text is an address with a host and a port."""
    found = _WRITTEN.fullmatch(text)
    return found is not None and 0 < int(found[1]) <= _MOST
