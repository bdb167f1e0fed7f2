"""Attributes of a cube according to the CF-1.11 conventions, in addition to names and units.

https://cfconventions.org: ancillary variables (3.4), cell methods (7.3), attributes of a file (2.6.2).
"""

from collections.abc import Collection, Mapping
from typing import Any

from damperlab.studies.unit_names import AMPLITUDES

CONVENTIONS = "CF-1.11"
REFERENCES = "https://doi.org/10.3390/machines11050545"
"""The paper on the damper: Akbar, Wong, Rustighi, Machines 2023, 11, 545."""

_SHARES = tuple(f"dissipation_{name}" for name in ("viscous", "friction", "impact", "particle"))
_ERROR = {
    "amplitude_ratio": "amplitude_error",
    "impacts_per_cycle": "impacts_error",
    **dict.fromkeys(_SHARES, "dissipation_error"),
}
_METHODS = {
    **dict.fromkeys(
        ("amplitude_ratio", "relative_amplitude_ratio", "acceleration_ratio"),
        "time: mean (of the largest value in each excitation cycle)",
    ),
    **dict.fromkeys(("amplitude_ratio_max", "impact_speed_max"), "time: maximum"),
    **dict.fromkeys(("amplitude_ratio_rms", "acceleration_ratio_rms"), "time: root_mean_square (times √2)"),
    **dict.fromkeys(("impacts_per_cycle", "dissipation_per_cycle", "stick_fraction", *_SHARES), "time: mean"),
}
_PREFIXES = {"peak_": "time: maximum", "impact_speed_max_": "time: maximum", "rms_": "time: root_mean_square"}
_OVER_STARTS = {"lowest": "minimum", "highest": "maximum", "mean": "mean", "std": "standard_deviation"}
"""CF cell method of each statistic over perturbed starts, by the word in the names of results."""


def of_file(version: str, created: str) -> dict[str, str]:
    """Return the global attributes of a cube: conventions, source, history, and references for the model.

    Parameters
    ----------
    version : str
        Version of damperlab.
    created : str
        Time at which the study was submitted, in ISO 8601.
    """
    return {
        "Conventions": CONVENTIONS,
        "source": f"damperlab {version}",
        "history": f"{created} study submitted to damperlab {version}",
        "references": REFERENCES,
    }


def of_variable(name: str, stored: Collection[str]) -> dict[str, str]:
    """Return the CF attributes of one result. `stored` contains the names of all variables of the cube."""
    beside = [each for each in (_ERROR.get(name), "status") if each in stored and each != name]
    by_prefix = (method for prefix, method in _PREFIXES.items() if name.startswith(prefix))
    method = _METHODS.get(name) or next(by_prefix, "")
    method += "".join(f" realization: {how}" for part, how in _OVER_STARTS.items() if f"_{part}_" in name)
    found = {"ancillary_variables": " ".join(map(str, beside)), "cell_methods": method}
    return {attribute: text for attribute, text in found.items() if text}


def of_variable_in_units(attributes: Mapping[str, Any]) -> dict[str, str]:
    """Derive the CF attributes of a result in SI units from the attributes of the same result as a ratio."""
    kept = {
        name: str(attributes[name]) for name in ("ancillary_variables", "cell_methods") if name in attributes
    }
    if "ancillary_variables" in kept:
        beside = (AMPLITUDES.get(name, name) for name in kept["ancillary_variables"].split())
        kept["ancillary_variables"] = " ".join(beside)
    return kept
