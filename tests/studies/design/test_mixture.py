"""Designs over bands and under ground-motion records at once: brute force, limits, what changes nothing."""

from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.studies.design.test_design import pursued
from tests.studies.design.test_records import SHAKEN, peaks_m
from tests.studies.design.test_stated import Case, worst
from tests.studies.documents import without

from damperlab.studies.design.found import Found
from damperlab.studies.tmd.transfer import highest
from damperlab.studies.tmd.under_record import response_under

MACHINE = {"name": "machine", "base_amplitude_m": 0.003, "frequency_hz": {"start": 2.2, "stop": 2.8}}
QUAKE = {
    "name": "quake",
    "records": [{"kanai_tajimi": {"seed": 1, "duration_s": 14, "peak_g": 0.2}}],
    "scales": [0.6],
}
BOTH: dict[str, Any] = {
    **without(SHAKEN, "tolerances", "builds"),
    "excitation": [MACHINE, QUAKE],
    "choose": {"friction_force_n": {"start": 2.0, "stop": 40.0}},
    "clearance_m": 0.01,
}
"""A structure whose least displacement against the base needs more friction under one of them than under the other."""
BUDGET = 12_000


@pytest.fixture(scope="module")
def both() -> tuple[Found, dict[str, xr.Dataset]]:
    return pursued(BOTH | {"measure": "worst_displacement"}, BUDGET)


def over_machine_m(force_n: float) -> float:
    """Largest displacement [m] over the band with a friction force, of single points."""
    return worst(Case(BOTH | {"excitation": MACHINE, "tolerances": {}}), (0.01, force_n), 61)


def under_quake_m(forces_n: list[float]) -> np.ndarray:
    return peaks_m(QUAKE, 0.01, forces_n, variable="peak_absolute_displacement_m").values.ravel()


@pytest.mark.night
def test_no_other_force_keeps_both_lower(both) -> None:
    found, _ = both
    forces = np.linspace(2.0, 40.0, 20).tolist()
    over = [over_machine_m(force) for force in forces]
    assert np.maximum(over, under_quake_m(forces)).min() > 0.98 * found.nominal.most
    # what is stated is what brute force says of it, and each of the two is told
    own_n = found.build.friction_force_n
    assert found.under[0].most >= over_machine_m(own_n) * (1 - 1e-6)
    assert found.under_records[0].value == pytest.approx(under_quake_m([own_n])[0], rel=1e-9)
    assert found.nominal.value == max(found.under[0].value, found.under_records[0].value)


@pytest.mark.night
def test_the_tuned_mass_damper_is_judged_under_both(both) -> None:
    found, _ = both
    (records,) = found.asked.records
    (case,) = records.cases
    one, motion = found.absorber.absorber, records.motions[case.source.id]
    band = 0.003 * highest(one, 0.02, "base", (2.2 / 2.5, 2.8 / 2.5)).value
    under = response_under(one, 0.02, 5.0 * np.pi, motion, case.scale, records.tail_s)
    assert found.absorber.value == pytest.approx(
        max(band, under.measure(found.asked.measured(case).variable)), rel=1e-12
    )
