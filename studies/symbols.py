"""The dimensions as the paper writes them."""

SYMBOLS = {
    "damping_ratio": "ζ",
    "restitution": "e",
    "mass_ratio": "β",
    "clearance_ratio": "d/Z",
    "friction_ratio": "γ_F",
    "frequency_ratio": "r",
}
"""The dimensions as the paper writes them."""
