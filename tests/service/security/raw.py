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


def send_raw(url: str, request: bytes) -> Answer:
    """Send bytes and read to the end of the connection, which must not be reset before its answer."""
    head, _, body = ask(url, request, ends=False).partition(b"\r\n\r\n")
    return Answer(int(head[9:12]), head.decode("latin-1").lower(), body)


def ask(url: str, request: bytes, ends: bool = True) -> bytes:
    """Send bytes, end our half if told to, and read to the end."""
    address = urlsplit(url)
    received = b""
    with socket.create_connection((address.hostname, address.port), timeout=60) as connection:
        connection.sendall(request)
        if ends:
            connection.shutdown(socket.SHUT_WR)
        while part := connection.recv(65536):
            received += part
    return received


def host_of(url: str) -> bytes:
    """The Host header that belongs to an address."""
    return urlsplit(url).netloc.encode()
