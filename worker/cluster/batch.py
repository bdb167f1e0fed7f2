"""Batch systems: the script of a job that runs a worker, its submission, and its cancellation."""

import math
import re
import shlex
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from damperlab.studies.faults import Fault
from damperlab.studies.vocabulary import BatchSystem
from damperlab.worker.outcomes import ClusterUnusable

COMMAND_SECONDS = 120.0
"""Longest time for an answer of a batch system; a busy one takes a while."""
MARGIN_SECONDS = 60.0
"""Time from the start of a job until Python starts to count a worker's lifetime, with a margin because a shared folder
loads slowly.
"""
LEAVE_SECONDS = 25.0
"""Longest time from the request to leave until a worker is gone."""
IDLE_SECONDS = 300.0
"""Time without a block, or without a scheduler, after which a worker exits."""
SHORTEST_SECONDS = MARGIN_SECONDS + LEAVE_SECONDS + 5.0
"""Shortest wall time in which a worker could compute anything."""


@dataclass(frozen=True)
class Jobs:
    """Requests to a batch system.

    Parameters
    ----------
    system : str
        The batch system.
    most : int
        Largest number of jobs that wait or run together; each is one worker on one core.
    fewest : int
        Smallest number of jobs, even if fewer blocks are left.
    wall_seconds : float
        Wall time of a job; its worker exits before.
    memory_bytes : int
        Memory of a job.
    options : str
        Further options of the batch system, as in "--partition=short --account=lab".
    """

    system: BatchSystem
    most: int = 16
    fewest: int = 0
    wall_seconds: float = 3600.0
    memory_bytes: int = 2 << 30
    options: str = ""


@dataclass(frozen=True)
class _Dialect:
    """Interface of one batch system; its commands read the script from standard input."""

    submit: tuple[str, ...]
    cancel: str
    directive: str
    lines: tuple[str, ...]
    array: str
    """The directive for jobs 1 to {count}."""
    task: str
    """The environment variable with the number of a job."""
    job: str
    """Pattern of the output of `submit`; its group is the identifier to which `cancel` is applied."""


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
    """Where the workers of jobs find their cluster.

    Parameters
    ----------
    scheduler : str
        Its address.
    tls : Path
        Folder with the certificates; the jobs' output is written beside it.
    """

    scheduler: str
    tls: Path


def worker_name(submission: int, task: int) -> str:
    """Name the worker of one job.

    Parameters
    ----------
    submission : int
        Number of the submission.
    task : int
        Number of the job within it, from 1.
    """
    return f"job-{submission}-{task}"


def script(jobs: Jobs, place: Place, submission: int, count: int, idle: bool) -> str:
    """Write the script of some jobs.

    Parameters
    ----------
    jobs : Jobs
        The requests.
    place : Place
        Where the workers find their cluster.
    submission : int
        Number of the submission, a part of the workers' names.
    count : int
        Number of jobs.
    idle : bool
        Whether the workers stay even if no blocks are left.
    """
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
    # PBS has no array of one job
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
    """Submit a script.

    Returns
    -------
    str
        The batch system's identifiers of the jobs.

    Raises
    ------
    ClusterUnusable
        The batch system is missing, or refuses.
    """
    dialect = _DIALECTS[system]
    answer = _call(system, dialect.submit, text)
    found = re.search(dialect.job, answer)
    if found is None:
        raise _refused(system, dialect.submit[0], f"it answered {answer.strip()!r}, which names no job")
    return found[1]


def cancel(system: BatchSystem, job: str) -> None:
    """Cancel jobs, waiting and running ones.

    Raises
    ------
    ClusterUnusable
        The batch system refuses, for example because they have ended.
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
            # the coordinator handles Ctrl-C in a terminal, and cancels the jobs
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
        Fault(
            "cluster",
            f"{system!r}, whose command {command} failed ({reason})",
            f"a machine where {command} takes jobs",
            "start this on a login node, and set options that your batch system requires in "
            "DAMPERLAB_JOB_OPTIONS",
            f"The batch system {system} cannot be used: {command} failed ({reason}).",
        )
    )
