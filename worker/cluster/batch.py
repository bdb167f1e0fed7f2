"""Writes, submits and cancels jobs of a batch system. Each job runs one worker."""

import math
import re
import shlex
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from damperlab.studies.vocabulary import BatchSystem
from damperlab.worker.outcomes import ClusterUnusable

COMMAND_SECONDS = 120.0
"""Longest wait for a command of a batch system [s]. A busy batch system answers slowly."""
MARGIN_SECONDS = 60.0
"""Time by which the lifetime of a worker is shorter than the wall time of its job [s]. The lifetime begins
when the worker starts, and Python may start slowly.
"""
LEAVE_SECONDS = 25.0
"""Longest time that a worker takes to end after it was asked to leave [s]."""
IDLE_SECONDS = 300.0
"""Time without a block, or without a scheduler, after which a worker exits [s]."""
SHORTEST_SECONDS = MARGIN_SECONDS + LEAVE_SECONDS + 5.0
"""Shortest permitted wall time of a job [s]."""


@dataclass(frozen=True)
class Jobs:
    """Settings of the jobs that are submitted to a batch system.

    Parameters
    ----------
    system : str
        Name of the batch system.
    most : int
        Largest number of jobs that wait or run at the same time. Each job runs one worker on one core.
    fewest : int
        Smallest number of jobs, even if fewer blocks are left.
    wall_seconds : float
        Wall time of a job [s]. The worker exits before this time.
    memory_bytes : int
        Memory of a job.
    options : str
        Further options of the batch system, for example "--partition=short --account=lab".
    """

    system: BatchSystem
    most: int = 16
    fewest: int = 0
    wall_seconds: float = 3600.0
    memory_bytes: int = 2 << 30
    options: str = ""


@dataclass(frozen=True)
class _Dialect:
    """Commands and directives of one batch system. The command `submit` reads the script from standard input."""

    submit: tuple[str, ...]
    cancel: str
    directive: str
    lines: tuple[str, ...]
    array: str
    """Directive for an array of jobs with numbers 1 to {count}."""
    task: str
    """Environment variable that contains the number of a job in the array."""
    job: str
    """Regular expression for the output of `submit`. The group of the expression is the identifier for `cancel`."""


_DIALECTS: dict[BatchSystem, _Dialect] = {
    "slurm": _Dialect(
        ("sbatch", "--parsable"),
        "scancel",
        "#SBATCH",
        (
            "--job-name=damperlab",
            "--ntasks=1 --cpus-per-task=1 --mem={megabytes}M",
            "--time={hours:02d}:{minutes:02d}:{seconds:02d}",
            "--output={folder}/%A-%a.log",
            "--export=ALL",
        ),
        "--array=1-{count}",
        "SLURM_ARRAY_TASK_ID",
        r"(\d+)",
    ),
    "pbs": _Dialect(
        ("qsub",),
        "qdel",
        "#PBS",
        (
            "-N damperlab",
            "-l select=1:ncpus=1:mem={megabytes}mb",
            "-l walltime={hours:02d}:{minutes:02d}:{seconds:02d}",
            "-j oe -o {folder}/",
            "-V",
        ),
        "-J 1-{count}",
        "PBS_ARRAY_INDEX",
        r"(\d+(?:\[\])?\S*)",
    ),
}


@dataclass(frozen=True)
class Place:
    """Data that the worker of a job needs to join its cluster.

    Parameters
    ----------
    scheduler : str
        Address of the scheduler.
    tls : Path
        Folder with the certificates. The jobs' output is written to the parent folder.
    """

    scheduler: str
    tls: Path


def worker_name(submission: int, task: int) -> str:
    """Return the name of a worker from the number of its submission and the number of its job. Jobs count from 1."""
    return f"job-{submission}-{task}"


def script(jobs: Jobs, place: Place, submission: int, count: int, idle: bool) -> str:
    """Return a batch script for `count` jobs. If `idle` is true, workers without work do not exit early."""
    dialect = _DIALECTS[jobs.system]
    whole = math.floor(jobs.wall_seconds)
    numbers = {
        "megabytes": math.ceil(jobs.memory_bytes / (1 << 20)),
        "hours": whole // 3600,
        "minutes": whole // 60 % 60,
        "seconds": whole % 60,
        "folder": place.tls.parent,
        "count": count,
    }
    lines = [line.format(**numbers) for line in dialect.lines]
    # PBS does not accept an array of a single job
    if count > 1 or jobs.system != "pbs":
        lines.append(dialect.array.format(**numbers))
    if jobs.options:
        lines.append(jobs.options)
    lifetime = jobs.wall_seconds - MARGIN_SECONDS
    command = [
        *(sys.executable, "-m", "damperlab", "admin", "worker", place.scheduler),
        *("--tls", str(place.tls)),
        *("--lifetime", f"{lifetime:g}"),
        *("--leave-within", f"{LEAVE_SECONDS:g}"),
        *(() if idle else ("--leave-idle", f"{IDLE_SECONDS:g}")),
        *("--memory-limit", f"{jobs.memory_bytes}B"),
    ]
    name = worker_name(submission, 0).removesuffix("0") + f'"${{{dialect.task}:-1}}"'
    told = "\n".join(f"{dialect.directive} {line}" for line in lines)
    return f"#!/bin/sh\n{told}\nexec {shlex.join(command)} --name {name}\n"


def submit(system: BatchSystem, text: str) -> str:
    """Submit a batch script, and return the identifier that the batch system gives to the submitted jobs.

    Raises
    ------
    ClusterUnusable
        If the command of the batch system is missing or fails.
    """
    dialect = _DIALECTS[system]
    answer = _call(system, dialect.submit, text)
    found = re.search(dialect.job, answer)
    if found is None:
        raise _refused(system, dialect.submit[0], f"it answered {answer.strip()!r}, which names no job")
    return found[1]


def cancel(system: BatchSystem, job: str) -> None:
    """Cancel all waiting and running jobs of a submission, given their identifier from `submit`.

    Raises
    ------
    ClusterUnusable
        If the command fails, for example because the jobs have ended.
    """
    _call(system, (_DIALECTS[system].cancel, job), "")


def _call(system: BatchSystem, command: tuple[str, ...], text: str) -> str:
    try:
        done = subprocess.run(
            command,
            input=text,
            capture_output=True,
            text=True,
            timeout=COMMAND_SECONDS,
            check=False,
            # Ctrl-C in a terminal must not reach the command; the coordinator handles it and cancels the jobs
            start_new_session=True,
        )
    except FileNotFoundError:
        raise _refused(system, command[0], "there is no such command on this machine") from None
    except (OSError, subprocess.TimeoutExpired) as error:
        raise _refused(system, command[0], str(error)) from None
    if done.returncode:
        said = (done.stderr or done.stdout).strip()
        raise _refused(system, command[0], said or f"it ended with status {done.returncode}")
    return done.stdout


def _refused(system: BatchSystem, command: str, reason: str) -> ClusterUnusable:
    return ClusterUnusable(
        "cluster",
        f"{system!r}, whose command {command} failed ({reason})",
        f"a machine where {command} takes jobs",
        "start this on a login node, and set options that your batch system requires in "
        "DAMPERLAB_JOB_OPTIONS",
        f"The batch system {system} cannot be used: {command} failed ({reason}).",
    )
