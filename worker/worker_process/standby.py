"""A process that has loaded what a worker loads, and waits: processes in which blocks are computed apart are forked from it.

One that is started anew loads every library first, more than a second of CPU time; where half of a cluster is lost, as many at
once as blocks ran there. The process that waits is forked from a worker before that has a thread or a connection, shares its
memory, computes nothing itself, and ends when the worker does.
"""

import gc
import os
import signal
import socket
from collections.abc import Callable
from contextlib import suppress
from typing import IO, Any

TO_ALL = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
"""What whoever ends a worker sends to all of its processes; the one that waits goes with the worker, and not before."""


class Forked:
    """A process of its own, asked by `stdin`, that answers by `stdout`.

    Parameters
    ----------
    stdin, stdout, status : file
        Its input, its output, and where its keeper writes how it ended.
    """

    def __init__(self, stdin: IO[bytes], stdout: IO[bytes], status: IO[bytes]) -> None:
        self.stdin, self.stdout, self._status = stdin, stdout, status

    def __enter__(self) -> "Forked":
        """Use it; whoever did closes its input and its output."""
        return self

    def __exit__(self, *_: object) -> None:
        """Ask no more how it ended."""
        self._status.close()

    def wait(self) -> int:
        """Wait for its end, and give its status as `subprocess` does; that of a kill where its keeper is gone."""
        return int(self._status.read() or -signal.SIGKILL)


class Standby:
    """The process that waits.

    Parameters
    ----------
    main : callable
        What a process forked from it does: given the descriptors of its input and its output.
    """

    def __init__(self, main: Callable[[int, int], object]) -> None:
        self._socket, other = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        # what is loaded stays: to look through it for garbage would copy what both processes share
        gc.collect()
        gc.freeze()
        if os.fork() == 0:
            self._socket.close()
            _in_this_process(_serve, other, main)
        other.close()

    def fork(self) -> Forked | None:
        """Give a new process; None where the one that waits is gone."""
        (here_in, stdin), (stdout, here_out), (status, here_status) = os.pipe(), os.pipe(), os.pipe()
        there = [here_in, here_out, here_status]
        try:
            socket.send_fds(self._socket, [b"."], there)
        except OSError:
            for each in (stdin, stdout, status):
                os.close(each)
            return None
        finally:
            for each in there:
                os.close(each)
        return Forked(os.fdopen(stdin, "wb"), os.fdopen(stdout, "rb"), os.fdopen(status, "rb"))

    def close(self) -> None:
        """Let it end."""
        self._socket.close()


def _in_this_process(run: Callable[..., object], *arguments: Any) -> None:
    """Do something in a process that was forked, and end it: what its parent would do next is not for it."""
    status = 1
    with suppress(BaseException):
        run(*arguments)
        status = 0
    os._exit(status)


def _serve(connection: socket.socket, main: Callable[[int, int], object]) -> None:
    for number in TO_ALL:
        signal.signal(number, signal.SIG_IGN)
    # keepers are waited for by nobody
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    while True:
        told, descriptors, _, _ = socket.recv_fds(connection, 1, 3)
        if not told:
            return
        if os.fork() == 0:
            connection.close()
            _in_this_process(_keep, *descriptors, main)
        for each in descriptors:
            os.close(each)


def _keep(source: int, sink: int, status: int, main: Callable[[int, int], object]) -> None:
    """Fork the process, and write how it ended."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    child = os.fork()
    if child == 0:
        os.close(status)
        for number in TO_ALL:
            signal.signal(number, signal.SIG_DFL)
        _in_this_process(main, source, sink)
    # its output ends when it does
    os.close(source)
    os.close(sink)
    os.write(status, str(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])).encode())
