"""Compiles kernels for a running service in separate processes, so that the service can answer requests meanwhile."""

import logging
import threading
import time
from collections.abc import Iterable, Sequence
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from subprocess import Popen

from damperlab.worker.scenes import Scene, usual_scenes

_log = logging.getLogger("damperlab.kernels")


class Kernels:
    """Compiles kernels in the background after the start, and when a request needs them.

    Parameters
    ----------
    at_once : int
        Largest number of processes that compile at the same time.
    """

    def __init__(self, at_once: int) -> None:
        self._pool = ThreadPoolExecutor(max(2, at_once), thread_name_prefix="compile")
        self._lock = threading.Lock()
        self._coming: dict[Scene, Future[None]] = {}
        self._processes: set[Popen[str]] = set()
        self._closed = False
        self._compiled = 0
        self._seconds = 0.0
        self._thread = threading.Thread(target=self._warm, name="kernels", daemon=True)

    def compiled(self) -> tuple[int, float]:
        """Return the number of scenes compiled since the start, and the total time of the compilations [s]."""
        with self._lock:
            return self._compiled, self._seconds

    def start(self) -> None:
        """Start separate processes that compile the kernels for requests with default settings."""
        self._thread.start()

    def require(self, wanted: Iterable[Scene]) -> None:
        """Compile the missing kernels of the given scenes, and wait until they are compiled.

        Errors are only logged. A process that needs a missing kernel compiles the kernel itself or reports the error.
        """
        from damperlab.worker.warm import missing  # imported in methods: the import loads the compiler

        for scene, future in [(scene, self._begin(scene)) for scene in missing(wanted)]:
            try:
                future.result()
            except (CancelledError, OSError, RuntimeError) as error:
                _log.warning("%s: %s", scene.name, error)

    def close(self) -> None:
        """Stop all compilations. No further compilation starts."""
        with self._lock:
            self._closed = True
            for process in self._processes:
                process.kill()
        self._pool.shutdown(cancel_futures=True)
        if self._thread.is_alive():
            self._thread.join()

    def _begin(self, scene: Scene) -> Future[None]:
        with self._lock:
            if scene in self._coming:
                return self._coming[scene]
            future = self._coming[scene] = self._pool.submit(self._compile_one, scene)
        return future

    def _compile_one(self, scene: Scene) -> None:
        try:
            self._compile([scene])
        finally:
            with self._lock:
                del self._coming[scene]

    def _compile(self, wanted: Sequence[Scene]) -> None:
        from damperlab.worker.warm import missing, require_done, start_apart

        with self._lock:
            if self._closed:
                return
            process = start_apart(wanted)
            self._processes.add(process)
        began = time.monotonic()
        try:
            require_done(process)
            ready = set(wanted) - set(missing(wanted))
            _log.info("the kernels of %s are ready", ", ".join(sorted(scene.name for scene in ready)))
        finally:
            with self._lock:
                self._compiled += len(wanted) - len(missing(wanted))
                self._seconds += time.monotonic() - began
                self._processes.discard(process)

    def _warm(self) -> None:
        from damperlab.worker.warm import missing

        lacking, before = missing(usual_scenes()), -1
        while lacking and len(lacking) != before and not self._closed:
            try:
                self._compile(lacking)
            except Exception as error:
                _log.warning(
                    "%s", error, exc_info=None if isinstance(error, OSError | RuntimeError) else error
                )
            lacking, before = missing(lacking), len(lacking)
