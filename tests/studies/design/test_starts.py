"""What other starts than rest lead a recommended damper to, with the real solver."""

from typing import Any

import pytest
from tests.studies.design.test_design import BUDGET, DAMPED, pursued

from damperlab.studies.design.design import designing
from damperlab.studies.design.found import Found
from damperlab.studies.specification.reading import parse_specification
from damperlab.studies.specification.specification import JUDGES
from damperlab.studies.variables import ResponseClass
from damperlab.worker.point import Design, simulate_ready
from damperlab.worker.solver.particle import Particle

LIGHT: dict[str, Any] = DAMPED | {
    "structure": DAMPED["structure"] | {"damping_ratio": 0.005},
    "choose": {"clearance_m": [0.009, 0.012]},
    "friction_force_n": 5.0,
    "restitution": 0.8,
    "tolerances": {},
}
"""Wide cavities in which the particle rests or bounces, by how it was started."""


@pytest.fixture(scope="module")
def light() -> Found:
    return pursued(LIGHT)[0]


@pytest.mark.night
def test_the_responses_at_a_frequency_are_told_apart(light: Found) -> None:
    starts = light.starts
    assert starts.several == len(starts.where) > 0
    for at in starts.where:
        assert at.attractors >= len(at.responses) > 1
        shares = [each.share for each in at.responses]
        # every start leads to one of them, to a further one, or fails
        assert sum(shares) + at.share_left == pytest.approx(1.0, abs=1e-9)
        assert shares == sorted(shares, reverse=True)
        assert (
            max(each.displacement for each in at.responses)
            <= at.highest * (1 + 1e-9)
            <= starts.worst * (1 + 1e-9)
        )
        assert all(each.value == each.displacement for each in at.responses)
        assert sum(each.from_rest for each in at.responses) <= 1


@pytest.mark.parametrize("judge", JUDGES)
def test_every_study_of_a_search_computes_the_response_that_counts(judge: str) -> None:
    ask = next(designing(parse_specification(DAMPED | {"judge": judge}), BUDGET))
    for study in ask.studies:
        document = study.document()
        assert (document["start"] == "rest") == (judge == "rest")
        assert ("amplitude_ratio_worst" in document["metrics"]) == (judge == "worst")


@pytest.mark.night
def test_the_response_from_rest_is_that_of_a_single_point(light: Found) -> None:
    starts, build, structure = light.starts, light.build, light.asked.structure
    _, restitution, mass, clearance, friction = build.place(structure, 0.001)
    from_rest = [(at.frequency_ratio, each) for at in starts.where for each in at.responses if each.from_rest]
    assert from_rest
    for r, each in from_rest[:3]:
        point = simulate_ready(
            Design(structure.damping_ratio, r, friction, Particle(clearance, restitution, mass)),
            followed=False,
        ).metrics
        assert each.displacement == pytest.approx(0.001 * float(point["amplitude_ratio"]), rel=1e-9)
        assert each.response_class == ResponseClass(int(point["response_class"])).name.lower()
