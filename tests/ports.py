"""Ports that a test may tell several programs before one of them listens there."""

import itertools
import os
import socket

FIRST, LAST = 15_000, 32_000
"""Below the range from which the system itself takes ports for whoever asks for any: none of those comes in between."""
_EACH = 500
_taken = itertools.count()


def free_port() -> int:
    """Give a port of the loopback interface on which nobody listens, and that nobody else is given.

    Processes of one run of the tests, and runs beside each other, begin at different places, and no port is given twice.
    """
    slices = (LAST - FIRST) // _EACH
    start = FIRST + _EACH * (os.getpid() % slices)
    while True:
        port = FIRST + (start - FIRST + next(_taken)) % (LAST - FIRST)
        with socket.socket() as probe:
            try:
                probe.bind(("127.0.0.1", port))
            except OSError:
                continue
        return port
