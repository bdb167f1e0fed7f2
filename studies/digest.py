"""The digest of a study: equal studies have equal digests, however they are written."""

import hashlib
import json
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.kind import AnyStudy
from damperlab.studies.physical import DERIVATIONS

if TYPE_CHECKING:
    from damperlab.studies.definition import Study

_SCHEME = b"damperlab study 1"
"""Change it when the same study is computed or stored differently, so that old answers are not taken for new ones."""


def study_digest(study: "Study") -> str:
    """Return SHA-256 over the canonical content of a study, in hexadecimal.

    Axes count by their expanded values (float64, little endian), so a range and the equal list are one study. Key
    order, the spelling of numbers and the name do not count. Nor does anything that the scene ignores: without a
    particle its dimensions, its contact and its physical quantities. The physical block counts, because it is stored
    with the answer and gives the coordinates their units.
    """
    content = hashlib.sha256(_SCHEME)
    for name, values in study.coordinates.items():
        feed(content, name, _bytes(values))
    if study.physical is not None:
        ignored = () if study.particle else tuple(d.source for d in DERIVATIONS.values() if d.of_particle)
        for name, values in study.physical.values().items():
            if name not in ignored:
                feed(content, f"physical.{name}", _bytes(values))
        if study.physical.constant is not None:
            feed(content, "physical.constant", study.physical.constant.encode())
    settings: dict[str, Any] = study.model_dump(
        mode="json", include={"particle", "contact", "metrics", "steady", "solver", "start"}
    )
    if not study.particle:
        del settings["contact"]
    if study.forced:  # only for forces, so that older digests are unchanged
        settings["excitation"] = study.excitation
    feed(content, "settings", json.dumps(settings, sort_keys=True).encode())
    return content.hexdigest()


def family_digest(study: AnyStudy, provenance: dict[str, str]) -> str:
    """Return SHA-256 over everything that a point's values depend on except its coordinates, in hexadecimal.

    Studies of one family differ only in their grids and metrics: a common point has the same bits. The digest is
    empty, so that the study has no family, if a point depends on its neighbours or if the solver is unknown.
    """
    identity = provenance.get("identity")
    settings = study.settings()
    if not identity or settings is None:
        return ""
    content = hashlib.sha256(_SCHEME)
    feed(content, "version", provenance.get("solver_version", "unknown").encode())
    feed(content, "identity", identity.encode())
    feed(content, "settings", json.dumps(settings, sort_keys=True).encode())
    return content.hexdigest()


def _bytes(values: NDArray[np.float64]) -> bytes:
    return values.astype("<f8").tobytes()


def feed(content: "hashlib._Hash", label: str, data: bytes) -> None:
    """Add a labelled piece to a digest."""
    # The length goes first: otherwise the end of one axis could be read as the start of the next.
    content.update(f"{label}:{len(data)}:".encode())
    content.update(data)
