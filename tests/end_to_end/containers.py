"""Processes in the place of containers: their own commands, names of hosts as loopback, free ports, and folders for volumes."""

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path

SECONDS = 600.0
"""Nothing of these tests may take longer."""
PATH = {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}


class Containers:
    """What runs on this machine, and what is put in the place of what Docker or Kubernetes would provide."""

    def __init__(self, folder: Path, ports: Mapping[str, str], volumes: tuple[str, ...]) -> None:
        self.folder, self.ports, self.volumes = folder, ports, volumes
        self.running: dict[str, subprocess.Popen[bytes]] = {}

    def here(self, text: str) -> str:
        """Give a word of a command, or the value of a variable, as it is on this machine."""
        text = re.sub(r"\b(scheduler|objects):(?=\d)", "127.0.0.1:", text)
        text = text.replace('"scheduler"', '"127.0.0.1"').replace("0.0.0.0", "127.0.0.1")
        for port, free in self.ports.items():
            text = re.sub(rf"\b{port}\b", free, text)
        return re.sub(rf"(?<![\w/])/({'|'.join(self.volumes)})\b", rf"{self.folder}/\1", text)

    def ends_well(self, command: list[str]) -> bool:
        """Whether a command that checks something is content."""
        words = [self.here(word) for word in command]
        environment = {**os.environ, **PATH}
        return not subprocess.run(words, env=environment, capture_output=True, check=False).returncode

    def start(self, name: str, command: list[str], given: Mapping[str, str]) -> None:
        """Start a part with the variables that it is given."""
        with self.log(name).open("wb") as out:
            self.running[name] = subprocess.Popen(
                [self.here(word) for word in command],
                cwd=self.folder,
                env={**os.environ, **PATH, **given},
                stdout=out,
                stderr=subprocess.STDOUT,
            )

    def wait(self, name: str, true: Callable[[], bool]) -> None:
        """Wait until something is so, while a part runs."""
        give_up = time.monotonic() + SECONDS
        while not true():
            assert self.running[name].poll() is None, self.log(name).read_text()
            assert time.monotonic() < give_up, self.log(name).read_text()
            time.sleep(0.2)

    def leave(self, name: str) -> None:
        """End a part as a container is ended."""
        process = self.running.pop(name)
        process.send_signal(signal.SIGTERM)
        assert process.wait(SECONDS) == 0, self.log(name).read_text()

    def kill(self) -> None:
        """End what still runs, in the reverse order of its start."""
        for process in reversed(self.running.values()):
            process.kill()
            process.wait()

    def log(self, name: str) -> Path:
        """Name what a part prints."""
        return self.folder / f"{name}.log"
