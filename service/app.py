"""Assembles, starts and stops the HTTP service."""

import asyncio
import logging
import os
import signal
import socket
import sys
import threading
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from typing import Any

import uvicorn
from anyio import CapacityLimiter, create_task_group
from anyio.to_thread import run_sync
from fastapi import FastAPI
from fastapi.middleware.cors import CORSMiddleware
from starlette.middleware.gzip import DEFAULT_EXCLUDED_CONTENT_TYPES

from damperlab.service import problems
from damperlab.service.access import AccessLog
from damperlab.service.cluster import SharedCluster, open_cluster
from damperlab.service.designer import Designer
from damperlab.service.dispatch import Dispatcher
from damperlab.service.documentation import PLACE, Documentation
from damperlab.service.edge.compression import Compressed
from damperlab.service.edge.conditional import Head, Tagged
from damperlab.service.edge.connection import Connection
from damperlab.service.edge.drain import Drain
from damperlab.service.edge.head import HEAD_LIMIT_BYTES, ShortHead
from damperlab.service.edge.policy import Policy
from damperlab.service.edge.silence import Silence
from damperlab.service.ending import end_by
from damperlab.service.examples import complete
from damperlab.service.kernels import Kernels
from damperlab.service.logs import start_logging
from damperlab.service.routes import (
    accuracy,
    answers,
    catalog,
    designs,
    earthquakes,
    export,
    fits,
    health,
    home,
    metrics,
    questions,
    refine,
    remarks,
    report,
    session,
    simulate,
    studies,
    zarr,
)
from damperlab.service.scrub import Scrub
from damperlab.service.security.gate import Gate
from damperlab.service.security.guard import Guard
from damperlab.service.security.shares import Shares
from damperlab.service.settings import Settings
from damperlab.service.state import Service
from damperlab.service.traffic import Traffic
from damperlab.service.work.functions import prepare
from damperlab.service.work.kept import Kept
from damperlab.service.work.later import Later, Promises
from damperlab.service.work.processes import Work
from damperlab.studies.store.care.sweep import remove_exports
from damperlab.studies.store.catalogue.access_keys import AccessKeys
from damperlab.worker.cores import core_count
from damperlab.worker.provenance import code_version

SUBMISSIONS = 16
"""Largest number of submissions served at the same time. The remaining threads serve other requests."""
EXPORTS = 2
"""Largest number of simultaneous exports of one caller."""
COMPILING = 8
"""Largest number of requests that wait for kernels at the same time."""
DRAIN_SECONDS = 10
"""Longest time that a shutdown waits for running requests before it stops the studies [s]."""
SHUTDOWN_SECONDS = 85
"""Longest duration of a shutdown [s]. The process is then ended, even if a thread is still running."""

_log = logging.getLogger("damperlab.edge")

DESCRIPTION = (
    "Parameter studies of a hybrid vibration damper: particle impact and Coulomb friction. A study is "
    "submitted and computed in blocks on a cluster. It can be queried for maps, curves and best designs "
    "while it runs and afterwards."
)


class Application(FastAPI):
    """FastAPI application that creates its OpenAPI document at the first request; the creation takes half a second."""

    _making = threading.Lock()

    def openapi(self) -> dict[str, Any]:
        """Return the OpenAPI document with examples. The first call creates the document."""
        with self._making:
            if self.openapi_schema is None:
                self.router.routes = [getattr(route, "analysed", route) for route in self.router.routes]
                complete(super().openapi())
            return super().openapi()


def create_app(settings: Settings) -> FastAPI:
    """Assemble the service, without opening the store or the cluster.

    Parameters
    ----------
    settings : Settings
        Data directory, cluster, and limits.

    Returns
    -------
    FastAPI
        ASGI application, which opens the store and resumes unfinished studies at startup, and stops running
        studies at shutdown.
    """
    app = Application(
        title="damperlab",
        version=code_version(),
        description=DESCRIPTION,
        lifespan=_lifespan,
        # FastAPI's documentation pages are disabled, because they load scripts from other hosts.
        docs_url=None,
        redoc_url=None,
        redirect_slashes=False,
        telemetry={
            "tracing": False,
            "metrics": False,
            "logs": False,
            "operation_spans": False,
            "auto_configure": False,
        },
    )
    app.state.settings = settings
    problems.install(app)
    # `include_router` cannot add late routes: it would call their functions without the parameters of the request
    for route in (
        home,
        catalog,
        studies,
        remarks,
        questions,
        report,
        refine,
        export,
        zarr,
        simulate,
        answers,
        earthquakes,
        designs,
        fits,
        accuracy,
        health,
        metrics,
        session,
    ):
        app.router.routes.extend(route.router.routes)
    if settings.docs_dir is not None:
        app.mount(PLACE, Documentation(settings.docs_dir))
    app.state.promises = Promises()
    app.add_middleware(Later, promises=app.state.promises)
    app.add_middleware(Tagged)
    app.add_middleware(
        Compressed,
        compresslevel=5,
        # Exports and chunks of cubes are compressed already.
        exclude_content_types=(*DEFAULT_EXCLUDED_CONTENT_TYPES, export.NETCDF, export.PARQUET, zarr.CHUNK),
    )
    app.add_middleware(Kept)
    app.add_middleware(Head)
    app.add_middleware(
        Shares, most={"events": settings.streams_per_caller, "export": settings.exports_per_caller}
    )
    app.state.guard = Guard(settings)
    app.add_middleware(Gate, guard=app.state.guard)
    app.add_middleware(Silence)
    if settings.cors_origins:
        app.add_middleware(
            CORSMiddleware,
            allow_origins=list(settings.cors_origins),
            allow_methods=["*"],
            allow_headers=["*"],
            expose_headers=["Location", "X-Request-ID"],
        )
    app.add_middleware(ShortHead)
    app.add_middleware(Drain)
    app.state.traffic = Traffic()
    app.state.addresses = {}
    app.add_middleware(AccessLog, traffic=app.state.traffic)
    app.add_middleware(Policy, shared=bool(settings.cors_origins))
    return app


@asynccontextmanager
async def _lifespan(app: FastAPI) -> AsyncIterator[None]:
    settings: Settings = app.state.settings
    runs = await run_sync(settings.open_store)
    wait = settings.catalogue_wait_seconds
    store = await run_sync(lambda: settings.open_store(wait_seconds=wait))
    with suppress(OSError):
        await run_sync(remove_exports, settings.data_dir)
    cluster = SharedCluster(lambda: open_cluster(settings, lambda: dispatcher.blocks_left()))
    dispatcher = Dispatcher(store, runs, cluster, settings.studies_at_once)
    kernels = Kernels(core_count())
    bounds = settings.work_seconds, settings.work_wait_seconds, settings.work_memory_bytes
    work = Work(core_count(), *bounds)
    designer = Designer(settings, store, dispatcher)
    scrub = Scrub(runs)
    service = Service(
        settings,
        store,
        dispatcher,
        work,
        Work(EXPORTS, *bounds),
        CapacityLimiter(COMPILING),
        CapacityLimiter(SUBMISSIONS),
        kernels,
        designer,
        scrub,
    )
    app.state.service = service
    app.state.guard.keys = AccessKeys(store.catalogue)
    dispatcher.start()
    designer.start()
    scrub.start()
    service.readiness.background.start()
    try:
        async with create_task_group() as background:
            if settings.warm:
                background.start_soon(_prepare, work, kernels)
            yield
            background.cancel_scope.cancel()
    finally:
        service.closing.set()
        service.readiness.background.tell_to_close()
        scrub.background.tell_to_close()
        await run_sync(scrub.close)
        await run_sync(kernels.close)
        await run_sync(designer.close)
        await run_sync(dispatcher.close)
        await run_sync(store.close)
        await run_sync(runs.close)


async def _prepare(work: Work, kernels: Kernels) -> None:
    """Import the modules for queries, compile kernels and start a worker process, before the first request needs them."""
    await run_sync(_import_questions, abandon_on_cancel=True)
    kernels.start()
    await work.start(prepare)


def _import_questions() -> None:
    import damperlab.service.questions.needed  # noqa: F401


class _Server(uvicorn.Server):
    """HTTP server that closes overdue connections.

    A shutdown ends the event streams, then waits until all other running requests are answered.
    """

    async def on_tick(self, counter: int) -> bool:
        """Close overdue connections once a second. The server calls this method ten times a second."""
        if counter % 10 == 0:
            now = time.monotonic()
            await asyncio.sleep(0.001)  # lets the loop read data that arrived while it was busy
            for connection in list(self.server_state.connections):
                assert isinstance(connection, Connection)
                try:
                    connection.overdue(now)
                except Exception:
                    # the service would end if an exception left this method
                    _log.exception("an overdue connection could not be closed")
                    connection.transport.abort()
        return await super().on_tick(counter)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        application = self.config.app
        assert isinstance(application, FastAPI)
        end_by(SHUTDOWN_SECONDS)
        application.state.service.closing.set()
        await super().shutdown(sockets)


def serve(settings: Settings) -> None:
    """Run the service until SIGINT or SIGTERM.

    The service then completes running requests, stops the studies and closes the cluster, in this order.

    Parameters
    ----------
    settings : Settings
        Settings of the service. If the port is 0, a free port is used and written to the log.

    Raises
    ------
    SystemExit
        With status 0 after SIGTERM, and with status 1 if the port or the data directory cannot be used.
    """
    start_logging(settings.log_level, settings.log_format)
    if threading.current_thread() is threading.main_thread():
        # uvicorn shuts down on SIGTERM and then raises the signal again; this handler makes the exit status 0
        signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(0))
    # other users must not read the files of the service and its workers
    os.umask(0o077)
    config = uvicorn.Config(
        create_app(settings),
        host=settings.host,
        port=settings.port,
        log_config=None,
        access_log=False,
        server_header=False,
        http=Connection,
        h11_max_incomplete_event_size=HEAD_LIMIT_BYTES,
        # uvicorn must ignore proxy headers, because `service.security.proxy` evaluates them
        proxy_headers=False,
        ws="none",
        lifespan="on",
        # longer than the usual timeout of clients: if the service closed an idle connection first, a request could be lost
        timeout_keep_alive=65,
        ssl_certfile=settings.tls_certificate,
        ssl_keyfile=settings.tls_key,
        timeout_graceful_shutdown=DRAIN_SECONDS,
    )
    try:
        _Server(config).run()
    except KeyboardInterrupt:
        # uvicorn raises this exception after a shutdown by Ctrl-C
        return
