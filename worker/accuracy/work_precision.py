"""Measurement of error, run time and order of convergence of every method on every scene."""

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
"""Least total time of repeated calls [s], because a call on the fastest scene takes only about a microsecond."""
SLOW_SECONDS = 0.3
"""Time above which a call is not repeated [s]."""
ROUNDING = 1e-16
"""Smallest relative error in the report, because the reference is rounded to doubles."""
FLOOR = 1e-11
"""Errors below this relative error are attributed to rounding and are omitted from the order of convergence."""
LARGEST = 0.3
"""Errors above this relative error belong to a different motion and are omitted from the order of convergence."""


@dataclass(frozen=True)
class Measurement:
    """One run of a method.

    Parameters
    ----------
    setting : float
        Value of the method's setting.
    error : float or None
        Largest difference of u, u', p, p' from the reference, relative to the largest of the four reference values.
        None if the method failed.
    microseconds : float
        Shortest run time per excitation cycle [µs].
    """

    setting: float
    error: float | None
    microseconds: float


@dataclass(frozen=True)
class Curve:
    """Measurements of a method on a scene.

    `order` is p in error ∝ setting⁻ᵖ, or None if fewer than three errors are usable.
    """

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
        """Return the diagram as JSON-able data."""
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
        Methods to measure, and scenes on which each method is measured.
    on_scene : callable
        Function called with the name of each scene before the methods run on the scene.
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
    """Measure a method on a scene, with each value of the method's setting."""
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
    """Return the shortest run time of a call [s] over at least `REPEATS` calls. A slow call is not repeated."""
    times: list[float] = []
    while len(times) < REPEATS or sum(times) < SHORTEST_SECONDS:
        began = perf_counter()
        call()
        times.append(perf_counter() - began)
        if times[0] > SLOW_SECONDS:
            break
    return min(times)


def observed_order(points: Sequence[Measurement]) -> float | None:
    """Return the order p of error ∝ setting⁻ᵖ, the median slope over all pairs of settings (Theil 1950, Sen 1968).

    If events are detected up to one step late, the error varies irregularly with the step. The median of the slopes is
    insensitive to single errors that are small by chance. Errors below `FLOOR` or above `LARGEST` are omitted.
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
