"""The best damper so far, in one line for whoever waits."""

from collections.abc import Iterator, Mapping
from typing import Any

from damperlab.studies.design.spelling import CALLED, SYMBOLS
from damperlab.studies.specification.specification import CHOSEN, RATIO_OF
from damperlab.studies.spelling import quantity, spelled


def best_so_far(known: Mapping[str, Any]) -> str:
    """Write the best damper so far: what it does at worst, as drawn, and what it is.

    Parameters
    ----------
    known : mapping
        As of `damperlab.studies.design.answer.known_document`, which is what a service says of a design under way.
    """
    keeps = "" if known["feasible"] else ", exceeds a limit"
    return f"{_worst(known['worst'])}{keeps}: {', '.join(_quantities(known['design']))}"


def _worst(worst: Mapping[str, Any]) -> str:
    if worst["value"] is None:
        return "no bounded response"
    value = spelled(worst["value"], worst["units"])
    if worst["units"] == "1":
        value += " times the base amplitude"
    if worst.get("record"):
        return f"{value} under {worst.get('record_name') or worst['record']} × {worst['scale']:g}"
    if worst.get("frequency_hz"):
        return f"{value} near {worst['frequency_hz']:.4g} Hz"
    return f"{value} near r = {worst['frequency_ratio']:.4g}" if worst.get("frequency_ratio") else value


def _quantities(design: Mapping[str, Any]) -> Iterator[str]:
    for name in CHOSEN:
        value, ratio = design.get(name), design.get(RATIO_OF[name])
        if value is not None:
            yield f"{CALLED[name]} {quantity(name, value)}"
        elif ratio is not None:
            yield f"{SYMBOLS[name]} = {ratio:.4g}"
