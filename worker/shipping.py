"""Compilation of kernels into the folder of the package, so that an installed wheel or image needs no compilation.

Run `python -m damperlab.worker.shipping` before building a wheel, or after installing a wheel into an image.
"""

import shutil
import stat
import time
from pathlib import Path

from damperlab.worker.cores import core_count
from damperlab.worker.jit import shipped_folder
from damperlab.worker.scenes import every_scene
from damperlab.worker.warm import compile_apart, marker

KILOBYTE = 1e3


def ship() -> None:
    """Compile missing kernels into the folder of the package, on all cores.

    Kernels that were compiled from other sources are removed first.
    """
    folder = shipped_folder()
    if folder.parent.exists():
        for other in folder.parent.iterdir():
            if other != folder:
                shutil.rmtree(other)
    began = time.monotonic()
    lacking = [scene for scene in every_scene() if not (folder / marker(scene)).exists()]
    for number, (scene, seconds) in enumerate(compile_apart(lacking, core_count(), folder.parent), 1):
        print(f"{number} of {len(lacking)}: {scene.name}, {seconds:.1f} s", flush=True)
    for lock in folder.glob("*.lock"):
        lock.unlink()
    _let_everybody_read(folder.parent)
    size = sum(file.stat().st_size for file in folder.iterdir())
    took = time.monotonic() - began
    print(f"{len(every_scene())} scenes, {size / KILOBYTE:.0f} kB in {folder}, {took:.0f} s")


def _let_everybody_read(top: Path) -> None:
    for place in (top, *top.rglob("*")):
        more = stat.S_IRGRP | stat.S_IROTH | (stat.S_IXGRP | stat.S_IXOTH if place.is_dir() else 0)
        place.chmod(place.stat().st_mode | more)


if __name__ == "__main__":
    ship()
