"""Quantities in SI units as text, for drawings, reports and sentences. Only this module converts to mm and g."""

UNITS = {
    "_n_s_per_m": "N s/m",
    "_n_per_m": "N/m",
    "_m2_per_s3": "(m/s²)²/Hz",
    "_g2_per_hz": "g²/Hz",
    "_hz_per_s": "Hz/s",
    "_m_per_s2": "m/s²",
    "_m_per_s": "m/s",
    "_m_s2": "m/s²",
    "_m_s": "m/s",
    "_m": "m",
    "_n": "N",
    "_kg": "kg",
    "_j": "J",
    "_hz": "Hz",
    "_s": "s",
    "_deg": "°",
}
"""Units by the ending of a quantity's name. The first match is used, so longer endings come first."""


def spelled(value: float, unit: str, digits: int = 4) -> str:
    """Write a value with its unit: in millimetres below 1 m, in grams below 1 kg."""
    if unit in ("m", "kg") and abs(value) < 1.0:
        return written(1e3 * value, "mm" if unit == "m" else "g", f".{digits}g")
    return written(value, unit.strip("1"), f".{digits}g")


def written(value: float, unit: str, form: str) -> str:
    """Write a number with its unit. A length in mm is written in m if it is at least 1 m, and in nm if it would need an
    exponent in mm.
    """
    text = format(value, form)
    if unit == "mm" and (abs(value) >= 1e3 or "e-" in text):
        value, unit = (1e6 * value, "nm") if "e-" in text else (1e-3 * value, "m")
        text = format(value, form)
    if "e+" in text and abs(value) < 1e7:
        text = f"{float(text):.0f}"  # 5000 N, not 5e+03 N
    return f"{text}{'' if unit == '°' else ' '}{unit}".rstrip()


def unit_of(name: str) -> str:
    """Return the unit at the end of a quantity's name; empty for a ratio."""
    return UNITS.get(_ending_of(name), "")


def without_unit(name: str) -> str:
    """Return the words of a quantity's name without the unit, for example ``clearance`` for `clearance_m`."""
    return name.removesuffix(_ending_of(name)).replace("_", " ")


def _ending_of(name: str) -> str:
    return next((ending for ending in UNITS if name.endswith(ending)), "")


def quantity(name: str, value: float, digits: int = 4) -> str:
    """Write a value with the unit at the end of the quantity's name, for example m for `clearance_m`."""
    return spelled(value, unit_of(name), digits)
