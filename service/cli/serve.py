"""The command serve: the HTTP service on this machine."""

from typing import Annotated

import typer

from service.cli.options import DataDir, QuotaBytes, Scheduler, StoreAddress, Workers, check_cluster
from service.cli.store import settings_of


def serve(
    port: Annotated[
        int | None, typer.Option(min=0, max=65535, help="Port; 0 takes a free one. 8000 by default.")
    ] = None,
    host: Annotated[
        str | None, typer.Option(help="Address to listen on; loopback by default, for there is no login.")
    ] = None,
    data_dir: DataDir = None,
    store: StoreAddress = None,
    quota: QuotaBytes = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
) -> None:
    """Serve studies over HTTP until Ctrl-C."""
    check_cluster(workers, scheduler)
    from service.app import serve as serve_until_stopped

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
    settings.open_store().close()  # one that cannot be used is told in a sentence, before anything listens
    serve_until_stopped(settings)
