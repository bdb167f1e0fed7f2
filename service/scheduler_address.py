"""How the address of a Dask scheduler is written."""

import re

FORM = "tcp://HOST:8786 or tls://HOST:8786"
_WRITTEN = re.compile(r"(?:[a-z]+://)?(?:\[[0-9a-fA-F:.%]+\]|[^\s:/\[\]]+):(\d{1,5})")
_MOST = 65535


def is_address(text: str) -> bool:
    """Whether a text names a host and a port; Dask looks for what is no address as long as for one that is away."""
    found = _WRITTEN.fullmatch(text)
    return found is not None and 0 < int(found[1]) <= _MOST
