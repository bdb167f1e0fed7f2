"""How a client finds the tests' S3 server (`tests.faults.processes`), and a proxy before it that behaves badly on request."""

import socket
import socketserver
import threading
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress

KEY, SECRET = "tester", "only-on-loopback-0815"
BUCKET = "cubes"


def environment(address: tuple[str, int]) -> dict[str, str]:
    """Give the variables by which a client finds the server, or the proxy before it."""
    return {
        "AWS_ENDPOINT_URL": f"http://{address[0]}:{address[1]}",
        "AWS_ACCESS_KEY_ID": KEY,
        "AWS_SECRET_ACCESS_KEY": SECRET,
        "AWS_REGION": "us-east-1",
    }


class Proxy(socketserver.ThreadingTCPServer):
    """Hands bytes on to a server; `mode` says how: well, refuse (503), slow, cut (half of every answer)."""

    allow_reuse_address = True
    daemon_threads = True

    def __init__(self, target: tuple[str, int]) -> None:
        super().__init__(("127.0.0.1", 0), _Connection)
        self.target = target
        self.mode = "well"
        self.delay_seconds = 0.5
        self.met = 0
        """Requests that met bad behaviour."""

    @property
    def address(self) -> tuple[str, int]:
        """Where it listens."""
        host, port = self.server_address[:2]
        return str(host), int(port)


class _Connection(socketserver.BaseRequestHandler):
    server: Proxy

    def handle(self) -> None:
        client: socket.socket = self.request
        with suppress(OSError), closing(socket.create_connection(self.server.target, 10)) as upstream:
            back = threading.Thread(target=self._back, args=(upstream, client), daemon=True)
            back.start()
            while piece := client.recv(65536):
                if self.server.mode == "refuse":
                    self.server.met += 1
                    client.sendall(
                        b"HTTP/1.1 503 Slow Down\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"
                    )
                    break
                upstream.sendall(piece)
            upstream.shutdown(socket.SHUT_RDWR)
            back.join(5)

    def _back(self, upstream: socket.socket, client: socket.socket) -> None:
        with suppress(OSError):
            while piece := upstream.recv(65536):
                if self.server.mode == "slow":
                    self.server.met += 1
                    time.sleep(self.server.delay_seconds)
                if self.server.mode == "cut":
                    self.server.met += 1
                    client.sendall(piece[: len(piece) // 2])
                    client.shutdown(socket.SHUT_RDWR)
                    return
                client.sendall(piece)


@contextmanager
def proxy_before(target: tuple[str, int]) -> Iterator[Proxy]:
    """Run a proxy for the time of the context."""
    with Proxy(target) as proxy:
        thread = threading.Thread(target=proxy.serve_forever, args=(0.05,), daemon=True)
        thread.start()
        yield proxy
        proxy.shutdown()
        thread.join()
