"""What others see of a design while the process at work on it goes on."""

import multiprocessing
from collections.abc import Iterator
from pathlib import Path

import pytest

from damperlab.service import design_run
from damperlab.service.settings import Settings
from damperlab.studies.design.shelf import Shelf
from damperlab.studies.specification.reading import read_specification


def test_a_design_is_running_also_while_all_that_it_asks_for_is_stored(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    settings = Settings(data_dir=tmp_path)
    shelf = Shelf(tmp_path)
    kept, _ = shelf.put(read_specification("prototype"), 1000)
    seen: list[str] = []

    def a_search_that_asks_for_nothing(*_: object) -> Iterator[object]:
        seen.append(shelf.get(kept.id).state)
        raise design_run._Over
        yield

    monkeypatch.setattr(design_run, "designing", a_search_that_asks_for_nothing)
    for changed in ("stand_back", "_bound_memory", "start_logging"):  # this process goes on with other tests
        monkeypatch.setattr(design_run, changed, lambda *_: None)
    monkeypatch.setattr(design_run.signal, "signal", lambda *_: None)
    _, wake = multiprocessing.Pipe(duplex=False)
    assert shelf.get(kept.id).state == "queued"
    design_run.run_design(settings, kept.id, wake)
    assert seen == ["running"]
