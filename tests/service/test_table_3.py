"""The prototype of Table 3 with the particle's own friction."""

import pytest

from damperlab.service.reproduction.rubbing import Prototype, computed_here, deviation, peaks_of
from damperlab.studies.definition import parse_harmonic
from damperlab.studies.paper import paper_numbers


def test_a_particle_that_its_friction_carries_meets_no_wall() -> None:
    """Then the cavity's length is of no account, and the particle is mass: the peak of m(1 + β) on the same spring.

    Every metric is asked for, and of friction next to none: the kernels of this scene are compiled already.
    """
    asked = Prototype(0.0001, 0.03, 0.2).study().document()
    del asked["metrics"]
    asked["axes"]["friction_ratio"][0] = 1e-13
    peaks = peaks_of(computed_here(parse_harmonic(asked)))
    assert peaks["particle_1"] == pytest.approx(peaks["particle_3"], rel=1e-12)
    beta = paper_numbers()["mass_ratio"].value
    ratios = [0.86 + 0.26 * i / 52 for i in range(53)]
    closed = [abs(complex(1, 0.06 * r) / complex(1 - (1 + beta) * r * r, 0.06 * r)) for r in ratios]
    assert peaks["particle_2"] == pytest.approx(max(closed), rel=1e-9)


def test_a_prototype_that_measures_what_is_printed_deviates_by_nothing() -> None:
    """One number twice as large, of six, deviates by ln 2/√6."""
    printed = {
        f"{kind}_{k}": paper_numbers()[f"{kind}_{k}"].value
        for kind in ("particle", "hybrid")
        for k in (1, 2, 3)
    }
    assert deviation(printed) == 0.0
    assert deviation({**printed, "hybrid_2": 2 * printed["hybrid_2"]}) == pytest.approx(
        0.6931471805599453 / 6**0.5
    )
