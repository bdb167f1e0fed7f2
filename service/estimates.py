"""Estimates the cost of a study, and checks whether the kernels for a request are compiled."""

from collections.abc import Sequence
from typing import Any, Literal

from typing_extensions import TypedDict

from damperlab.studies.digest import family_digest
from damperlab.studies.kind import AnyStudy
from damperlab.studies.plan import Plan
from damperlab.studies.shapes import Count, Measured, Sentences
from damperlab.studies.store.cube.description import bytes_per_point
from damperlab.studies.store.reuse import done_of_family
from damperlab.studies.store.store import Store
from damperlab.studies.understood import understood
from damperlab.worker.dispatch.cost_model import family_factor
from damperlab.worker.provenance import provenance
from damperlab.worker.scenes import Scene, scenes

DOUBT, DOUBT_KNOWING = 4.0, 2.5
"""The computing time rarely differs from its estimate by more than these factors. The first factor applies to
an estimate from the cost model alone, the second if a study of the same family was measured. In a test with
32 random studies, the first factor held for 27 of the estimates from the cost model alone, and the second for
31 of the estimates after a measurement.
"""


class Estimate(TypedDict):
    """Cost of a study."""

    digest: str
    points: Count
    points_stored: Count
    blocks: Count
    bytes: Count
    seconds: Measured
    seconds_low: Measured
    seconds_high: Measured
    compiling_seconds: Measured
    kernels_missing: Count
    definition: dict[str, Any]
    understood: Sentences


class Readiness(TypedDict):
    """Whether the kernels of a request are compiled."""

    phase: Literal["ready", "compiling"]
    phase_done: Count
    phase_total: Count
    compiling_seconds: Measured


def estimate_document(study: AnyStudy, plan: Plan, store: Store | None = None) -> Estimate:
    """Estimate the cost of a study, before it is stored.

    Parameters
    ----------
    study : AnyStudy
        The study.
    plan : Plan
        Division of the study into blocks.
    store : Store, optional
        Store with earlier studies. Measured times of studies that differ only in their grids improve the
        estimate. By default only the cost model is used.

    Returns
    -------
    dict
        Numbers of ``points`` and ``blocks``, and size in ``bytes`` before compression. ``points_stored`` is the number
        of points that are already computed, if the study was submitted before. ``seconds`` is the time on one core
        including the compilation, with the likely range ``seconds_low`` to ``seconds_high``.
        ``compiling_seconds`` is the time for the compilation, and ``kernels_missing`` is the number of scenes
        whose kernels must be compiled on this machine. ``understood`` lists assumptions, derived ratios and
        unusual values in sentences. The other keys are ``digest`` and ``definition``.
    """
    from damperlab.worker.warm import missing  # imported late: the import loads the compiler

    lacking = missing(scenes(study))
    compiling = sum(scene.seconds for scene in lacking)
    earlier = [] if store is None else done_of_family(store, family_digest(study, provenance()))
    known = None if store is None else store.newest(study.digest)
    factor = family_factor(earlier)
    seconds = plan.seconds * (factor or 1.0)
    doubt = DOUBT if factor is None else DOUBT_KNOWING
    return {
        "digest": study.digest,
        "points": study.points,
        "points_stored": 0 if known is None else known.points_done,
        "blocks": plan.count,
        "bytes": study.points * bytes_per_point(study),
        "seconds": seconds + compiling,
        # the compilation may take half or twice the expected time
        "seconds_low": seconds / doubt + compiling / 2,
        "seconds_high": seconds * doubt + 2 * compiling,
        "compiling_seconds": compiling,
        "kernels_missing": len(lacking),
        "definition": study.document(),
        "understood": understood(study),
    }


def readiness_document(wanted: Sequence[Scene]) -> Readiness:
    """Return whether the kernels for a request are compiled, and how long the compilation takes.

    Parameters
    ----------
    wanted : sequence of Scene
        Scenes whose kernels the request needs.

    Returns
    -------
    dict
        ``phase`` is "ready" if all kernels are compiled, and otherwise "compiling". ``phase_done`` is the
        number of scenes whose kernels are compiled, and ``phase_total`` is the number of all scenes.
        ``compiling_seconds`` is the expected time on one core to compile the missing kernels.
    """
    from damperlab.worker.warm import missing

    lacking = missing(wanted)
    return {
        "phase": "compiling" if lacking else "ready",
        "phase_done": len(wanted) - len(lacking),
        "phase_total": len(wanted),
        "compiling_seconds": sum(scene.seconds for scene in lacking),
    }
