"""Example studies in the schema, which can be submitted unchanged."""

from typing import Any

EXAMPLES: tuple[dict[str, Any], ...] = (
    {
        "name": "hybrid damper at resonance",
        "axes": {
            "clearance_ratio": {"start": 2, "stop": 20, "num": 7},
            "friction_ratio": [0, 0.4, 0.6],
            "frequency_ratio": 1.0,
        },
    },
    {
        "name": "friction alone over a band",
        "particle": False,
        "axes": {
            "friction_ratio": 0.6,
            "frequency_ratio": {"start": 0.5, "stop": 2, "num": 31, "spacing": "log"},
        },
    },
    {
        "name": "a physical damper",
        "axes": {"frequency_ratio": [0.95, 1.0, 1.05]},
        "physical": {
            "mass_kg": 1.605,
            "natural_frequency_hz": 2.5,
            "base_amplitude_m": 0.0015,
            "clearance_m": [0.0075, 0.0225, 0.0375],
            "particle_mass_kg": 0.16,
        },
    },
)
"""Studies that can be submitted unchanged."""

SUITE: dict[str, Any] = {
    "name": "dampers under two earthquakes",
    "records": ["northridge", {"kanai_tajimi": {"seed": 1, "duration_s": 15, "peak_g": 0.2}}],
    "axes": {
        "scale": [1, 2],
        "clearance_m": {"start": 0.002, "stop": 0.01, "num": 3},
        "friction_force_n": [0.1, 0.4],
    },
    "starts": 2,
}
"""A suite that can be submitted unchanged."""
