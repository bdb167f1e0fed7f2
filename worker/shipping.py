"""Compiles kernels into the package's own folder, so that they need not be compiled after a wheel or an image is
installed.

Run `python -m damperlab.worker.shipping` before a wheel is built, or after one was installed into an image.
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
    """Compile the missing kernels of the package's folder, on every core, and remove kernels of other sources and
    versions.
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
