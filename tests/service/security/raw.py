"""Requests byte by byte: what no HTTP client would send."""

import socket
from dataclasses import dataclass
from urllib.parse import urlsplit


@dataclass(frozen=True)
class Answer:
    """What came back before the connection ended."""

    status: int
    head: str
    body: bytes


def send_raw(url: str, request: bytes, *, patience_seconds: float = 60.0) -> Answer | None:
    """Send bytes and read to the end of the connection; None where it ended without a word."""
    address = urlsplit(url)
    received = b""
    with socket.create_connection((address.hostname, address.port), timeout=patience_seconds) as connection:
        try:
            connection.sendall(request)
        except (BrokenPipeError, ConnectionResetError):
            return None
        try:
            while part := connection.recv(65536):
                received += part
        except ConnectionResetError:
            return None
    if not received:
        return None
    head, _, body = received.partition(b"\r\n\r\n")
    return Answer(int(head[9:12]), head.decode("latin-1").lower(), body)


def ask(url: str, request: bytes) -> bytes:
    """Send bytes, end our half, and read to the end."""
    address = urlsplit(url)
    received = b""
    with socket.create_connection((address.hostname, address.port), timeout=60) as connection:
        connection.sendall(request)
        connection.shutdown(socket.SHUT_WR)
        while part := connection.recv(65536):
            received += part
    return received


def host_of(url: str) -> bytes:
    """The Host header that belongs to an address."""
    return urlsplit(url).netloc.encode()
