"""Parameters as a reader meets them: lengths in millimetres."""


def heading(name: str) -> str:
    """Name a parameter at the head of a row, with the unit that its values have there."""
    return f"{name.removesuffix('_m').replace('_', ' ')} [mm]" if _is_length(name) else name


def number(name: str, value: float, digits: int = 4) -> str:
    """Write a value of a parameter without its unit; see `heading`."""
    return f"{1e3 * value if _is_length(name) else value:.{digits}g}"


def spelled(name: str, value: float) -> str:
    """Write a value of a parameter within a sentence."""
    return f"{number(name, value)}{' mm' if _is_length(name) else ''}"


def _is_length(name: str) -> bool:
    return name.endswith("_m")
