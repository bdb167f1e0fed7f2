"""How quantities in SI units are written in drawings, reports and sentences. Only this module converts to millimetres
and grams.
"""

UNITS = {"_m": "m", "_n": "N", "_kg": "kg", "_hz": "Hz", "_s": "s", "_deg": "°"}
"""By the ending of the quantity's name."""


def spelled(value: float, unit: str, digits: int = 4) -> str:
    """Write a value with its unit: in millimetres and grams if metres and kilograms would be fractions."""
    if unit in ("m", "kg") and abs(value) < 1.0:
        return f"{1e3 * value:.{digits}g} {'mm' if unit == 'm' else 'g'}"
    text = f"{value:.{digits}g}"
    if "e+" in text and abs(value) < 1e7:
        text = f"{float(text):.0f}"  # 5000 N, not 5e+03 N
    return f"{text}{'' if unit == '°' else ' '}{unit.strip('1')}".rstrip()


def unit_of(name: str) -> str:
    """Give the unit of a quantity by its name; empty for a ratio."""
    return UNITS.get(name[name.rfind("_") :] if "_" in name else "", "")


def quantity(name: str, value: float, digits: int = 4) -> str:
    """Write a value of a quantity by its name, as `clearance_m`."""
    return spelled(value, unit_of(name), digits)
