"""What a damaged store answers through its doors: single bits flipped, each file lost once, asked by commands and over HTTP.

The store and its damage are those of `damage.py`. Each case is asked by a process of its own, forked from this one, which
has loaded all that a command needs: the command line itself, or a service on a port. The outcome is one of

    refused    a sentence and exit status 1, or a problem document that is no 500
    found      an answer differs, and `damperlab store verify` tells of damage
    harmless   every answer is what it was, byte for byte
    silent     an answer differs, and nobody says so: a defect
    crashed    a traceback, or HTTP 500: a defect
"""

import argparse
import os
import re
import shutil
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from contextlib import closing, suppress
from pathlib import Path

import httpx
from tests.faults.damage import Report, cases, make_store
from tests.ports import free_port

# loaded here, that each child need not
import damperlab.service.app
import damperlab.service.dispatch
import damperlab.studies.store.cube.opened  # noqa: F401
from damperlab.service.cli.main import main as command_line
from damperlab.studies.store.store import Store

COMMANDS = (
    ("studies", "--json"),
    ("show", "done", "--json"),
    ("map", "done", "--x", "clearance_ratio", "--y", "friction_ratio", "--json"),
    ("optimum", "done", "--json"),
    ("export", "done", "--format", "csv", "-o", "{folder}/done.csv"),
    ("show", "half", "--json"),
)
PATHS = (
    "/studies",
    "/studies/{id}",
    "/studies/{id}/resonance-map?x=clearance_ratio&y=friction_ratio",
    "/studies/{id}/optimal-designs",
    "/studies/{id}/export?format=csv",
    "/studies/{id}/zarr/zarr.json",
    "/studies/{id}/zarr/clearance_ratio/c.0",
    "/studies/{id}/zarr/amplitude_ratio/c.0.0.0.0.0.0",
)
START_SECONDS = 60.0
CUT_SHORT = 599
"""In place of a status: the connection ended before the answer did, which no client takes for a whole one."""

Answers = dict[str, tuple[int, str]]
"""By question: the exit status or that of HTTP, and all that was said."""


def in_child(work: Callable[[], None], log: Path) -> int:
    """Fork; the child does the work, and all that it says goes into a file. Its process id."""
    sys.stdout.flush()
    pid = os.fork()
    if pid:
        return pid
    status = 1
    try:
        with log.open("wb") as file:
            os.dup2(file.fileno(), 1)
            os.dup2(file.fileno(), 2)
        work()
        status = 0
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else 1
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


def command(folder: Path, *arguments: str) -> tuple[int, str]:
    """Run one command; its exit status and all that it said, with the file that it wrote."""
    log = folder.with_name("said")

    def work() -> None:
        sys.argv = ["damperlab", *arguments, "--data-dir", str(folder / "store")]
        sys.exit(command_line())

    status = os.waitstatus_to_exitcode(os.waitpid(in_child(work, log), 0)[1])
    said = log.read_text(errors="replace")
    for file in folder.glob("*.csv"):
        said += file.read_text(errors="replace")
        file.unlink()
    return status, said


def by_commands(folder: Path) -> Answers:
    """Ask every command."""
    return {
        " ".join(each): command(folder, *(part.format(folder=folder) for part in each)) for each in COMMANDS
    }


def over_http(folder: Path) -> Answers:
    """Start a service, ask it for everything and stop it; one that does not start has refused."""
    port = free_port()
    log = folder.with_name("served")

    def work() -> None:
        # no cluster: there is nothing to compute
        os.environ["DAMPERLAB_WARM"] = "false"
        sys.argv = ["damperlab", "serve", "--port", str(port), "--scheduler", "tcp://127.0.0.1:9"]
        sys.argv += ["--data-dir", str(folder / "store")]
        sys.exit(command_line())

    pid = in_child(work, log)
    try:
        return _asked(f"http://127.0.0.1:{port}", pid, log)
    finally:
        with suppress(ProcessLookupError, ChildProcessError):
            os.kill(pid, 15)
            os.waitpid(pid, 0)


def _asked(url: str, pid: int, log: Path) -> Answers:
    give_up = time.monotonic() + START_SECONDS
    answers: Answers = {}
    with httpx.Client(base_url=f"{url}/api/v1", timeout=30) as client:
        while True:
            ended, status = os.waitpid(pid, os.WNOHANG)
            if ended or time.monotonic() > give_up:
                return {"serve": (os.waitstatus_to_exitcode(status), log.read_text(errors="replace"))}
            try:
                client.get(f"{url}/health/live")
                break
            except httpx.TransportError:
                time.sleep(0.05)
        for path in PATHS:
            try:
                answer = client.get(path.format(id=IDS[0]))
                answers[path] = answer.status_code, answer.text
            except httpx.RemoteProtocolError as error:
                answers[path] = CUT_SHORT, str(error)
    said = log.read_text(errors="replace")
    if "Traceback" in said:
        answers["log"] = 500, said
    return answers


IDS: list[str] = []
"""Of the study that is done."""

_TIMES = re.compile(
    r'"(time|trace_id|request_id|instance|seconds_left|Date)": ?("[^"]*"|[0-9.]+|null)|^[^"\n]* …[^"\n]*\n',
    re.MULTILINE,
)
"""What differs from one asking to the next: times, and the lines that a command prints once it has taken two seconds."""


def judge(answers: Answers, expected: Answers, folder: Path) -> tuple[str, str]:
    """Say what a damaged store's answers come to."""
    for question, (status, said) in answers.items():
        if status == 500 or "Traceback" in said or status < 0:
            return "crashed", f"{question}: {said[-300:]}"
    good = {question: answer for question, answer in answers.items() if answer[0] in (0, 200)}
    differ = [
        question
        for question, (_, said) in good.items()
        if _TIMES.sub("", said) != _TIMES.sub("", expected[question][1])
    ]
    if not differ:
        return ("harmless", "") if len(good) == len(expected) else ("refused", "")
    status, said = command(folder, "store", "verify")
    return ("found", said) if status == 1 else ("silent", f"{differ} differ; verify says {said[-200:]}")


def run_doors(number: int, seed: int, ask: Callable[[Path], Answers]) -> Report:
    """Damage copies of a store, one at a time, and ask each."""
    report = Report()
    with tempfile.TemporaryDirectory() as made:
        whole, folder = Path(made, "whole"), Path(made, "case")
        make_store(whole)
        with closing(Store.open(whole)) as store:
            IDS[:] = [store.find("done").id]
            store.set_state(store.find("new").id, "cancelled")  # else whoever serves it would run it
        case = folder / "store"
        shutil.copytree(whole, case)
        expected = ask(folder)
        assert all(status in (0, 200) for status, _ in expected.values()), expected
        for file, what in cases(whole, case, number, seed):
            report.add(file, what, judge(ask(folder), expected, folder))
    return report


def main() -> None:
    """Ask by commands and over HTTP, and print what came of it; status 1 where there was a defect."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--commands", type=int, default=60, help="flips that are asked about by commands")
    parser.add_argument("--http", type=int, default=30, help="flips that are asked about over HTTP")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    defects = 0
    for name, number, ask in (("commands", options.commands, by_commands), ("http", options.http, over_http)):
        report = run_doors(number, options.seed, ask)
        print(f"{name}:\n{report.table()}", flush=True)
        defects += len(report.defects)
    sys.exit(bool(defects))


if __name__ == "__main__":
    main()
