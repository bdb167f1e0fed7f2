"""Parameters of a comparison of dampers under a record, in physical units. The defaults are the paper's prototype."""

from damperlab.studies.presets import NATURAL_FREQUENCY_HZ
from damperlab.studies.quantity import OF_CAVITY, Quantity
from damperlab.studies.vocabulary import DEFAULTS

QUANTITIES: dict[str, tuple[Quantity, float]] = {
    name: (Quantity(name, meaning, low, high, advice, below), default)
    for name, meaning, low, high, advice, below, default in (
        ("mass_kg", "mass M of the primary structure [kg]", 1e-6, 1e12, "give it in kg", False, 1.605),
        (
            "natural_frequency_hz", "undamped natural frequency of the structure [Hz]", 1e-3, 1e3,
            "give it in Hz", False, NATURAL_FREQUENCY_HZ,
        ),
        ("damping_ratio", "damping ratio ζ of the structure", 0.0, 1.0, "below 1", True, DEFAULTS["damping_ratio"]),
        ("particle_mass_kg", "mass m of the particle [kg]", 0.0, 1e12, "give it in kg; 0 for none", False, 0.1605),
        (
            "clearance_m", "clearance d on either side of the particle, half the free cavity length [m]", 1e-9, 1e6,
            "give it in m", False, 0.0075,
        ),
        ("restitution", "coefficient of restitution e", 0.0, 1.0, "from 0 to 1", False, DEFAULTS["restitution"]),
        (
            "friction_force_n", "Coulomb friction force F_f [N]", 0.0, 1e12, "give it in N; 0 for none", False,
            0.409,
        ),
        ("tmd_mass_kg", "mass of the tuned mass damper [kg]; that of the particle by default", 1e-9, 1e12, "give it in kg",
            False, float("nan")),
        ("scale", "factor on the record", 1e-6, 1e6, "1 leaves the record as it is", False, 1.0),
        ("tail_s", "free vibration after the record [s]", 0.0, 1000.0, "0 stops with the record", False, 0.0),
        ("perturbation_m", "size of the perturbed starts [m]", 0.0, 1e3, "a millionth of the motion is usual", False, 1e-7),
    )
} | {each.name: (each, 0.0) for each in OF_CAVITY}  # fmt: skip
"""Bounds and default of each parameter. The defaults are from Tables 2 and 4; the friction force is
`paper.friction_force_n` at the smallest clearance.
"""
