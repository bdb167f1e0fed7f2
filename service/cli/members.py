"""Commands for a cluster of one's own: worker, certificates."""

from pathlib import Path
from typing import Annotated

import typer

from damperlab.service.cli.failures import CommandFailed
from damperlab.service.cli.output import say

Tls = Annotated[
    Path | None,
    typer.Option(
        "--tls",
        metavar="DIR",
        help="Folder made by `damperlab certificates`; DAMPERLAB_CLUSTER_TLS by default.",
        show_default=False,
    ),
]


def worker(
    scheduler: Annotated[
        str,
        typer.Argument(
            metavar="ADDRESS", help="Of the Dask scheduler, as in tls://HOST:8786.", show_default=False
        ),
    ],
    tls: Tls = None,
    lifetime: Annotated[
        float | None,
        typer.Option(
            min=1.0,
            help="Leave so that the process is gone after so many seconds, before a batch system ends it.",
        ),
    ] = None,
    leave_within: Annotated[
        float,
        typer.Option(
            min=0.0,
            help="Most seconds from being told to leave (SIGTERM, a notice, the lifetime) until it is gone.",
        ),
    ] = 25.0,
    notice: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Leave the cluster as soon as this file exists, as when a spot instance is about to be reclaimed.",
        ),
    ] = None,
    memory_limit: Annotated[str, typer.Option(help="As Dask takes it: auto, 4GB, 0 for none.")] = "auto",
    name: Annotated[str | None, typer.Option(help="What to call it.", show_default=False)] = None,
) -> None:
    """Compute blocks for a scheduler, one at a time, until told to leave; then end or give back the running one."""
    from damperlab.worker.certificates import security
    from damperlab.worker.member import Terms, serve_worker

    terms = Terms(leave_within, lifetime, None if notice is None else notice.absolute())
    serve_worker(scheduler, security(tls), terms, memory_limit, name)


def certificates(
    folder: Annotated[
        Path,
        typer.Argument(
            metavar="DIR", help="Where to put them; made where it is missing.", show_default=False
        ),
    ],
    days: Annotated[int, typer.Option(min=1, help="How long they hold.")] = 3650,
) -> None:
    """Make a private certificate authority for one cluster, and what its members show."""
    from damperlab.worker.certificates import make_certificates

    try:
        make_certificates(folder, days)
    except OSError as error:
        raise CommandFailed(
            "certificates-unusable",
            f"The certificates cannot be written to {str(folder)!r}: {error.strerror}. Name a folder that is new or empty.",
        ) from None
    say(
        f"{folder} holds ca.pem, cert.pem and key.pem. Copy it to every machine of the cluster, where no one else can read "
        f"it, and set DAMPERLAB_CLUSTER_TLS to its path there."
    )
