"""Metadata of an exported file for other programs, as an RO-Crate 1.1 (https://w3id.org/ro/crate/1.1)."""

import hashlib
import json
from pathlib import Path
from typing import Any
from urllib.parse import quote, unquote

import xarray as xr

FILE = "ro-crate-metadata.json"
_MEDIA_TYPES = {
    ".nc": "application/x-netcdf",
    ".csv": "text/csv",
    ".parquet": "application/vnd.apache.parquet",
}
_STUDY, _SOFTWARE, _COMPUTATION = "#study", "#damperlab", "#computation"
_CF = "https://cfconventions.org"
_CONTEXT = ["https://w3id.org/ro/crate/1.1/context", {"sha256": "https://schema.org/sha256"}]


def crate_beside(export: Path) -> str:
    """Return the name of the file that the RO-Crate beside an export describes; empty if there is none."""
    path = export.parent / FILE
    if not path.exists():
        return ""
    try:
        (file,) = (each for each in json.loads(path.read_bytes())["@graph"] if each["@type"] == "File")
        return unquote(file["@id"])
    except (ValueError, TypeError, KeyError):  # another program made the crate
        return "other files"


def write_crate(cube: xr.Dataset, export: Path) -> Path:
    """Write an RO-Crate file that describes an exported cube beside the export, and return its path.

    The provenance of the cube is copied unchanged.
    """
    path = export.parent / FILE
    path.write_text(
        json.dumps(_document(cube, export), indent=1, ensure_ascii=False) + "\n", encoding="utf-8"
    )
    return path


def _document(cube: xr.Dataset, export: Path) -> dict[str, Any]:
    attributes = cube.attrs
    licence = str(attributes.get("license", ""))
    licence_id = licence if licence.startswith("https://") else "#licence"
    is_netcdf = export.suffix.lower() == ".nc"
    with export.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    file_entity = {
        "@id": quote(export.name),
        "@type": "File",
        "name": attributes["title"],
        "encodingFormat": _MEDIA_TYPES.get(export.suffix.lower(), "application/octet-stream"),
        "contentSize": str(export.stat().st_size),
        "sha256": digest,
    }
    others = []
    if is_netcdf:
        file_entity["conformsTo"] = {"@id": _CF}
        others.append({"@id": _CF, "@type": "CreativeWork", "name": attributes["Conventions"]})
    if licence:
        about = "Licence of the results."
        others.append({"@id": licence_id, "@type": "CreativeWork", "name": licence, "description": about})
    return {
        "@context": _CONTEXT,
        "@graph": [
            {
                "@id": FILE,
                "@type": "CreativeWork",
                "conformsTo": {"@id": "https://w3id.org/ro/crate/1.1"},
                "about": {"@id": "./"},
            },
            {
                "@id": "./",
                "@type": "Dataset",
                "name": attributes["title"],
                "description": f"Results of study {attributes['digest'][:12]} of a hybrid vibration damper.",
                "datePublished": attributes["created"][:10],
                "citation": {"@id": attributes["references"]},
                "hasPart": [{"@id": quote(export.name)}],
                "mentions": [{"@id": _COMPUTATION}],
                **({"license": {"@id": licence_id}} if licence else {}),
            },
            file_entity,
            {
                "@id": _COMPUTATION,
                "@type": "CreateAction",
                "name": "computation of the study",
                "instrument": {"@id": _SOFTWARE},
                "object": {"@id": _STUDY},
                "result": {"@id": quote(export.name)},
                "startTime": attributes["created"],
            },
            {
                "@id": _STUDY,
                "@type": "PropertyValue",
                "name": "definition of the study",
                "value": attributes["study"],
            },
            {
                "@id": _SOFTWARE,
                "@type": "SoftwareApplication",
                "name": "damperlab",
                "version": attributes["solver_version"],
                "softwareRequirements": attributes["provenance"],
            },
            {
                "@id": attributes["references"],
                "@type": "ScholarlyArticle",
                "name": "A Hybrid Damper with Tunable Particle Impact Damping and Coulomb Friction",
            },
            *others,
        ],
    }
