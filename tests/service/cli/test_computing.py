"""Studies that a command computes one after the other: a stop that is asked for holds for all that follow."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tests.service.cli.commands import LINEAR

from damperlab.service.cli.computing import Computer, Means
from damperlab.service.cli.run import find_or_submit
from damperlab.studies.definition import parse_study
from damperlab.studies.store.store import Store


class _StopsAtTheEnd:
    """Progress that asks the process to stop once every point is there."""

    def __init__(self, points: int) -> None:
        self._points = points
        self._asked = False

    def update(self, done: int, *_: Any) -> None:
        if done == self._points and not self._asked:
            self._asked = True  # asked twice it would end at once
            signal.raise_signal(signal.SIGTERM)


@contextmanager
def stopping(points: int) -> Iterator[Any]:
    yield _StopsAtTheEnd(points)


def test_a_stop_during_the_last_block_of_a_study_holds_for_the_next_study(tmp_path: Path) -> None:
    store = Store.open(tmp_path / "data")
    first, second = (parse_study(LINEAR | {"damping_ratio": each}) for each in (0.01, 0.02))
    with Computer(store, Means()) as computer:
        one = find_or_submit(store, first, False)
        assert computer.compute(one, shown=stopping(first.points)).state == "done"
        assert computer.compute(find_or_submit(store, second, False)).state == "queued"
    # whoever asks again has it computed
    with Computer(store, Means()) as computer:
        assert computer.compute(find_or_submit(store, second, False)).state == "done"
