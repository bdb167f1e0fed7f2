"""How every test draws its examples, and the order in which files begin.

Examples are the same ones each time, so that no run fails by chance; `HYPOTHESIS_PROFILE=explore` draws others on every
run, to look for what these leave out. The files that take longest begin first, by `durations.json`, so that no core waits
at the end for a long one that began late; `DAMPERLAB_DURATIONS=tests/durations.json make test` measures them anew.
"""

import gc
import json
import os
import sys
from collections import defaultdict

import pytest
from hypothesis import settings
from hypothesis.internal.conjecture import providers
from tests.durations import HERE, measured
from tests.ready import ready
from tests.spawning import fork_from

sys.dont_write_bytecode = (
    False  # what pytest makes of the tests takes half of the time of loading them: for the next run
)
gc.disable()  # nothing that is loaded or collected is garbage
fork_from(lambda: ready().loaded)
DEAREST = 10
"""Files that the end of a run names with their time."""
UNKNOWN_SECONDS = 10.0
"""Of a file that was never measured: before the many short ones, for it may be long."""

# Hypothesis also draws numbers that stand in the sources of whatever is loaded so far: another order of files, other examples.
assert callable(providers._get_local_constants)
providers._get_local_constants = lambda: providers._local_constants
settings.register_profile("fixed", derandomize=True, deadline=None, print_blob=True)
settings.register_profile("explore", deadline=None, max_examples=1000, print_blob=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "fixed"))

_measured: dict[str, float] = defaultdict(float)
_READY = pytest.StashKey[set[str]]()


@pytest.fixture
def anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have every process of a test started anew, none forked, as a child of whatever starts it."""
    monkeypatch.setenv("TESTS_ANEW", "1")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Sort files by how long they take, longest first; tests of a file stay in their order."""
    seconds = measured()
    items.sort(key=lambda item: -seconds.get(item.path.relative_to(HERE).as_posix(), UNKNOWN_SECONDS))


def pytest_collection_finish() -> None:
    """Let the garbage collector pass over what is loaded and collected, which stays until the end."""
    gc.freeze()
    gc.enable()


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Add up what a file's tests and their fixtures take."""
    _measured[report.nodeid.partition("::")[0].removeprefix("tests/")] += report.duration


def _scenes_ready() -> set[str]:
    """Name the scenes whose kernels are compiled."""
    from damperlab.worker.jit import CACHE_FOLDER

    return {file.stem for file in CACHE_FOLDER.glob("*.ready")}


def pytest_sessionstart(session: pytest.Session) -> None:
    """Note which kernels are there."""
    if not hasattr(session.config, "workerinput"):
        session.config.stash[_READY] = _scenes_ready()


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Print the files that took longest, and scenes that tests had to compile."""
    for name in sorted(_scenes_ready() - config.stash[_READY]):
        terminalreporter.write_line(f"{name} was compiled by a test: it belongs into tests/kernels.py")
    dearest = sorted(_measured.items(), key=lambda item: -item[1])[:DEAREST]
    for name, seconds in dearest if len(_measured) > DEAREST else ():
        terminalreporter.write_line(f"{seconds:8.1f} s  {name}")


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Keep what was measured, where that is wished; not in the processes that pytest-xdist starts."""
    name = os.environ.get("DAMPERLAB_DURATIONS")
    if name and not hasattr(session.config, "workerinput"):
        file = session.config.rootpath / name
        seconds: dict[str, float] = json.loads(file.read_text()) if file.exists() else {}
        seconds |= {test: round(taken, 1) for test, taken in _measured.items()}
        there = {test: taken for test, taken in sorted(seconds.items()) if (HERE / test).exists()}
        file.write_text(json.dumps(there, indent=1) + "\n")
