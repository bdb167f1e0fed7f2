"""Computes a block in a separate process, so that a block that crashes does not end its worker.

If a worker is lost, the coordinator cannot see the reason. The block may have crashed, the machine may have been
switched off, or the worker may have been asked to leave. If a signal ends a separate process and the worker
survives, either the block has crashed, or the system has killed the process to free memory.
"""

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from typing import Any

import cloudpickle

from damperlab.worker.outcomes import Crashed, Leaving

_TO_ALL = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
"""Signals that the system sends to all processes of a worker in order to end the worker."""


def call_apart(function: Callable[..., Any], *arguments: Any) -> Any:
    """Call a function in a separate process, which ends with this process, and return the function's result.

    Raises
    ------
    Crashed
        If the separate process ended during the call.
    Leaving
        If another process asked the separate process to end.
    Exception
        Any exception that the function raised.
    """
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    process = subprocess.Popen(
        [sys.executable, "-m", "damperlab.worker.worker_process.block_process"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=environment,
    )
    assert process.stdin is not None
    assert process.stdout is not None
    with process, process.stdin, process.stdout:
        asked = cloudpickle.dumps((function, arguments))
        try:
            process.stdin.write(len(asked).to_bytes(8, "big") + asked)
            process.stdin.flush()
        except BrokenPipeError:
            pass  # the exit status of the process gives the reason
        # the separate process ends when its standard input is closed, for example because this process has ended
        answer = process.stdout.read()
        status = process.wait()
    if status != 0 or not answer:
        if -status in _TO_ALL:
            raise Leaving(f"the process of a block was ended by {signal.Signals(-status).name}")
        how = f"by {signal.Signals(-status).name}" if status < 0 else f"with status {status}"
        raise Crashed(f"ended {how}: it crashed, was killed, or ran out of memory")
    well, value = cloudpickle.loads(answer)
    if not well:
        raise value
    return value


def _answer(source: int, sink: int) -> None:
    """Read a function call from the descriptor `source`, write its result to `sink`, and end the process."""
    with os.fdopen(source, "rb") as calls:
        asked = calls.read(int.from_bytes(calls.read(8), "big"))
        threading.Thread(target=_end_with_parent, args=(source,), daemon=True).start()
        try:
            function, arguments = cloudpickle.loads(asked)
            told = True, function(*arguments)
        except Exception as error:
            told = False, error
        with os.fdopen(sink, "wb") as out:
            out.write(cloudpickle.dumps(told))
        # the interpreter could not exit normally while the thread reads standard input
        os._exit(0)


def _end_with_parent(source: int) -> None:
    os.read(source, 1)
    os._exit(1)


if __name__ == "__main__":
    # what the function prints goes to standard error, because standard output carries the answer
    answer_to = os.dup(1)
    os.dup2(2, 1)
    _answer(0, answer_to)
