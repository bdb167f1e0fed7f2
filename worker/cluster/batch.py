"""Writes, submits and cancels jobs of the batch system Slurm. Each job runs one worker."""

import math
import re
import shlex
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from damperlab.worker.outcomes import ClusterUnusable

COMMAND_SECONDS = 120.0
"""Longest wait for a command of Slurm [s]. A busy batch system answers slowly."""
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
    """Settings of the jobs that are submitted to Slurm.

    Parameters
    ----------
    most : int
        Largest number of jobs that wait or run at the same time. Each job runs one worker on one core.
    wall_seconds : float
        Wall time of a job [s]. The worker exits before this time.
    memory_bytes : int
        Memory of a job.
    options : str
        Further options of Slurm, for example "--partition=short --account=lab".
    """

    most: int = 16
    wall_seconds: float = 3600.0
    memory_bytes: int = 2 << 30
    options: str = ""


_DIRECTIVES = """\
#SBATCH --job-name=damperlab
#SBATCH --ntasks=1 --cpus-per-task=1 --mem={megabytes}M
#SBATCH --time={hours:02d}:{minutes:02d}:{seconds:02d}
#SBATCH --output={folder}/%A-%a.log
#SBATCH --export=ALL
#SBATCH --array=1-{count}
"""
"""Beginning of a batch script. The array has jobs with the numbers 1 to {count}."""


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


def worker_name(submission: int, task: int | str) -> str:
    """Return the name of a worker from the number of its submission and the number of its job. Jobs count from 1."""
    return f"job-{submission}-{task}"


def script(jobs: Jobs, place: Place, submission: int, count: int) -> str:
    """Return a batch script for `count` jobs."""
    whole = math.floor(jobs.wall_seconds)
    directives = _DIRECTIVES.format(
        megabytes=math.ceil(jobs.memory_bytes / (1 << 20)),
        hours=whole // 3600,
        minutes=whole // 60 % 60,
        seconds=whole % 60,
        folder=place.tls.parent,
        count=count,
    )
    if jobs.options:
        directives += f"#SBATCH {jobs.options}\n"
    lifetime = jobs.wall_seconds - MARGIN_SECONDS
    command = [
        *(sys.executable, "-m", "damperlab", "admin", "worker", place.scheduler),
        *("--tls", str(place.tls)),
        *("--lifetime", f"{lifetime:g}"),
        *("--leave-within", f"{LEAVE_SECONDS:g}"),
        *("--leave-idle", f"{IDLE_SECONDS:g}"),
        *("--memory-limit", f"{jobs.memory_bytes}B"),
    ]
    name = worker_name(submission, "${SLURM_ARRAY_TASK_ID}")
    return f'#!/bin/sh\n{directives}exec {shlex.join(command)} --name "{name}"\n'


def submit(text: str) -> str:
    """Submit a batch script, and return the identifier that Slurm gives to the submitted jobs.

    Raises
    ------
    ClusterUnusable
        If the command is missing or fails.
    """
    # the command reads the script from standard input
    answer = _call(("sbatch", "--parsable"), text)
    found = re.search(r"\d+", answer)
    if found is None:
        raise _refused("sbatch", f"it answered {answer.strip()!r}, which names no job")
    return found[0]


def cancel(job: str) -> None:
    """Cancel all waiting and running jobs of a submission, given their identifier from `submit`.

    Raises
    ------
    ClusterUnusable
        If the command fails, for example because the jobs have ended.
    """
    _call(("scancel", job), "")


def _call(command: tuple[str, ...], text: str) -> str:
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
        raise _refused(command[0], "there is no such command on this machine") from None
    except (OSError, subprocess.TimeoutExpired) as error:
        raise _refused(command[0], str(error)) from None
    if done.returncode:
        said = (done.stderr or done.stdout).strip()
        raise _refused(command[0], said or f"it ended with status {done.returncode}")
    return done.stdout


def _refused(command: str, reason: str) -> ClusterUnusable:
    return ClusterUnusable(
        "cluster",
        f"'slurm', whose command {command} failed ({reason})",
        f"a machine where {command} takes jobs",
        "start this on a login node, and set options that your Slurm requires in DAMPERLAB_JOB_OPTIONS",
        f"Slurm cannot be used: {command} failed ({reason}).",
    )
