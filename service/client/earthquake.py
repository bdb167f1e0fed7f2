"""Ground-motion records, and the comparison of dampers under a record."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from damperlab.service.client.answers import DamperComparison
from damperlab.service.client.faults import refused
from damperlab.studies.faults import Fault, describe

UNITS = (("_m_s2", "m/s2"), ("_m_s", "m/s"), ("_m", "m"), ("_j", "J"), ("_s", "s"))
"""Unit of a measure, by the ending of its name."""


@dataclass(frozen=True)
class GroundRecord:
    """A record of base acceleration stored by the service.

    Parameters
    ----------
    id, name, source : str
        Id, name and source of the record.
    samples : int
        Number of samples.
    step_s, duration_s : float
        Time step, and duration [s].
    peak_acceleration_m_s2, peak_acceleration_g, peak_velocity_m_s, peak_displacement_m : float
        Largest absolute acceleration, velocity and displacement of the base.
    digest : str
        Digest of the time step and the samples.
    """

    id: str
    name: str
    source: str
    samples: int
    step_s: float
    duration_s: float
    peak_acceleration_m_s2: float
    peak_acceleration_g: float
    peak_velocity_m_s: float
    peak_displacement_m: float
    digest: str


def read_ground_record(document: Mapping[str, Any]) -> GroundRecord:
    """Read the summary of a record that the service sends."""
    return GroundRecord(**{field.name: document[field.name] for field in fields(GroundRecord)})


def upload(path: Path, name: str, units: str | None) -> dict[str, Any]:
    """Return the arguments of `Transport.ask` that send the file of a record.

    Raises
    ------
    Refused
        If the file cannot be read.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        found = f"{describe(str(path))} ({error.strerror})"
        told = f"The file {path} cannot be read: {error.strerror}."
        raise refused((Fault("path", found, "a readable file", "check the path", told),)) from None
    layout = "at2" if path.suffix.lower() == ".at2" else "csv"
    asked = {"format": layout, "units": units, "name": name or path.stem}
    return {"content": content, "headers": {"Content-Type": "text/plain"}, "params": asked}


def read_comparison(document: Mapping[str, Any]) -> DamperComparison:
    """Convert a comparison into a Dataset along ``case``.

    Variables that end in ``_lowest`` and ``_highest`` hold the extreme values of a measure over perturbed starts.
    """
    cases = document["cases"]
    measures = [name for name in next(iter(cases.values())) if name not in ("label", "spread")]
    data = {
        name: ("case", np.array([case[name] for case in cases.values()]), _attributes(name))
        for name in measures
    }
    spreads = [case.get("spread", {}) for case in cases.values()]
    for name in measures:
        for end in ("lowest", "highest"):
            found = [spread[name][end] if name in spread else np.nan for spread in spreads]
            if not np.isnan(found).all():
                long_name = f"{end} {name.replace('_', ' ')} over perturbed starts"
                data[f"{name}_{end}"] = (
                    "case",
                    np.array(found),
                    _attributes(name) | {"long_name": long_name},
                )
    sensitive = [bool(spread.get("sensitive", False)) for spread in spreads]
    data["sensitive"] = (
        "case",
        np.array(sensitive),
        {
            "units": "1",
            "long_name": "whether the response is sensitive to its start",
        },
    )
    labels = [str(case["label"]) for case in cases.values()]
    coordinates = {"case": list(cases), "label": ("case", labels)}
    said = {
        name: document[name]
        for name in ("record", "length_scale_m", "design", "contact", "tmd", "paper_table_a1", "note")
    }
    return DamperComparison(data, coordinates, said)


def _attributes(name: str) -> dict[str, str]:
    for ending, unit in UNITS:
        if name.endswith(ending):
            return {"units": unit, "long_name": name.removesuffix(ending).replace("_", " ")}
    return {"units": "1", "long_name": name.replace("_", " ")}
