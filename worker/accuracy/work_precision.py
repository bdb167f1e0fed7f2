"""Error against run time of every method on every scene, and its order of convergence."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from math import isfinite, log
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np

from damperlab.worker.accuracy.cases import SCENES, Scene, references
from damperlab.worker.accuracy.methods import METHODS, Method

REPEATS = 5
SHORTEST_SECONDS = 0.02
"""A call is repeated until this time has been measured: clocks resolve microseconds, and the fastest scene takes
one.
"""
SLOW_SECONDS = 0.3
"""A call as long as this is not repeated."""
ROUNDING = 1e-16
"""Share of the state below which errors are not shown, because the reference is rounded to doubles."""
FLOOR = 1e-11
"""Relative errors below this are accumulated rounding and are not used for an order."""
LARGEST = 0.3
"""Relative errors above this mean a different motion, and are not used either."""


@dataclass(frozen=True)
class Measurement:
    """One run of a method.

    Parameters
    ----------
    setting : float
        Value of the method's setting.
    error : float or None
        Largest difference of u, u', p, p' from the reference over the reference's largest; None if the method
        failed.
    microseconds : float
        Per excitation cycle, the smallest of the repeats.
    """

    setting: float
    error: float | None
    microseconds: float


@dataclass(frozen=True)
class Curve:
    """A method on a scene; `order` is p in error ∝ setting⁻ᵖ, None with fewer than three usable errors."""

    method: str
    setting: str
    points: tuple[Measurement, ...]
    order: float | None


@dataclass(frozen=True)
class Diagram:
    """The curves of all methods on one scene."""

    scene: str
    title: str
    cycles: int
    curves: tuple[Curve, ...]

    def document(self) -> dict[str, Any]:
        """JSON-able."""
        return asdict(self)


def draw_diagrams(
    methods: Sequence[Method] = METHODS,
    scenes: Sequence[Scene] = SCENES,
    on_scene: Callable[[str], None] = lambda name: None,
) -> list[Diagram]:
    """Measure every method on every scene.

    Parameters
    ----------
    methods, scenes : sequence
        The methods, and the scenes.
    on_scene : callable
        Called with the name of each scene before its methods run.
    """
    diagrams = []
    for scene in scenes:
        on_scene(scene.name)
        diagrams.append(
            Diagram(
                scene.name, scene.title, scene.cycles, tuple(measure_method(one, scene) for one in methods)
            )
        )
    return diagrams


def measure_method(method: Method, scene: Scene) -> Curve:
    """Run a method on a scene with each value of its setting."""
    truth = np.array(references()[scene.name].state)
    scale = float(np.abs(truth).max())
    points = []
    for value in method.values:
        state = method.march(scene.design, scene.cycles, value)  # compiles the missing kernels
        seconds = _shortest(lambda v=value: method.march(scene.design, scene.cycles, v))  # type: ignore[misc]
        error = None
        if state is not None:
            error = max(float(np.abs(np.array(state) - truth).max()) / scale, ROUNDING)
            error = error if isfinite(error) else None
        points.append(Measurement(float(value), error, seconds / scene.cycles * 1e6))
    return Curve(
        method.name, method.setting, tuple(points), observed_order(points) if method.setting else None
    )


def _shortest(call: Callable[[], object]) -> float:
    """Smallest time of a call [s], over at least `REPEATS` calls unless a single one is long."""
    times: list[float] = []
    while len(times) < REPEATS or sum(times) < SHORTEST_SECONDS:
        began = perf_counter()
        call()
        times.append(perf_counter() - began)
        if times[0] > SLOW_SECONDS:
            break
    return min(times)


def observed_order(points: Sequence[Measurement]) -> float | None:
    """Order p of error ∝ setting⁻ᵖ: the median slope over all pairs of settings (Theil 1950, Sen 1968).

    If an event is detected up to a step late, the error varies irregularly with the step; a median of slopes is
    insensitive to a lucky run. Errors at the level of rounding, and those of a different motion, are left out.
    """
    usable = [(p.setting, p.error) for p in points if p.error is not None and FLOOR < p.error < LARGEST]
    if len(usable) < 3:
        return None
    slopes = [
        -(log(second[1]) - log(first[1])) / (log(second[0]) - log(first[0]))
        for i, first in enumerate(usable)
        for second in usable[i + 1 :]
    ]
    return median(slopes)
