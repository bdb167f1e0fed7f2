"""A survey: a grid over records, scale factors and design parameters, all in physical units."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from studies.axes import axis_count, axis_values, read_axis
from studies.faults import Fault, StudyFaults, describe, unknown_key
from studies.ground.motion import GroundMotion
from studies.ground.question import MOST_STARTS, QUANTITIES, read_record_reference
from studies.ground.shelf import Shelf
from studies.guard import guard
from studies.quantity import read_count

AXES: tuple[str, ...] = (
    "scale",
    "natural_frequency_hz",
    "damping_ratio",
    "restitution",
    "particle_mass_kg",
    "clearance_m",
    "friction_force_n",
)
"""Dimensions of a survey's answer after `record`, in their order."""

MOST_POINTS = 1_000_000
MOST_RECORDS = 100
NUMBERS = ("mass_kg", "tail_s", "perturbation_m")
KEYS = ("name", "records", *AXES, *NUMBERS, "starts", "seed")

LARGEST_PERIOD_STEPS = 200_000
"""Windows of one run: a stiffer structure under a longer record would take seconds a point."""


@dataclass(frozen=True)
class Survey:
    """A grid of responses to records.

    Parameters
    ----------
    name : str
        Free text.
    records : dict of GroundMotion
        By id, in the order given.
    axes : dict of ndarray
        Values of every one of `AXES`, increasing.
    numbers : dict of float
        `NUMBERS`.
    starts, seed : int
        Perturbed starts of each point besides the one at rest, and the seed of their draw.
    document : dict
        As it was given.
    """

    name: str
    records: dict[str, GroundMotion]
    axes: dict[str, NDArray[np.float64]]
    numbers: dict[str, float]
    starts: int
    seed: int
    document: dict[str, Any]

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of records, then of values along each of `AXES`."""
        return (len(self.records), *(len(values) for values in self.axes.values()))

    @property
    def points(self) -> int:
        """Design points times records and scales."""
        return math.prod(self.shape)


def read_survey(document: object, shelf: Shelf) -> Survey:
    """Read a survey.

    Parameters
    ----------
    document : object
        ``records`` (ids, names, or ``{"kanai_tajimi": {…}}``), and any of `AXES` as a number, a list, or
        ``{start, stop, num, spacing}``; what is left out is the paper's prototype.
    shelf : Shelf
        Where records are.

    Raises
    ------
    StudyFaults
        With every fault.
    """
    held, faults = guard(document)
    faults += [unknown_key(str(key), key, KEYS) for key in held if key not in KEYS]
    name = held.get("name", "")
    if not isinstance(name, str) or len(name) > 200 or not name.isprintable():
        faults.append(Fault("name", describe(name), "a short text on one line", "shorten it"))
    specs = {}
    for axis in AXES:
        quantity, default = QUANTITIES[axis]
        try:
            specs[axis] = read_axis(held.get(axis, default), quantity, axis)
        except StudyFaults as caught:
            faults.extend(caught.faults)
    numbers: dict[str, float] = {}
    for key in NUMBERS:
        quantity, default = QUANTITIES[key]
        try:
            numbers[key] = quantity.read(held.get(key, default), key)
        except StudyFaults as caught:
            faults.extend(caught.faults)
    counts = {"starts": 0, "seed": 0}
    for key, most in (("starts", MOST_STARTS), ("seed", 2**63 - 1)):
        try:
            counts[key] = read_count(held.get(key, 0), 0, most, key)
        except StudyFaults as caught:
            faults.extend(caught.faults)
    records = _records(held.get("records", ["loma-prieta"]), shelf, faults)
    points = len(records) * math.prod(axis_count(spec) for spec in specs.values()) * (1 + counts["starts"])
    if points > MOST_POINTS:
        found, advice = f"{points:,} runs", "use fewer values, records or starts"
        faults.append(Fault("survey", found, f"at most {MOST_POINTS:,}", advice))
    if faults:
        raise StudyFaults(faults)
    axes = {axis: axis_values(spec) for axis, spec in specs.items()}
    _check_windows(records, axes["natural_frequency_hz"], numbers["tail_s"])
    return Survey(name, records, axes, numbers, counts["starts"], counts["seed"], held)


def _records(raw: object, shelf: Shelf, faults: list[Fault]) -> dict[str, GroundMotion]:
    if isinstance(raw, str | dict):
        raw = [raw]
    if not isinstance(raw, list | tuple) or not 0 < len(raw) <= MOST_RECORDS:
        allowed = f"a list of 1 to {MOST_RECORDS} records"
        faults.append(Fault("records", describe(raw), allowed, 'write ["loma-prieta"]'))
        return {}
    records: dict[str, GroundMotion] = {}
    for index, one in enumerate(raw):
        try:
            record_id, motion = read_record_reference(one, shelf)
        except StudyFaults as caught:
            faults.extend(Fault(f"records[{index}]", f.found, f.allowed, f.advice) for f in caught.faults)
            continue
        if record_id in records:
            found = f"{record_id} a second time"
            faults.append(Fault(f"records[{index}]", found, "each record once", "remove one of the two"))
        records[record_id] = motion
    return records


def _check_windows(
    records: dict[str, GroundMotion], frequencies_hz: NDArray[np.float64], tail_s: float
) -> None:
    fastest = 2.0 * math.pi * float(frequencies_hz[-1])
    for record_id, motion in records.items():
        windows = (motion.duration_s + tail_s) / min(motion.step_s, 0.4 / fastest)
        if windows > LARGEST_PERIOD_STEPS:
            found = f"{windows:,.0f} steps of {record_id} at {frequencies_hz[-1]:g} Hz"
            advice = "use a shorter record or tail, or a slower structure"
            raise StudyFaults(
                [Fault("natural_frequency_hz", found, f"at most {LARGEST_PERIOD_STEPS:,}", advice)]
            )
