"""Readers beside a writer that never rests: no slice may be torn, mixed or stale.

A service with one worker computes a study of small blocks. Blocks of it are damaged and repaired, taken back and
computed again, and the whole study is deleted and submitted anew, all the time. Every attempt writes values that name
it. Readers in processes of their own read slices through the store and over HTTP; see `readers`.
"""

import argparse
import json
import random
import subprocess
import sys
import time
from collections import Counter
from contextlib import ExitStack, closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

import httpx
from tests.faults.processes import ROOT, Process, dask, end_on_sigterm
from tests.faults.readers import READERS
from tests.faults.report import markdown, spelled, traces
from tests.faults.tokens import PLAN, STUDY
from tests.ports import free_port

from damperlab.studies.store.care.verify import repair, verify
from damperlab.studies.store.faults import StudyBusy
from damperlab.studies.store.store import Store
from damperlab.worker.block import solve_block
from damperlab.worker.provenance import provenance

URL = "/api/v1/studies"
PATIENCE_SECONDS = 1200.0
"""Longest time of a campaign."""


@dataclass
class Reading:
    """What was read and written; `wrong` must be empty."""

    seed: int
    reads: Counter[str] = field(default_factory=Counter)
    refused: Counter[str] = field(default_factory=Counter)
    writes: Counter[str] = field(default_factory=Counter)
    wrong: list[str] = field(default_factory=list)
    seconds: float = 0.0

    @property
    def good(self) -> bool:
        """Whether every slice was right, and the study did change meanwhile."""
        return not self.wrong and sum(self.writes.values()) > 2

    def table(self) -> str:
        """Give the report as a Markdown table."""
        rows = [
            ("slices read", spelled(self.reads)),
            ("refused, saying so", spelled(self.refused)),
            ("changes meanwhile", spelled(self.writes)),
            ("torn, mixed or stale", str(len(self.wrong))),
            ("time", f"{self.seconds:.0f} s, seed {self.seed}"),
        ]
        return markdown(rows)


class Writer:
    """Changes the study in every way that there is."""

    def __init__(self, store: Store, url: str, seed: int) -> None:
        self._store = store
        self._http = httpx.Client(base_url=url, timeout=60.0)
        self._random = random.Random(seed)
        self.done: Counter[str] = Counter()
        self.study_id = self._submit()

    def close(self) -> None:
        """Leave the service."""
        self._http.close()

    def change(self) -> None:
        """Wait until the study is whole, and take some of it away."""
        self._wait()
        what = self._random.choices(["take back", "damage and repair", "delete and submit"], [6, 3, 2])[0]
        try:
            {"take back": self._forget, "damage and repair": self._damage, "delete and submit": self._delete}[
                what
            ]()
        except StudyBusy:
            return  # its runner is about to let go
        self.done[what] += 1

    def _submit(self) -> str:
        return self._store.submit(STUDY, PLAN, provenance())[0].id

    def _wait(self) -> None:
        # tells the service that there is work, which it would else see within two seconds
        self._http.post(f"{URL}/{self.study_id}/resume")
        give_up = time.monotonic() + 300.0
        while (record := self._store.find(self.study_id)).state != "done":
            if record.state == "failed" or time.monotonic() > give_up:
                raise RuntimeError(f"the study is {record.state}: {record.message}")
            time.sleep(0.05)
        time.sleep(self._random.uniform(0.0, 0.3))

    def _forget(self) -> None:
        blocks = self._random.sample(range(PLAN.count), self._random.randint(1, PLAN.count))
        self._store.forget(self.study_id, blocks, "campaign")

    def _damage(self) -> None:
        path = Path(self._store.cube_path(self.study_id))
        for file in self._random.sample(sorted(path.glob("blocks/*~*")), 3):
            content = bytearray(file.read_bytes())
            match self._random.choice(["flip", "cut", "lose"]):
                case "flip":
                    content[self._random.randrange(len(content))] ^= 1 << self._random.randrange(8)
                    file.write_bytes(bytes(content))
                case "cut":
                    file.write_bytes(content[: self._random.randrange(len(content))])
                case "lose":
                    file.unlink()
        time.sleep(self._random.uniform(0.0, 0.2))
        record = self._store.find(self.study_id)
        damages = list(verify(self._store, record))
        if not damages:
            raise RuntimeError("damage was not found")
        repair(self._store, record, damages)

    def _delete(self) -> None:
        if self._random.random() < 0.5:
            answer = self._http.delete(f"{URL}/{self.study_id}")
            if answer.status_code == 409:
                return
            answer.raise_for_status()
        else:
            self._store.delete(self.study_id)
        time.sleep(self._random.uniform(0.0, 0.1))
        self._submit()


def run_reading(reads: int, seed: int) -> Reading:
    """Read so many slices in all, each kind of reader its share."""
    with traces("reading") as (folder, reports):
        reports.append(_read_in(folder, reads, seed))
    return cast(Reading, reports[0])


def _read_in(folder: Path, reads: int, seed: int) -> Reading:
    scheduler, port = free_port(), free_port()
    address, url = f"tcp://127.0.0.1:{scheduler}", f"http://127.0.0.1:{port}"
    settings = {
        "DAMPERLAB_DATA_DIR": str(folder / "data"),
        "DAMPERLAB_PORT": str(port),
        "DAMPERLAB_SCHEDULER": address,
        "DAMPERLAB_WORKERS": "",
    }
    preload = ("--preload", "tests.faults.tokens", "--local-directory", str(folder))
    processes = [
        dask(folder / "scheduler.log", "scheduler", "--port", str(scheduler)),
        dask(folder / "worker.log", "worker", address, "--no-nanny", "--nthreads", "1", *preload),
        Process(folder / "service.log", sys.executable, "-m", "tests.faults.believing", "serve", **settings),
    ]
    result = Reading(seed)
    # compiled before anybody waits for it
    solve_block(STUDY, PLAN.block(0))
    began = time.monotonic()
    store = Store.open(folder / "data")
    readers: list[subprocess.Popen[str]] = []
    stop = folder / "stop"
    leave = ExitStack()
    try:
        for process in processes:
            process.keep_up()
        processes[-1].wait_for(url)
        writer = leave.enter_context(closing(Writer(store, url, seed)))
        writer.change()
        share = -(-reads // len(READERS))
        for number, kind in enumerate(READERS):
            options = ["--reads", str(share), "--seed", str(100 * seed + number), "--stop", str(stop)]
            readers.append(
                subprocess.Popen(
                    [
                        sys.executable, "-m", "tests.faults.readers", kind, str(folder / "data"), url,
                        writer.study_id, *options,
                    ],
                    stdout=subprocess.PIPE,
                    text=True,
                    cwd=ROOT,
                )
            )  # fmt: skip
        told = time.monotonic()
        while (
            any(reader.poll() is None for reader in readers) and time.monotonic() < began + PATIENCE_SECONDS
        ):
            writer.change()
            if time.monotonic() > told + 10.0:
                told = time.monotonic()
                at_work = sum(reader.poll() is None for reader in readers)
                print(
                    f"{told - began:5.0f} s: {sum(writer.done.values())} changes, {at_work} readers at work",
                    file=sys.stderr,
                    flush=True,
                )
        stop.touch()
        result.writes = writer.done
        for kind, reader in zip(READERS, readers, strict=True):
            out, _ = reader.communicate(timeout=900.0)
            _add(result, kind, json.loads(out))
    finally:
        leave.close()
        for reader in readers:
            reader.kill()
            reader.communicate()
        for process in processes:
            process.kill()
        store.close()
    result.seconds = round(time.monotonic() - began, 1)
    return result


def _add(result: Reading, kind: str, answer: dict[str, Any]) -> None:
    result.reads[kind] += answer["reads"]
    result.refused.update(answer["refused"])
    result.wrong += [f"{kind}: {text}" for text in answer["wrong"]]


def main() -> int:
    """Run readers and a writer, and print the report."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--reads", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    end_on_sigterm()
    result = run_reading(arguments.reads, arguments.seed)
    for text, count in Counter(result.wrong).most_common(20):
        print(f"{count} times: {text}", file=sys.stderr)
    print(result.table())
    return 0 if result.good and sum(result.reads.values()) >= arguments.reads else 1


if __name__ == "__main__":
    sys.exit(main())
