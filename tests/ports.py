"""Ports that a test may tell several programs before one of them listens there."""

import fcntl
import os
import socket
import tempfile
from pathlib import Path
from typing import TextIO

FIRST, LAST = 15_000, 32_000
"""Below the range from which the system itself takes ports for whoever asks for any: none of those comes in between."""
_held: list[TextIO] = []


def free_port() -> int:
    """Give a port of the loopback interface on which nobody listens, and that no other process of any tests is given.

    It is held until the process ends, by a lock on a file of its name.
    """
    folder = Path(tempfile.gettempdir()) / f"damperlab-ports-{os.getuid()}"
    folder.mkdir(exist_ok=True)
    for port in range(FIRST, LAST):
        lock = (folder / str(port)).open("w")
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            with socket.socket() as probe:
                probe.bind(("127.0.0.1", port))
        except OSError:
            lock.close()
            continue
        _held.append(lock)
        return port
    raise OSError(f"no port from {FIRST} to {LAST} is free")
