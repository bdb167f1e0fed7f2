"""The kernels that `make test` needs, compiled before it, so that no test waits for a compiler; those of the night need all.

A scene that a test needs beyond these is compiled as it is asked for; the end of a run names it.
"""

from damperlab.worker.cores import core_count
from damperlab.worker.scenes import scene_named
from damperlab.worker.warm import compile_apart, missing

SCENES = (
    "orbit-friction",
    "orbit-friction-particle-instant",
    "orbit-linear",
    "orbit-particle-instant",
    "peaks-friction",
    "peaks-friction-particle-instant",
    "peaks-friction-particle-rubbing",
    "peaks-particle-instant",
    "record-friction",
    "record-friction-particle-instant",
    "record-friction-particle-rubbing",
    "record-history-friction",
    "record-history-friction-particle-instant",
    "record-history-linear",
    "record-history-particle-rubbing",
    "record-linear",
    "record-particle-instant",
    "rk4-friction",
    "rk4-friction-particle-instant",
    "rk4-linear",
    "rk4-particle-instant",
    "steady-friction",
    "steady-friction-particle-instant",
    "steady-particle-instant",
    "stepped-friction",
    "stepped-friction-particle-instant",
    "stepped-linear",
    "stepped-particle-instant",
    "transient-friction",
    "transient-friction-particle-instant",
    "transient-friction-particle-rubbing",
    "transient-linear",
    "transient-particle-instant",
)
"""By name."""


def main() -> None:
    """Compile those that are missing, on every core, and say how long each took."""
    wanted = missing(map(scene_named, SCENES))
    for scene, seconds in compile_apart(wanted, core_count()):
        print(f"{scene.name:48}{seconds:8.1f} s", flush=True)
    print(f"{len(SCENES)} scenes, {len(wanted)} of them compiled")


if __name__ == "__main__":
    main()
