"""A real S3 server for the tests, and a proxy before it that behaves badly on request."""

import os
import socket
import socketserver
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, field
from datetime import timedelta
from pathlib import Path

from tests.ports import free_port

KEY, SECRET = "tester", "only-on-loopback-0815"
START_SECONDS = 600.0
LIFE_SECONDS = 1800
"""The server ends by itself then, whatever becomes of who started it."""
BUCKET = "cubes"

_ROLES = ("master", "volume", "filer", "s3", "admin")


@dataclass
class ObjectServer:
    """SeaweedFS on free ports of the loopback interface."""

    folder: Path
    ports: dict[str, int] = field(default_factory=dict)
    process: subprocess.Popen[bytes] | None = None

    @property
    def address(self) -> tuple[str, int]:
        """Of its S3 door."""
        return "127.0.0.1", self.ports["s3"]

    def start(self) -> None:
        """Start it, on the ports and with the objects that it had before, and wait until it answers."""
        self.ports = self.ports or dict(
            zip(_flags(), (free_port() for _ in range(2 * len(_ROLES))), strict=True)
        )
        command = [
            *("timeout", "--signal=KILL", str(LIFE_SECONDS)),
            *(str(Path(sys.executable).with_name("weed")), "mini", f"-dir={self.folder}"),
            *("-ip=127.0.0.1", "-ip.bind=127.0.0.1", "-master.telemetry=false", "-webdav=false"),
            *("-admin.ui=false", "-s3.port.iceberg=0", "-s3.port.lance=0", f"-bucket={BUCKET}"),
            *(f"-{name if '.' in name else name + '.port'}={port}" for name, port in self.ports.items()),
        ]
        environment = {**os.environ, "AWS_ACCESS_KEY_ID": KEY, "AWS_SECRET_ACCESS_KEY": SECRET}
        self.folder.mkdir(parents=True, exist_ok=True)
        with (self.folder / "log").open("ab") as log:
            self.process = subprocess.Popen(
                command, cwd=self.folder, env=environment, stdout=log, stderr=log, start_new_session=True
            )
        give_up = time.monotonic() + START_SECONDS
        while not _answers(self.address):
            assert self.process.poll() is None, (self.folder / "log").read_text()
            assert time.monotonic() < give_up, (self.folder / "log").read_text()
            time.sleep(0.1)

    def stop(self) -> None:
        """Kill it, as a power cut would."""
        if self.process is not None:
            with suppress(ProcessLookupError):
                os.killpg(self.process.pid, 9)
            self.process.wait()
            self.process = None


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


def _flags() -> list[str]:
    return [*_ROLES, *(f"{role}.port.grpc" for role in _ROLES)]


def _answers(address: tuple[str, int]) -> bool:
    """Whether the bucket is there and takes objects."""
    from obstore.exceptions import BaseError
    from obstore.store import S3Store

    place = S3Store(
        BUCKET,
        endpoint=f"http://{address[0]}:{address[1]}",
        access_key_id=KEY,
        secret_access_key=SECRET,
        region="us-east-1",
        client_options={"allow_http": True, "timeout": timedelta(seconds=2)},
        retry_config={"max_retries": 0},
    )
    try:
        place.put("ready", b"")
        place.delete("ready")
    except (BaseError, OSError):
        return False
    return True
