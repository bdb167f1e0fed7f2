"""The cost of a study and the state of the kernels that it needs, as documents for HTTP and --json.

They use the solver and so load the compiler; questions to the store alone do not.
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

DOUBT, DOUBT_KNOWING = 4.0, 2.5
"""Factors by which the time of a study may be longer or shorter than expected: with the cost model alone, and after a
study of its family. They covered 27 and 31 of 32 random studies (560 points of any hybrid scene, after a study of 180
points).
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
    study, plan : AnyStudy, Plan
        The study, and the division of its grid.
    store : Store, optional
        Earlier studies of its family, whose times improve the estimate; without them the cost model alone is used.

    Returns
    -------
    dict
        ``points``; ``points_stored``, those computed already if this study was submitted before; ``blocks``; ``bytes``
        (before compression). ``seconds`` on one core, including compiling, and its likely range ``seconds_low`` to
        ``seconds_high``. ``compiling_seconds`` is the part of it for compiling, ``kernels_missing`` the number of scenes
        to compile on this machine. Also ``digest``, ``definition``, and ``understood``: assumptions, derived ratios,
        and unusual values, in sentences.
    """
    from damperlab.worker.warm import missing  # imported here, because it imports the compiler

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
        # compiling takes twice as long on a busy machine
        "seconds_low": seconds / doubt + compiling / 2,
        "seconds_high": seconds * doubt + 2 * compiling,
        "compiling_seconds": compiling,
        "kernels_missing": len(lacking),
        "definition": study.document(),
        "understood": understood(study),
    }


def readiness_document(wanted: Sequence[Scene]) -> Readiness:
    """Say whether the kernels of a request are compiled, before it is computed.

    Parameters
    ----------
    wanted : sequence of Scene
        The scenes that the request needs.

    Returns
    -------
    dict
        ``phase``: ready, or compiling if something must be compiled first; ``phase_done`` of ``phase_total`` scenes
        are compiled; ``compiling_seconds`` (on one core) estimates the time of the others.
    """
    from damperlab.worker.warm import missing

    lacking = missing(wanted)
    return {
        "phase": "compiling" if lacking else "ready",
        "phase_done": len(wanted) - len(lacking),
        "phase_total": len(wanted),
        "compiling_seconds": sum(scene.seconds for scene in lacking),
    }
