"""What a study will cost, and whether what a request needs is compiled, as documents: what HTTP sends and --json prints.

They ask what computes, so they load the compiler; what asks the store alone loads none.
"""

from collections.abc import Sequence
from typing import Any, Literal

from typing_extensions import TypedDict

from damperlab.studies.digest import family_digest
from damperlab.studies.kind import AnyStudy
from damperlab.studies.plan import Plan
from damperlab.studies.shapes import Count, Measured, Sentences
from damperlab.studies.store.cube.cube import bytes_per_point
from damperlab.studies.store.reuse.family import done_of_family
from damperlab.studies.store.store import Store
from damperlab.studies.understood import understood
from damperlab.worker.dispatch.cost_model import family_factor
from damperlab.worker.provenance import provenance
from damperlab.worker.scenes import Scene, scenes
from damperlab.worker.warm import missing

DOUBT, DOUBT_KNOWING = 4.0, 2.5
"""Factor either way within which a study takes what is expected, by the cost model alone and after one of its family: so in 27
and 31 of 32 drawn at random (560 points of any hybrid scene, the earlier one of 180)."""


class Estimate(TypedDict):
    """What a study will cost."""

    digest: str
    points: Count
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
    """Whether what a request needs is compiled."""

    phase: Literal["ready", "compiling"]
    phase_done: Count
    phase_total: Count
    compiling_seconds: Measured


def estimate_document(study: AnyStudy, plan: Plan, store: Store | None = None) -> Estimate:
    """Say what a study will cost, before it is stored.

    Parameters
    ----------
    study, plan : AnyStudy, Plan
        The study, and how it is cut.
    store : Store, optional
        Where earlier studies of its family tell what points take; without them the cost model alone does.

    Returns
    -------
    dict
        ``points``, ``blocks``, ``bytes`` (before compression), ``seconds`` (of one core, compiling included) and
        ``seconds_low`` and ``seconds_high``, between which they may well be, ``compiling_seconds`` (the part of it that
        compiling takes) and ``kernels_missing`` (scenes to compile on this machine), ``digest``, ``definition``, and
        ``understood`` (what was assumed, the ratios that quantities make, and what is unusual, in sentences).
    """
    lacking = missing(scenes(study))
    compiling = sum(scene.seconds for scene in lacking)
    earlier = [] if store is None else done_of_family(store, family_digest(study, provenance()))
    factor = family_factor(earlier)
    seconds = plan.seconds * (factor or 1.0)
    doubt = DOUBT if factor is None else DOUBT_KNOWING
    return {
        "digest": study.digest,
        "points": study.points,
        "blocks": plan.count,
        "bytes": study.points * bytes_per_point(study),
        "seconds": seconds + compiling,
        # the compiler takes twice as long on a machine that is busy
        "seconds_low": seconds / doubt + compiling / 2,
        "seconds_high": seconds * doubt + 2 * compiling,
        "compiling_seconds": compiling,
        "kernels_missing": len(lacking),
        "definition": study.document(),
        "understood": understood(study),
    }


def readiness_document(wanted: Sequence[Scene]) -> Readiness:
    """Say whether what a request needs is compiled, before it is computed.

    Parameters
    ----------
    wanted : sequence of Scene
        What it needs.

    Returns
    -------
    dict
        ``phase``: ready, or compiling where something must be compiled first; ``phase_done`` of ``phase_total``
        scenes are compiled; ``compiling_seconds`` (of one core) is about what the others take.
    """
    lacking = missing(wanted)
    return {
        "phase": "compiling" if lacking else "ready",
        "phase_done": len(wanted) - len(lacking),
        "phase_total": len(wanted),
        "compiling_seconds": sum(scene.seconds for scene in lacking),
    }
