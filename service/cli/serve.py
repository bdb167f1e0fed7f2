"""The command serve: the HTTP service on this machine."""

from typing import Annotated, Any

import typer

from service.cli.options import DataDir, Scheduler, Workers, check_cluster


def serve(
    port: Annotated[
        int | None, typer.Option(min=0, max=65535, help="Port; 0 takes a free one. 8000 by default.")
    ] = None,
    host: Annotated[
        str | None, typer.Option(help="Address to listen on; loopback by default, for there is no login.")
    ] = None,
    data_dir: DataDir = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
) -> None:
    """Serve studies over HTTP until Ctrl-C."""
    check_cluster(workers, scheduler)
    from service.app import serve as serve_until_stopped
    from service.settings import Settings

    given: dict[str, Any] = {
        "port": port,
        "host": host,
        "data_dir": data_dir,
        "workers": workers,
        "scheduler": scheduler,
    }
    # What is not given here comes from the environment, DAMPERLAB_…, or the defaults.
    serve_until_stopped(Settings(**{name: value for name, value in given.items() if value is not None}))
