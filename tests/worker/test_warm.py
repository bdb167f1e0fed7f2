"""Kernels made ready: by one process each, and a scene that is ready leaves nothing to compile."""

import fcntl
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import psutil
import pytest
from numba.core.event import install_recorder
from tests.worker.forms import night

from damperlab.studies.definition import parse_study
from damperlab.studies.ground.question import read_earthquake
from damperlab.studies.ground.shelf import Shelf
from damperlab.studies.plan import Block
from damperlab.worker.accuracy.cases import SCENES
from damperlab.worker.accuracy.extremes import Extreme
from damperlab.worker.accuracy.methods import METHODS, paper_march
from damperlab.worker.accuracy.stability import run_case
from damperlab.worker.accuracy.steady_answers import Point, compared
from damperlab.worker.block import solve_block
from damperlab.worker.ground.comparison import compare
from damperlab.worker.ground.comparison import scenes_of as scenes_of_comparison
from damperlab.worker.jit import CACHE_FOLDER
from damperlab.worker.point import Design
from damperlab.worker.scenes import Scene, accuracy_scenes, every_scene, scene_named, scenes, usual_scenes
from damperlab.worker.simulate import scenes_of, simulate
from damperlab.worker.solver.particle import Particle, Wall
from damperlab.worker.warm import compile_apart, is_ready, marker, missing, warm, warm_alike

PARTICLE = Particle(2.0, 0.47, 0.1)
DESIGNS = {
    "linear": Design(0.05, 1.0),
    "friction": Design(0.05, 1.0, 0.3),
    "particle": Design(0.05, 1.0, 0.0, PARTICLE),
    "hybrid": Design(0.05, 1.0, 0.3, PARTICLE),
    "massless": Design(0.05, 1.0, 0.0, PARTICLE._replace(mass_ratio=0.0)),
}


def compiled_by(act: Callable[[], object], wanted: list[Scene]) -> int:
    """Count what is compiled by an act whose scenes were made ready before."""
    for scene in wanted:
        warm(scene)
    assert all(map(is_ready, wanted))
    assert missing(wanted) == []
    with install_recorder("numba:compile") as recorder:
        act()
    return len(recorder.buffer)


@pytest.mark.parametrize("design", DESIGNS.values(), ids=DESIGNS)
@pytest.mark.parametrize(
    ("cycles", "history"),
    [(None, 0), (None, 2), (3, 0), (3, 2)],
    ids=["steady", "orbit", "transient", "history"],
)
def test_a_point_compiles_nothing_more(design: Design, cycles: int | None, history: int) -> None:
    assert compiled_by(lambda: simulate(design, cycles, history), scenes_of(design, cycles)) == 0


def test_a_point_by_fixed_steps_compiles_nothing_more() -> None:
    design = DESIGNS["hybrid"]
    wanted = scenes_of(design, 2, "rk4")
    assert compiled_by(lambda: simulate(design, 2, method="rk4"), wanted) == 0


@pytest.mark.night
def test_the_report_on_accuracy_compiles_nothing_more() -> None:
    contacts = (
        {"contact_time": None},
        {"contact_time": 0.1},
        {"contact_time": None, "wall": Wall(100.0, 1.0)},
    )
    particles = [None, *(PARTICLE._replace(**contact) for contact in contacts)]
    designs = [Design(0.05, 1.0, friction, particle) for friction in (0.0, 0.3) for particle in particles]

    def report() -> None:
        for design in designs:
            run_case(Extreme("", design, 2))
            if design.particle is None or design.particle.contact_time is None:
                paper_march(design, 2, 100)
            if design.friction_ratio or design.particle:
                compared(Point(0.05, 1.0, design.friction_ratio or None, design.particle), 64)
        for diagram_scene in SCENES:
            for method in METHODS:
                method.march(diagram_scene.design, 1, 100)

    assert compiled_by(report, accuracy_scenes()) == 0


FRICTION_ALONE = {"friction_ratio": [0, 0.3], "frequency_ratio": [0.9, 1.0]}
HYBRID = {"friction_ratio": 0.3, "mass_ratio": 0.1, "clearance_ratio": 2, "frequency_ratio": [0.9, 1.0]}


@pytest.mark.parametrize(
    "more",
    [
        {},
        {"metrics": ["amplitude_ratio"], "particle": False, "axes": FRICTION_ALONE},
        night({"metrics": ["amplitude_ratio"]}),
        night({"metrics": ["acceleration_ratio"], "axes": HYBRID}),
        night({"metrics": ["acceleration_ratio"]}),
        {"start": {"kind": "ensemble", "n": 2, "seed": 1}},
        {"start": {"kind": "continuation", "direction": "up"}},
        {"solver": {"method": "rk4", "steps_per_cycle": 50}},
    ],
    ids=[
        "whole",
        "peaks of friction",
        "peaks",
        "acceleration of a hybrid",
        "acceleration",
        "ensemble",
        "continuation",
        "stepped",
    ],
)
def test_a_block_compiles_nothing_more(more: dict[str, object]) -> None:
    axes = FRICTION_ALONE | {"mass_ratio": [0, 0.1], "clearance_ratio": 2}
    study = parse_study({"damping_ratio": 0.05, "axes": axes, "steady": {"max_cycles": 60}} | more)
    block = Block.whole(study.shape)
    assert compiled_by(lambda: solve_block(study, block), scenes(study)) == 0


def test_a_comparison_compiles_nothing_more(tmp_path) -> None:
    asked = read_earthquake({"record": "northridge", "starts": 1}, Shelf(tmp_path))
    wanted = scenes_of_comparison(asked)
    assert {scene.purpose for scene in wanted} == {"record"}
    assert compiled_by(lambda: compare(asked), wanted) == 0


def test_every_scene_has_its_own_name_what_is_usual_is_among_them_and_a_linear_study_needs_none() -> None:
    every = every_scene()
    assert len({scene.name for scene in every}) == len(every)
    assert all(scene_named(scene.name) == scene for scene in every)
    assert set(usual_scenes()) < set(every)
    assert {one for design in DESIGNS.values() for one in scenes_of(design)} <= set(usual_scenes())
    axes = {"friction_ratio": 0, "frequency_ratio": [0.8, 1]}
    assert scenes(parse_study({"damping_ratio": 0.05, "particle": False, "axes": axes})) == []


CHEAPEST = [scene_named(name) for name in ("rk4-friction", "rk4-linear", "stepped-linear")]


@pytest.fixture
def compiled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[Scene]:
    """Which scenes are compiled, one after the other, for a folder that holds none; nothing is compiled."""
    found: list[Scene] = []
    monkeypatch.setattr("damperlab.worker.warm.CACHE_FOLDER", tmp_path)
    monkeypatch.setattr("damperlab.worker.warm.shipped_folder", lambda: tmp_path / "none")
    monkeypatch.setattr("damperlab.worker.warm._compute_once", found.append)
    return found


def test_a_scene_that_another_process_compiles_is_left_to_it_and_waited_for_where_nothing_else_is_left(
    compiled: list[Scene], tmp_path: Path
) -> None:
    first, second, _ = CHEAPEST
    with (tmp_path / f"{first.name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        warm_alike([first, second])
        assert compiled == [second]
        assert float((tmp_path / marker(second)).read_text()) >= 0.0
        waits = threading.Thread(target=warm_alike, args=([first],))
        waits.start()
        waits.join(0.5)
        assert waits.is_alive()
        (tmp_path / marker(first)).touch()  # as the other process does once it is done
    waits.join()
    assert compiled == [second], "compiled twice"


@pytest.mark.parametrize(("share", "others"), [(0.0, False), (1e3, True)])
def test_a_process_goes_on_with_that_in_which_the_same_acts_and_while_memory_is_left_with_others(
    compiled: list[Scene], monkeypatch: pytest.MonkeyPatch, share: float, others: bool
) -> None:
    friction, linear, alike = CHEAPEST
    monkeypatch.setattr("damperlab.worker.warm.SHARE", share)
    warm_alike([linear, friction, alike])
    assert compiled == [linear, alike, friction][: 2 + others]


@pytest.mark.night
def test_a_process_that_compiles_ends_with_whoever_started_it(tmp_path: Path) -> None:
    """A command that is killed cannot end it: it would keep a core busy for minutes, for nobody."""
    folder = tmp_path / CACHE_FOLDER.name
    folder.mkdir(mode=0o700)
    code = (
        "import time; from damperlab.worker.scenes import scene_named as named; from damperlab.worker.warm import start_apart; "
        f"print(start_apart([named({CHEAPEST[0].name!r})]).pid, flush=True); time.sleep(600)"
    )
    environment = os.environ | {"DAMPERLAB_CACHE_DIR": str(tmp_path)}
    with (folder / f"{CHEAPEST[0].name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # so that it is not done first
        command = [sys.executable, "-c", code]
        with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) as starter:
            assert starter.stdout is not None
            compiles = psutil.Process(int(starter.stdout.readline()))
            starter.kill()
        compiles.wait(900.0)
    assert not (folder / marker(CHEAPEST[0])).exists()


@pytest.mark.night
def test_processes_share_what_they_are_given_and_say_how_long_each_took(tmp_path: Path) -> None:
    began = time.monotonic()
    ready = dict(compile_apart(CHEAPEST, 2, tmp_path))
    took = time.monotonic() - began
    assert sorted(ready) == sorted(CHEAPEST)
    assert all(0.0 < seconds <= took for seconds in ready.values())
    assert sum(ready.values()) <= 2.0 * took
    # nothing is left to compile: whoever is given the same ones only looks
    again = dict(compile_apart(CHEAPEST, 2, tmp_path))
    assert again == ready


def test_a_scene_that_cannot_be_compiled_is_named(tmp_path: Path) -> None:
    impossible = Scene("rk4", True, "dwell")  # fixed steps know no contact time
    assert impossible.name not in {scene.name for scene in CHEAPEST}
    with pytest.raises(RuntimeError, match="KeyError: 'rk4-friction-particle-dwell'"):
        list(compile_apart([impossible], 2, tmp_path))
