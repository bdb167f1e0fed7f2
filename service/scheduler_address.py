"""Format of the address of a Dask scheduler."""

import re

FORM = "tcp://HOST:8786 or tls://HOST:8786"
_WRITTEN = re.compile(r"(?:[a-z]+://)?(?:\[[0-9a-fA-F:.%]+\]|[^\s:/\[\]]+):(\d{1,5})")
_MOST = 65535


def is_address(text: str) -> bool:
    """Whether a text names a host and a port; for an invalid address Dask waits as long as for an absent scheduler."""
    found = _WRITTEN.fullmatch(text)
    return found is not None and 0 < int(found[1]) <= _MOST
