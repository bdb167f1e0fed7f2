"""Ground-motion suites that compute the responses of dampers to records, and reading of their results."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from damperlab.studies.answers.excited import definition_of
from damperlab.studies.answers.follow_up import cover
from damperlab.studies.cavity import cavity_of
from damperlab.studies.design.build import NOTHING_INSIDE, Inside, Place, Spot
from damperlab.studies.ground.suite import Suite
from damperlab.studies.ground.suite_reading import read_suite
from damperlab.studies.specification.excitation import RecordCases
from damperlab.studies.specification.specification import Specification
from damperlab.studies.variables import MADE_BY, Status

if TYPE_CHECKING:
    import xarray as xr

RECORD_VARIABLES = (
    "peak_relative_displacement_m",
    "rms_relative_displacement_m",
    "peak_absolute_displacement_m",
    "rms_absolute_displacement_m",
    "peak_absolute_acceleration_m_s2",
    "rms_absolute_acceleration_m_s2",
    "impact_speed_max_m_s",
    "impacts",
    "stick_fraction",
)
"""Variables stored for a damper under a record."""
AXES = (
    "natural_frequency_hz",
    "damping_ratio",
    "restitution",
    "particle_mass_kg",
    "clearance_m",
    "friction_force_n",
)
"""Quantities that distinguish dampers on structures of equal mass, in the order of the rows in `suites_of`."""
OF_PARTICLE = ("restitution", "clearance_m")
"""Quantities without meaning if there is no particle."""


def suites_of(asked: Specification, lacking: Iterable[Spot]) -> tuple[Suite, ...]:
    """Make suites that compute the responses of dampers under records. Their order is deterministic.

    A suite computes every record of an excitation at every scale, because a damper is always requested under all of
    these cases.
    """
    place_of = {source.id: i for i, records in enumerate(asked.records) for source in records.sources}
    cases: dict[tuple[float, bool, Inside, Place, float, int], set[tuple[str, float]]] = {}
    for law, place, inside in lacking:
        assert len(law) == 4  # the `Law` under a record
        record, scale, mass, frequency = law
        key = (mass, place[2] > 0.0, inside, place, frequency, place_of[record])
        cases.setdefault(key, set()).add((record, scale))
    groups: dict[tuple[float, bool, Inside, int, frozenset[tuple[str, float]]], list[list[float]]] = {}
    for (mass, particle, inside, place, frequency, of), each in sorted(cases.items(), key=lambda one: one[0]):
        groups.setdefault((mass, particle, inside, of, frozenset(each)), []).append([frequency, *place])
    return tuple(
        _suite(asked, asked.records[of], mass, particle, inside, wanted, grid)
        for (mass, particle, inside, of, wanted), rows in sorted(
            groups.items(), key=lambda one: (*one[0][:4], sorted(one[0][4]))
        )
        for grid in cover(np.array(rows), most=max(8, len(rows)))
    )


def _suite(
    asked: Specification,
    records: RecordCases,
    mass_kg: float,
    particle: bool,
    inside: Inside,
    wanted: frozenset[tuple[str, float]],
    grid: list[np.ndarray],
) -> Suite:
    ids = {record for record, _ in wanted}
    axes: dict[str, Any] = dict(zip(AXES, (axis.tolist() for axis in grid), strict=True))
    if not particle:
        axes = {name: values for name, values in axes.items() if name not in OF_PARTICLE}
    document = {
        "name": f"{asked.name}, design" if asked.name else "design",
        "records": [source.document() for source in records.sources if source.id in ids],
        "axes": axes | {"scale": sorted({scale for _, scale in wanted})},
        "mass_kg": mass_kg,
        "tail_s": records.tail_s,
        "metrics": [*RECORD_VARIABLES, "status"],
    }
    contact_time, *cavity = inside
    document |= {name: value for name, value in zip(MADE_BY.values(), cavity, strict=True) if value}
    if contact_time:
        document["contact"] = {"model": "dwell", "contact_time": contact_time}
    motions = {name: motion for name, motion in records.motions.items() if name in ids}
    return replace(read_suite(document), motions=motions)


def known_of(cube: "xr.Dataset") -> Iterator[tuple[Spot, tuple[float, ...]]]:
    """Yield the values of `RECORD_VARIABLES` for every damper under every case in the cube of a suite.

    The first value is infinite if the run failed.
    """
    document = definition_of(cube)
    mass, inside = float(document["mass_kg"]), (contact_time_of(cube), *cavity_of(document).numbers.values())
    order = ("record", "scale", *AXES)
    columns = np.stack(
        [cube[name].transpose(*order).values.astype(np.float64) for name in RECORD_VARIABLES], axis=-1
    )
    columns[..., 0][cube["status"].transpose(*order).values > Status.MAX_CYCLES] = np.inf
    records = [str(each) for each in cube["record"].values]
    axes = [cube[name].values.tolist() for name in order[1:]]
    for index in np.ndindex(*columns.shape[:-1]):
        scale, frequency, damping, restitution, particle, clearance, friction = (
            axis[i] for axis, i in zip(axes, index[1:], strict=True)
        )
        place: Place = (damping, restitution, particle, clearance, friction)
        if particle == 0.0:
            place = (damping, 0.0, 0.0, 0.0, friction)
        law = (records[index[0]], scale, mass, frequency)
        yield (law, place, inside if particle else NOTHING_INSIDE), tuple(columns[index].tolist())


def contact_time_of(cube: "xr.Dataset") -> float:
    """Return the contact time of the particle in a study or suite, relative to 1/ω_n; 0 if impacts take no time."""
    contact = definition_of(cube).get("contact", {})
    return float(contact.get("contact_time", 0.0))
