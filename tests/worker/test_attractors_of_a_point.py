"""The responses of one design point from many starts."""

from damperlab.studies.variables import ResponseClass
from damperlab.worker.attractors import find_attractors
from damperlab.worker.point import Design
from damperlab.worker.solver.particle import Particle
from damperlab.worker.steady.settle import Settings

SETTINGS = Settings(4000, 0.02, 1e-9)


def test_two_stable_responses_of_one_point_are_both_met_and_shared_out() -> None:
    """γ_F 0.6, d/Z 2, r 1.1: a symmetric response at 1.675 and one at 2.095 that is not (solver comparison)."""
    found = find_attractors(Design(0.0038, 1.1, 0.6, Particle(2.0, 0.47, 0.1)), 32, 0, SETTINGS)
    amplitudes = sorted(one.response.amplitude_ratio for one in found.met)
    assert len(amplitudes) >= 2
    assert min(abs(a - 1.675) for a in amplitudes) < 1e-3
    assert sum(one.starts for one in found.met) == 32 - found.failed
    assert f"{len(found.met)} responses" in found.sentence


def test_a_point_with_one_response_says_so() -> None:
    found = find_attractors(Design(0.05, 0.8, 0.5, None), 16, 0, SETTINGS)
    assert len(found.met) == 1
    assert found.met[0].starts == 16
    assert found.met[0].from_rest
    assert not found.by_a_rounding
    assert found.sentence == "All of 16 starts lead to one response."


def test_without_friction_and_particle_every_start_leads_to_the_closed_form() -> None:
    found = find_attractors(Design(0.05, 0.8), 8, 0, SETTINGS)
    assert [one.response.response_class for one in found.met] == [ResponseClass.LINEAR]


def test_under_a_force_nothing_is_next_to_a_structure_at_rest() -> None:
    found = find_attractors(Design(0.05, 0.8, 0.5, None, forced=True), 4, 0, SETTINGS)
    assert (found.met[0].starts, found.met[0].from_next_to_rest) == (4, False)
