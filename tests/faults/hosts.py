"""Several hosts on one machine: network namespaces, each with a cable to one switch, made and removed by who asks."""

import ctypes
import os
import shutil
import signal
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

PLACES = Path("/run/netns")
"""Where the command `ip` keeps namespaces by name."""
_NETWORK = 0x40000000  # CLONE_NEWNET of <sched.h>


class NoHosts(RuntimeError):
    """This machine lets nobody make namespaces; says why."""


@dataclass
class Host:
    """A namespace with an address of its own."""

    name: str
    address: str
    processes: list[subprocess.Popen[str]] = field(default_factory=list)

    def start(self, command: list[str], environment: dict[str, str]) -> subprocess.Popen[str]:
        """Start a process there, its standard output to be read."""
        process = subprocess.Popen(
            self.inside(*command),
            env={**os.environ, **environment},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self.processes.append(process)
        return process

    def inside(self, *command: str) -> tuple[str, ...]:
        """Give the command that runs a command there, as the same process."""
        return "ip", "netns", "exec", self.name, *command

    def enter(self) -> None:
        """Let this thread, and all processes and threads that it starts from now on, be there."""
        libc = ctypes.CDLL(None, use_errno=True)
        with (PLACES / self.name).open("rb") as place:
            if libc.setns(place.fileno(), _NETWORK):
                number = ctypes.get_errno()
                raise NoHosts(f"{self.name} cannot be entered: {os.strerror(number)}")

    def cable(self, up: bool) -> None:
        """Plug the cable in, or pull it."""
        _ip("netns", "exec", self.name, "ip", "link", "set", "eth0", "up" if up else "down")

    def kill(self) -> None:
        """End all that runs there, this process aside, as a power cut would."""
        while left := [pid for pid in self._there() if pid != os.getpid()]:
            for pid in left:
                with suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
            for process in self.processes:
                process.poll()
        for process in self.processes:
            process.wait()
            if process.stdout is not None:
                process.stdout.close()
        self.processes.clear()

    def _there(self) -> Iterator[int]:
        """Give the processes that run there; what has ended and is not yet waited for has no network any more."""
        place = (PLACES / self.name).stat()
        for process in Path("/proc").glob("[0-9]*"):
            with suppress(OSError):
                network = (process / "ns" / "net").stat()
                if (network.st_dev, network.st_ino) == (place.st_dev, place.st_ino):
                    yield int(process.name)


@contextmanager
def hosts(*names: str) -> Iterator[list[Host]]:
    """Give hosts that reach each other through one switch, and nothing else.

    Raises
    ------
    NoHosts
        The kernel, or the lack of `ip`, refuses.
    """
    if shutil.which("ip") is None:
        raise NoHosts("there is no `ip` here: `apt-get install iproute2` brings it")
    mark = f"dl{os.getpid()}"
    switch = f"{mark}-switch"
    found: list[Host] = []
    with ExitStack() as stack:

        def space(name: str) -> None:
            _ip("netns", "add", name)
            stack.callback(subprocess.run, ["ip", "netns", "del", name], check=False)
            _ip("-n", name, "link", "set", "lo", "up")

        space(switch)
        _ip("-n", switch, "link", "add", "bridge", "type", "bridge")
        _ip("-n", switch, "link", "set", "bridge", "up")
        for number, name in enumerate(names, 1):
            host = Host(f"{mark}-{name}", f"10.77.0.{number}")
            space(host.name)
            port = f"port{number}"
            _ip("-n", switch, "link", "add", port, "type", "veth", "peer", "name", "eth0", "netns", host.name)
            _ip("-n", switch, "link", "set", port, "master", "bridge", "up")
            _ip("-n", host.name, "addr", "add", f"{host.address}/24", "dev", "eth0")
            host.cable(True)
            stack.callback(host.kill)
            found.append(host)
        yield found


def _ip(*arguments: str) -> None:
    done = subprocess.run(["ip", *arguments], capture_output=True, text=True, check=False)
    if done.returncode:
        raise NoHosts(f"`ip {' '.join(arguments)}` was refused: {done.stderr.strip()}")
