"""Computes a block in a separate process, so that its effect on that process is visible and harmless.

A lost worker may have been killed by its block, switched off with its machine, or asked to leave: all three look alike
from outside. If a process ends by a signal and its parent survives, either its computation crashed, or the system
ended it to free memory.
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
"""Signals that are sent to all processes of a worker to end it."""


def call_apart(function: Callable[..., Any], *arguments: Any) -> Any:
    """Call a function in a separate process, which ends with this one.

    Parameters
    ----------
    function : callable
        The function.
    *arguments : object
        Its arguments.

    Returns
    -------
    object
        What the function returned.

    Raises
    ------
    Crashed
        The process ended during the call.
    Leaving
        It was asked to end by another process.
    Exception
        What the function raised.
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
            pass  # its exit status tells more
        # its standard input stays open; the process ends when it is closed, for example by the death of this process
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
    """Read a call from one descriptor, write its result to another, and end the process."""
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
        # the reading thread would prevent the interpreter from ending cleanly
        os._exit(0)


def _end_with_parent(source: int) -> None:
    os.read(source, 1)
    os._exit(1)


if __name__ == "__main__":
    # the function's output goes to the log, not into the answer
    answer_to = os.dup(1)
    os.dup2(2, 1)
    _answer(0, answer_to)
