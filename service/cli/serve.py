"""The command serve: the HTTP service on this machine."""

import socket
from typing import Annotated

import typer

from damperlab.service.cli.failures import CommandFailed
from damperlab.service.cli.options import DataDir, QuotaBytes, Scheduler, StoreAddress, Workers, check_cluster
from damperlab.service.cli.store import settings_of


def serve(
    port: Annotated[
        int | None,
        typer.Option(min=0, max=65535, help="Port to listen on; 8000 by default, 0 for any free one."),
    ] = None,
    host: Annotated[str | None, typer.Option(help="Address to listen on; loopback by default.")] = None,
    data_dir: DataDir = None,
    store: StoreAddress = None,
    quota: QuotaBytes = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
) -> None:
    """Serve studies over HTTP until Ctrl-C."""
    check_cluster(workers, scheduler)
    from damperlab.service.app import serve as serve_until_stopped

    # What is not given here comes from the environment, DAMPERLAB_…, or the defaults.
    settings = settings_of(
        data_dir,
        store=store,
        quota_bytes=quota,
        port=port,
        host=host,
        workers=workers,
        scheduler=scheduler,
    )
    _check_port(settings.host, settings.port)
    settings.open_store().close()  # one that cannot be used is told in a sentence, before anything listens
    serve_until_stopped(settings)


def _check_port(host: str, port: int) -> None:
    """Refuse an address that cannot be listened on, before the cluster starts."""
    try:
        family, kind, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        with socket.socket(family, kind) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)  # as the server does
            probe.bind(address)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        text = (
            f"Cannot listen on {host}, port {port}: {reason}. Choose another with --port; 0 takes a free one."
        )
        raise CommandFailed("port-unusable", text) from None
