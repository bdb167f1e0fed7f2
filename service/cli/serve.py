"""`damperlab serve` runs the HTTP service on this machine."""

import gc
import socket
import ssl
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from damperlab.service.cli.failures import CommandFailed
from damperlab.service.cli.options import (
    Cluster,
    DataDir,
    QuotaBytes,
    Scheduler,
    StoreAddress,
    Workers,
    check_cluster,
)
from damperlab.service.cli.output import note
from damperlab.service.cli.store import settings_of

if TYPE_CHECKING:
    from damperlab.service.settings import Settings
    from damperlab.studies.store.store import Store


def serve(
    port: Annotated[
        int | None,
        typer.Option(min=0, max=65535, help="Port to listen on; 8000 by default, 0 for any free one."),
    ] = None,
    host: Annotated[str | None, typer.Option(help="Address to listen on; loopback by default.")] = None,
    open_: Annotated[
        bool,
        typer.Option("--open", help="Admit everyone who can reach the address, without keys."),
    ] = False,
    keys: Annotated[
        bool, typer.Option("--keys", help="Require keys on loopback too, for example behind a reverse proxy.")
    ] = False,
    hosts: Annotated[
        str | None, typer.Option(help="Further host names of the service, separated by commas.")
    ] = None,
    tls_certificate: Annotated[
        Path | None, typer.Option(help="Certificate chain in PEM, to serve HTTPS.", dir_okay=False)
    ] = None,
    tls_key: Annotated[
        Path | None, typer.Option(help="Private key of the certificate, in PEM.", dir_okay=False)
    ] = None,
    data_dir: DataDir = None,
    store: StoreAddress = None,
    quota: QuotaBytes = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    cluster: Cluster = None,
) -> None:
    """Show and compute studies in a browser and over HTTP."""
    check_cluster(workers, scheduler, cluster)
    if open_ and keys:
        raise typer.BadParameter("found --open and --keys; allowed: one of them")
    # Garbage collection of the imported modules would take an eighth of the start-up time.
    gc.disable()
    from damperlab.service.app import serve as serve_until_stopped

    gc.freeze()
    gc.enable()
    # Values that are not given here come from the environment, DAMPERLAB_…, or the defaults.
    settings = settings_of(
        data_dir,
        store=store,
        quota_bytes=quota,
        port=port,
        host=host,
        access="open" if open_ else "keys" if keys else None,
        hosts=hosts,
        tls_certificate=tls_certificate,
        tls_key=tls_key,
        workers=workers,
        scheduler=scheduler,
        cluster=cluster,
    )
    _check_port(settings.host, settings.port)
    _check_certificate(settings)
    opened = (
        settings.open_store()
    )  # a store that cannot be opened is reported in a sentence, before the service listens
    try:
        _check_access(settings, opened)
    finally:
        opened.close()
    serve_until_stopped(settings)


def _check_access(settings: "Settings", store: "Store") -> None:
    """Refuse to listen for other machines if there are no keys. With the option --open, only warn."""
    from damperlab.service.security.guard import needs_keys
    from damperlab.studies.store.catalogue.access_keys import AccessKeys

    if settings.access == "open" and not needs_keys(settings.model_copy(update={"access": "auto"})):
        return
    if settings.access == "open":
        note(
            f"damperlab: open to everyone who can reach {settings.host}: anyone may submit, cancel and "
            "delete."
        )
        return
    by_proxy = bool(settings.trusted_proxies and settings.proxy_user_header)
    if not needs_keys(settings) or by_proxy or any(key.valid for key in AccessKeys(store.catalogue).all()):
        return
    folder = f" --data-dir {settings.data_dir}"
    raise typer.BadParameter(
        f"found {settings.host} and no key; other machines can reach this address. Allowed: an address that "
        "only this machine can reach, for example 127.0.0.1, or keys. Make a key with "
        f"`damperlab admin keys create --owner NAME{folder}`, or add --open to admit everyone"
        if settings.access == "auto"
        else f"found no key. Make one with `damperlab admin keys create --owner NAME{folder}`",
        param_hint="--host" if settings.access == "auto" else "--keys",
    )


def _check_certificate(settings: "Settings") -> None:
    """Refuse an invalid certificate or key, or a pair that does not match."""
    if settings.tls_certificate is None or settings.tls_key is None:
        return
    try:
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(settings.tls_certificate, settings.tls_key, password=lambda: "")
    except (OSError, ValueError) as error:
        reason = getattr(error, "reason", None) or getattr(error, "strerror", None) or error
        raise typer.BadParameter(
            f"found {settings.tls_certificate} and {settings.tls_key}: {reason}; allowed: a certificate and its "
            "private key in PEM, without a password",
            param_hint="--tls-certificate",
        ) from None


def _check_port(host: str, port: int) -> None:
    """Refuse an address on which the service cannot listen, before the cluster starts."""
    try:
        family, kind, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        with socket.socket(family, kind) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)  # the server sets this option too
            probe.bind(address)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        text = (
            f"Cannot listen on {host}, port {port}: {reason}. Choose another port with --port; 0 takes a "
            "free one."
        )
        raise CommandFailed("port-unusable", text) from None
