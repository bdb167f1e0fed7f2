"""Names and meanings of options that several interfaces share. This module imports no other module of the package."""

from typing import Literal, get_args

State = Literal["queued", "running", "done", "cancelled", "failed"]
STATES: tuple[State, ...] = get_args(State)
"""Every state of a study. The last three states are final."""
ENDED: tuple[State, ...] = STATES[2:]

Scope = Literal["read", "submit", "admin"]
SCOPES: tuple[Scope, ...] = get_args(Scope)
"""Permissions of an access key: `read`, `submit` and `admin`.

The permission `submit` includes changes to studies of the key's owner, and `admin` changes to all studies.
"""

PRIORITIES = -10, 10
"""Lowest and highest priority of a study; the default is 0."""

BatchSystem = Literal["slurm"]
"""Batch systems for jobs that run workers."""

Objective = Literal["peak", "resonance", "band_mean", "band_rms"]
OBJECTIVES: dict[Objective, str] = {
    "resonance": "amplitude ratio at the frequency nearest r = 1",
    "peak": "largest amplitude ratio in the band",
    "band_mean": "mean amplitude ratio over the band",
    "band_rms": "rms of the amplitude ratio over the band",
}
"""Criteria for ranking designs, and their meanings. Smaller values are better."""
OBJECTIVES_IN_UNITS: dict[Objective, str] = {
    "resonance": "amplitude at the frequency nearest the natural one",
    "peak": "largest amplitude in the band",
    "band_mean": "mean amplitude over the band",
    "band_rms": "rms of the amplitude over the band",
}
"""Meanings of the criteria in `OBJECTIVES` for a study with amplitudes in units."""

Criterion = Literal["den_hartog", "den_hartog_table4", "hinf", "h2", "minimax"]
CRITERIA: dict[Criterion, str] = {
    "den_hartog": "Den Hartog's fixed points for an undamped structure, (14) and (15), ζ = c/(2√(m k₁))",
    "den_hartog_table4": (
        "the damping √(3μ/(8(1+μ)³)) of Table 4, which is c/(2 m ω_n), used in (13) as c/(2√(m k₁)); this "
        "mix of conventions reproduces the paper's curve, and the correct use gives den_hartog"
    ),
    "hinf": "exact least peak for an undamped structure, closed form of Nishihara and Asami (2002)",
    "h2": (
        "least mean square displacement of an undamped structure under white noise, closed form: absolute "
        "under a force, relative to the base under a base acceleration"
    ),
    "minimax": "least peak for the structure with its own damping, found numerically",
}
"""Tunings of a tuned mass damper, and their meanings."""
CRITERION_NAMES: dict[Criterion, str] = {
    "den_hartog": "Den Hartog",
    "den_hartog_table4": "Den Hartog, as the paper’s Table 4",
    "hinf": "H∞",
    "h2": "H2",
    "minimax": "least peak (minimax)",
}
"""Short names of the tunings in `CRITERIA`, for a list of choices."""

ContactModel = Literal["instant", "dwell", "compliant"]
CONTACT_MODELS: dict[ContactModel, str] = {
    "instant": "instantaneous impact",
    "dwell": "contact of fixed duration (dwell)",
    "compliant": "compliant contact (spring and dashpot)",
}
"""Models of an impact."""

START_KINDS: dict[str, str] = {
    "rest": "at rest",
    "ensemble": "from several drawn states",
    "continuation": "from the final state of the previous frequency",
}
"""Words for the initial state of each point, by the kind of start."""

Excitation = Literal["base", "force"]
EXCITATIONS: dict[Excitation, str] = {"base": "its base, shaken", "force": "a force on it"}
"""Words for each kind of excitation of the structure."""

Reduction = Literal["max", "min", "mean"]
"""Ways to reduce the values along a dimension to a single value."""

RESPECTS: dict[str, tuple[str, str]] = {
    "amplitude": ("value", "what the objective judges"),
    "mass": ("mass_ratio", "mass ratio β"),
    "clearance": ("clearance_ratio", "clearance ratio d/Z"),
    "impact_speed": ("impact_speed_max", "largest impact speed in the band, over Z·ω_n"),
    "dissipation_viscous": ("dissipation_viscous", "viscous share of the dissipation, mean over the band"),
    "dissipation_friction": ("dissipation_friction", "friction share of the dissipation, mean over the band"),
    "dissipation_impact": ("dissipation_impact", "impact share of the dissipation, mean over the band"),
}
"""Variable and meaning of each quantity for comparing designs. Smaller values are better."""

ExportFormat = Literal["netcdf", "csv", "parquet"]
EXPORT_FORMATS: dict[ExportFormat, str] = {
    "netcdf": "netCDF: for Python, MATLAB, Julia",
    "csv": "CSV: one row for each point",
    "parquet": "Parquet: the same, small and typed",
}
"""Formats for exporting a study's results, and their uses."""
EXPORT_SUFFIXES: dict[str, ExportFormat] = {
    ".nc": "netcdf",
    ".csv": "csv",
    ".parquet": "parquet",
}
"""The format for each file suffix."""

DocumentFormat = Literal["html", "pdf"]
"""Formats of a report."""

Method = Literal["event", "rk4"]
METHODS: tuple[Method, ...] = get_args(Method)
"""Integration methods: event-driven, or the paper's Runge–Kutta scheme with fixed steps."""

CASES: dict[str, str] = {
    "none": "no damper",
    "tmd": "tuned mass damper",
    "pid": "particle",
    "fd": "friction",
    "hybrid": "particle and friction",
}
"""The dampers in Table A1 of the paper."""

AccelerationUnits = Literal["g", "m/s2", "cm/s2"]
ACCELERATION_UNITS: dict[str, float] = {"g": 9.80665, "m/s2": 1.0, "cm/s2": 0.01}
"""Units of an acceleration with their values in m/s². The value of g is the standard acceleration of gravity."""

OF_PARTICLE = ("restitution", "mass_ratio", "clearance_ratio")
"""Dimensions that have no meaning if the scene has no particle."""

DEFAULTS: dict[str, float] = {
    "damping_ratio": 0.0038,
    "restitution": 0.47,
    "mass_ratio": 0.1,
    "friction_ratio": 0.0,
}
"""Defaults of a study: structure, particle and cushion of the paper (Tables 1 and 2, Section 2), without friction."""

DESIGN_POINT: dict[str, float] = {**DEFAULTS, "clearance_ratio": 10.0, "frequency_ratio": 1.0}
"""The default design point of `simulate` and of a form."""
