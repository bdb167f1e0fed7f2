"""Scenes that several processes are given: each is compiled by one of them. The cheapest serve, those of fixed steps."""

import fcntl
import subprocess
import time
from pathlib import Path

import pytest

from damperlab.worker.jit import CACHE_FOLDER
from damperlab.worker.scenes import Scene, scene_named
from damperlab.worker.warm import compile_apart, marker, require_done, start_apart

SCENES = [scene_named(name) for name in ("rk4-friction", "rk4-linear", "stepped-linear")]


def test_a_scene_that_another_process_compiles_is_left_to_it_and_waited_for_where_nothing_else_is_left(
    tmp_path: Path,
) -> None:
    folder = tmp_path / CACHE_FOLDER.name
    folder.mkdir(mode=0o700)
    first, second, _ = SCENES
    with (folder / f"{first.name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        require_done(start_apart([first, second], tmp_path))
        assert not (folder / marker(first)).exists()
        assert float((folder / marker(second)).read_text()) > 0.0
        process = start_apart([first], tmp_path)
        with pytest.raises(subprocess.TimeoutExpired):
            process.wait(3.0)
        (folder / marker(first)).touch()  # as the other process does once it is done
    require_done(process)
    assert (folder / marker(first)).read_text() == "", "compiled twice"


def test_a_process_compiles_that_in_which_the_same_acts_and_no_more(tmp_path: Path) -> None:
    friction, linear, alike = SCENES
    require_done(start_apart([linear, friction, alike], tmp_path))
    folder = tmp_path / CACHE_FOLDER.name
    assert [(folder / marker(scene)).exists() for scene in (linear, alike, friction)] == [True, True, False]


def test_processes_share_what_they_are_given_and_say_how_long_each_took(tmp_path: Path) -> None:
    began = time.monotonic()
    ready = dict(compile_apart(SCENES, 2, tmp_path))
    took = time.monotonic() - began
    assert sorted(ready) == sorted(SCENES)
    assert all(0.0 < seconds <= took for seconds in ready.values())
    assert sum(ready.values()) <= 2.0 * took
    # nothing is left to compile: whoever is given the same ones only looks
    again = dict(compile_apart(SCENES, 2, tmp_path))
    assert again == ready


def test_a_scene_that_cannot_be_compiled_is_named(tmp_path: Path) -> None:
    impossible = Scene("rk4", True, "dwell")  # fixed steps know no contact time
    assert impossible.name not in {scene.name for scene in SCENES}
    with pytest.raises(RuntimeError, match="KeyError: 'rk4-friction-particle-dwell'"):
        list(compile_apart([impossible], 2, tmp_path))
