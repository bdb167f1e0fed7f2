"""`damperlab warm` compiles kernels in advance."""

import os
import time
from collections.abc import Iterable
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from damperlab.service.cli.options import AsJson
from damperlab.service.cli.output import duration, print_json, print_table, say, working
from damperlab.studies.faults import counted
from damperlab.worker.cores import core_count

if TYPE_CHECKING:
    from damperlab.worker.scenes import Scene

BYTES_PER_KILOBYTE = 1e3


class Target(StrEnum):
    """Processor for which kernels are compiled."""

    generic = "generic"


def warm(
    all_: Annotated[
        bool,
        typer.Option(
            "--all",
            help="Compile the kernels of every scene, that is, of every combination of friction, contact, "
            "excitation and results. By default only the usual scenes are compiled, for a study, a design, a "
            "point and an earthquake.",
        ),
    ] = False,
    target: Annotated[
        Target | None,
        typer.Option(
            help="Processor to compile for. Kernels for `generic` run on any processor of this architecture, but more "
            "slowly. For clusters in which some processors lack AVX2; see the page on clusters."
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Compile the kernels now, on every core.

    Later commands then need not wait for the compiler.
    """
    if target is not None:
        # the variable is read when the compiler is imported, in this process and in the processes that compile
        os.environ["DAMPERLAB_TARGET"] = target.value
    from damperlab.worker.jit import CACHE_FOLDER
    from damperlab.worker.scenes import every_scene, usual_scenes
    from damperlab.worker.warm import compile_apart, missing

    wanted = every_scene() if all_ else usual_scenes()
    lacking = missing(wanted)
    began = time.monotonic()
    compiled: dict[str, float] = {}
    with working(lambda: f"Compiling kernels, {len(compiled)} of {counted(len(lacking), 'scene')} done"):
        for scene, seconds in compile_apart(lacking, core_count()):
            compiled[scene.name] = seconds
    took = time.monotonic() - began
    size = sum(file.stat().st_size for file in CACHE_FOLDER.rglob("*.nb*"))
    if as_json:
        folder = str(CACHE_FOLDER)
        print_json(
            {"scenes": len(wanted), "compiled": compiled, "seconds": took, "folder": folder, "bytes": size}
        )
        return
    if compiled:
        print_table(("scene", "seconds"), ((name, f"{seconds:.1f}") for name, seconds in compiled.items()))
    ready = len(wanted) - len(compiled)
    say(
        f"{counted(len(wanted), 'scene')}: {ready} ready before, {len(compiled)} compiled in "
        f"{duration(took)}; {size / BYTES_PER_KILOBYTE:.0f} kB in {CACHE_FOLDER}."
    )


def have_ready(wanted: "Iterable[Scene]", apart: bool = False) -> None:
    """Compile the missing kernels that a command needs, and show the progress.

    Parameters
    ----------
    wanted : iterable of Scene
        Scenes that the command needs.
    apart : bool
        Whether to compile in separate processes on every core. Many scenes are then ready earlier, but the processes
        take more processor time in total than this process alone.
    """
    from damperlab.worker.warm import compile_apart, missing
    from damperlab.worker.warm import warm as compile_here

    lacking = missing(wanted)
    done: list[Scene] = []
    with working(lambda: f"Compiling kernels, {len(done)} of {counted(len(lacking), 'scene')} done"):
        if apart:
            for scene, _ in compile_apart(lacking, core_count()):
                done.append(scene)
            return
        for scene in lacking:
            compile_here(scene)
            done.append(scene)
