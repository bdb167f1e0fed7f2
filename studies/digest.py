"""The digest of a study, which does not depend on the notation of the study."""

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
"""Version of the digest. A change of computation or storage requires a new version, so that old results are not reused.
"""


def study_digest(study: "Study") -> str:
    """Return the SHA-256 hash of the canonical content of a study, in hexadecimal.

    The hash covers the values of each axis (float64, little endian), so a range and an equal list have the same hash.
    The order of keys, the spelling of numbers, the name, and quantities that the scene ignores have no effect. The hash
    covers the physical block, because the block determines the units of the coordinates.
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
    if study.forced:  # only for forces, so that studies with a shaken base keep their earlier digests
        settings["excitation"] = study.excitation
    feed(content, "settings", json.dumps(settings, sort_keys=True).encode())
    return content.hexdigest()


def family_digest(study: AnyStudy, provenance: dict[str, str]) -> str:
    """Return the SHA-256 hash of the settings and versions that determine the results at given coordinates.

    Studies with equal hashes form a family. At a common point, all studies of a family have bitwise equal results. The
    hash is an empty string if the solver is unknown or if the `settings` of the study are None.
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
    """Add labelled data to a hash."""
    # Hashing the length first separates the axes: the end of an axis cannot be mistaken for the start of the next axis.
    content.update(f"{label}:{len(data)}:".encode())
    content.update(data)
