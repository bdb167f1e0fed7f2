"""Words that several doors take: each is written here alone, as a type for checkers and a tuple for messages.

Loads nothing, so that the command line and the client may use it before anything else is imported.
"""

from typing import Literal, get_args

State = Literal["queued", "running", "done", "cancelled", "failed"]
STATES: tuple[State, ...] = get_args(State)
"""Every state of a study; the last three are ends."""
ENDED: tuple[State, ...] = STATES[2:]

Scope = Literal["read", "submit", "admin"]
"""What a key allows, each what the ones before it allow: to ask; to submit and change one's own; to change others'."""
SCOPES: tuple[Scope, ...] = get_args(Scope)

Objective = Literal["peak", "resonance", "band_mean", "band_rms"]
OBJECTIVES: tuple[Objective, ...] = get_args(Objective)
"""What designs are ranked by."""

Criterion = Literal["den_hartog", "den_hartog_table4", "hinf", "h2", "minimax"]
CRITERIA: tuple[Criterion, ...] = get_args(Criterion)
"""How a tuned mass damper is tuned."""

Excitation = Literal["base", "force"]
EXCITATIONS: tuple[Excitation, ...] = get_args(Excitation)

Reduction = Literal["max", "min", "mean"]
REDUCTIONS: tuple[Reduction, ...] = get_args(Reduction)
"""How a dimension is reduced."""

ExportFormat = Literal["netcdf", "csv", "parquet"]
EXPORT_FORMATS: tuple[ExportFormat, ...] = get_args(ExportFormat)
EXPORT_SUFFIXES: dict[str, ExportFormat] = {
    ".nc": "netcdf",
    ".csv": "csv",
    ".parquet": "parquet",
}
"""The format that the end of a file's name stands for."""

AccelerationUnits = Literal["g", "m/s2", "cm/s2"]
ACCELERATION_UNITS: tuple[AccelerationUnits, ...] = get_args(AccelerationUnits)

OF_PARTICLE = ("restitution", "mass_ratio", "clearance_ratio")
"""The dimensions that mean nothing without a particle."""

DEFAULTS: dict[str, float] = {
    "damping_ratio": 0.0038,
    "restitution": 0.47,
    "mass_ratio": 0.1,
    "friction_ratio": 0.0,
}
"""What a study gets where it says nothing: the paper's structure, particle and cushion (its Table 2), no friction."""

DESIGN_POINT: dict[str, float] = {**DEFAULTS, "clearance_ratio": 10.0, "frequency_ratio": 1.0}
"""The design point that `simulate` computes where nothing else is said."""
