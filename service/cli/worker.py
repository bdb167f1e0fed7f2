"""Commands for your own cluster: worker, certificates."""

from pathlib import Path
from typing import Annotated

import typer

from damperlab.service.cli.failures import CommandFailed
from damperlab.service.cli.options import check_address
from damperlab.service.cli.output import say

Tls = Annotated[
    Path | None,
    typer.Option(
        "--tls",
        metavar="DIR",
        help="Folder from `damperlab admin certificates`; by default DAMPERLAB_CLUSTER_TLS.",
        show_default=False,
    ),
]


def worker(
    scheduler: Annotated[
        str,
        typer.Argument(
            metavar="ADDRESS",
            callback=check_address,
            help="Address of the Dask scheduler, as in tls://HOST:8786.",
            show_default=False,
        ),
    ],
    tls: Tls = None,
    lifetime: Annotated[
        float | None,
        typer.Option(
            min=1.0,
            help="Time in seconds within which the process ends, for example the wall time of a batch job. "
            "The worker begins to leave --leave-within seconds earlier.",
        ),
    ] = None,
    leave_within: Annotated[
        float,
        typer.Option(
            min=0.0,
            help="Longest time, in seconds, for leaving after SIGTERM, a notice or the end of the lifetime.",
        ),
    ] = 25.0,
    notice: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Leave the cluster as soon as this file exists, for example because a spot instance is "
            "about to be reclaimed.",
        ),
    ] = None,
    leave_idle: Annotated[
        float | None,
        typer.Option(
            min=1.0,
            help="Leave after this many seconds without a block, or without a scheduler that answers.",
            show_default=False,
        ),
    ] = None,
    alive: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Every ten seconds compute points with known values and touch this file; leave if the "
            "values are wrong. For health checks.",
            show_default=False,
        ),
    ] = None,
    memory_limit: Annotated[
        str, typer.Option(help="Memory limit of the worker in Dask's notation: auto, 4GB, or 0 for no limit.")
    ] = "auto",
    name: Annotated[
        str | None, typer.Option(help="Name of the worker in messages and logs.", show_default=False)
    ] = None,
) -> None:
    """Compute blocks for a scheduler, one by one. Before a worker leaves, it completes or returns its block."""
    from damperlab.worker.cluster.certificates import security
    from damperlab.worker.worker_process.worker import Terms, serve_worker

    notice = None if notice is None else notice.absolute()
    alive = None if alive is None else alive.absolute()
    terms = Terms(leave_within, lifetime, notice, leave_idle, alive)
    serve_worker(scheduler, security(tls, scheduler), terms, memory_limit, name)


def certificates(
    folder: Annotated[
        Path,
        typer.Argument(
            metavar="DIR", help="Folder for the certificates; it is created if missing.", show_default=False
        ),
    ],
    days: Annotated[int, typer.Option(min=1, help="Days until the certificates expire.")] = 3650,
) -> None:
    """Create a private certificate authority for one cluster, and the certificate of its members."""
    from damperlab.worker.cluster.certificates import make_certificates

    try:
        make_certificates(folder, days)
    except OSError as error:
        raise CommandFailed(
            "certificates-unusable",
            f"The certificates cannot be written to {str(folder)!r}: {error.strerror}. Name a folder that is new or empty.",
        ) from None
    say(
        f"{folder} holds ca.pem, cert.pem and key.pem. Copy the folder to every machine of the cluster, to a place that "
        f"no one else can read, and set DAMPERLAB_CLUSTER_TLS to its path there."
    )
