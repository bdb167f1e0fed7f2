"""Scenes that several processes are given: each is compiled by one of them. The cheapest serve, those of fixed steps."""

import fcntl
import os
import subprocess
import sys
import time
from pathlib import Path

import psutil
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


@pytest.mark.night
def test_a_process_that_compiles_ends_with_whoever_started_it(tmp_path: Path) -> None:
    """A command that is killed cannot end it: it would keep a core busy for minutes, for nobody."""
    folder = tmp_path / CACHE_FOLDER.name
    folder.mkdir(mode=0o700)
    code = (
        "import time; from damperlab.worker.scenes import scene_named as named; from damperlab.worker.warm import start_apart; "
        f"print(start_apart([named({SCENES[0].name!r})]).pid, flush=True); time.sleep(600)"
    )
    environment = os.environ | {"DAMPERLAB_CACHE_DIR": str(tmp_path)}
    with (folder / f"{SCENES[0].name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # so that it is not done first
        command = [sys.executable, "-c", code]
        with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) as starter:
            assert starter.stdout is not None
            compiles = psutil.Process(int(starter.stdout.readline()))
            starter.kill()
        compiles.wait(900.0)
    assert not (folder / marker(SCENES[0])).exists()


@pytest.mark.night
@pytest.mark.parametrize(("share", "others"), [(0.0, False), (1e3, True)])
def test_a_process_goes_on_with_that_in_which_the_same_acts_and_while_memory_is_left_with_others(
    share: float, others: bool, tmp_path: Path
) -> None:
    friction, linear, alike = SCENES
    names = [scene.name for scene in (linear, friction, alike)]
    code = (
        "from damperlab.worker import warm; from damperlab.worker.scenes import scene_named as named; "
        f"warm.SHARE = {share}; warm.warm_alike([named(name) for name in {names}])"
    )
    environment = os.environ | {"DAMPERLAB_CACHE_DIR": str(tmp_path)}
    subprocess.run([sys.executable, "-c", code], env=environment, check=True)
    folder = tmp_path / CACHE_FOLDER.name
    made = [folder / marker(scene) for scene in (linear, alike, friction)]
    assert [file.exists() for file in made] == [True, True, others]
    ended = [file.stat().st_mtime_ns for file in made[: 2 + others]]
    assert ended == sorted(ended)


@pytest.mark.night
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
