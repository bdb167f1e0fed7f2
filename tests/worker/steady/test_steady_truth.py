"""Steady answers against plain marches, and what looks for orbits never touching the run."""

from itertools import islice

import numpy as np
import pytest
from tests.worker.designs_drawn import solved
from tests.worker.forms import night
from tests.worker.plain_march import marched, metered, plain_end

from damperlab.studies.variables import ResponseClass, Status
from damperlab.worker.accuracy.steady_answers import SETTINGS, TRANSIENT, WARNED, Point, every, points
from damperlab.worker.solver.particle import Particle
from damperlab.worker.steady.settle import Settings
from damperlab.worker.steady.stopping_rules import FEWEST_MEASURED


@pytest.mark.parametrize(
    ("model", "number", "failed", "several", "transient", "frictionless"),
    [
        ("instant", 40, 1, 2, 1, False),
        night("instant", 120, 3, 4, 1, True),
        night("dwell", 30, 1, 1, 0, True),
        night("compliant", 30, 1, 1, 0, True),
    ],
)
def test_random_answers_are_what_plain_marches_come_to(
    model: str, number: int, failed: int, several: int, transient: int, frictionless: bool
) -> None:
    """A short form of the benchmark `steady`; a point with several responses may be met in another than the march is.

    One irregular answer of a hundred settles after its run has ended (docs/accuracy.md). The march without friction is a
    kernel of its own, which the night alone compiles.
    """
    drawn = (point for point in points(5, (model,)) if frictionless or point.friction is not None)
    answers = list(every(islice(drawn, number), 5000))
    wrong = [
        one
        for one in answers
        if not one.verdict.startswith(("agrees", "several responses", TRANSIENT, WARNED))
    ]
    assert len(answers) >= number - failed
    assert wrong == []
    assert sum(one.verdict.startswith("several responses") for one in answers) <= several
    assert sum(one.verdict == TRANSIENT for one in answers) <= transient


MET = {
    "Newton finds an orbit that repels, to which chaos comes back on the way": (
        (0.0037417947179528826, 0.9504020462770211, 0.679985236026813),
        (0.7183058668567155, 0.7032737803356611, 0.02890265048630109),
        (1, 6.0),
    ),
    "an orbit with one impact a half cycle is near a run with 2, 7, 2 and 1": (
        (0.02938829498296216, 2.0022119508323226, None),
        (0.30084777945557656, 0.08719964108263989, 0.01920346939838433),
        (1, 4.0),
    ),
    "just beyond a period doubling the shorter orbit repels, 1e-6 from the longer one": (
        (0.002113120949328602, 1.2060100753492171, 0.33740107370351746),
        (0.7103487631805168, 0.42226738758543764, 0.016265346921454663),
        (4, None),
    ),
    "irregular for thousands of cycles beside a stable orbit of two": (
        (0.0033761187698884477, 0.978118903312964, None),
        (5.647954248171946, 0.7734920644219078, 0.12917198227863555),
        (2, None),
    ),
    "the same, without friction": (
        (0.022413983658043594, 0.9601026383762801, None),
        (2.648643418947877, 0.8572730983034805, 0.40219345254106503),
        (1, None),
    ),
    "the same, with friction": (
        (0.0026352902322289047, 0.8603016675426848, 0.36169473853945333),
        (2.347257698625658, 0.9394384673573526, 0.28112166505672337),
        (1, None),
    ),
    "irregular for thousands of cycles, with a mean that was known after 960, near a stable orbit of six half cycles": (
        (0.00414770400063477, 1.156756374106636, None),
        (0.9732287903860549, 0.31222729334402405, 0.3413837193090553),
        (3, None),
    ),
    "irregular for 1,800 cycles with twice the peaks of its end, to which it comes no nearer than a third": (
        (0.014708874293940317, 1.2343384684814027, 0.38634141183347037),
        (2.378198271861408, 0.3071663756156364, 0.431484763127309),
        (1, None),
    ),
    "irregular for 3,200 cycles, with peaks 14 % below those of its end, which repeats after eight half cycles": (
        (0.005761459494952959, 0.9378346682708647, 0.04234800324975119),
        (7.771481812907288, 0.024495780673616872, 0.3590959940771198),
        (4, None),
    ),
    "irregular for 1,000 cycles, with a mean that was known after 816, near a stable orbit of 13 half cycles": (
        (0.019751202392796055, 0.9715626047237007, None),
        (6.658841049343883, 0.0019387850445991505, 0.33225099695116483),
        (13, None),
    ),
}
"""Why it is met: ζ, r and γ_F; d/Z, e and β; the period of the response and its impacts a cycle."""


@pytest.mark.parametrize("why", MET)
def test_the_response_is_the_one_that_a_long_plain_march_comes_to(why: str) -> None:
    """Where its mean is known to the tolerance long before, or another orbit lies near."""
    structure, particle, (period, impacts) = MET[why]
    point = Point(*structure, Particle(*particle))
    response, _ = solved(point)
    assert response.period == period
    halves = metered(*point, marched(*point, point.rest(), 24_000), 120 * period + 1)
    assert response.floquet_multiplier < 1.0
    assert response.impacts_per_cycle == pytest.approx(2.0 * halves.impacts[1:].mean(), rel=1e-12)
    assert impacts in (None, response.impacts_per_cycle)
    assert response.amplitude_ratio == pytest.approx(halves.windows.mean(), rel=1e-8)


CHAOTIC = Point(0.0038, 1.0, 0.6, Particle(5.0, 0.47, 0.1))


@pytest.mark.parametrize("cycles", [40, 400])
def test_the_run_is_a_plain_march_whatever_looks_for_orbits_beside_it(cycles: int) -> None:
    """Chaos magnifies a difference of one bit e-fold every few cycles: only equal bits stay equal over hundreds of them."""
    response, end = solved(CHAOTIC, Settings(cycles, 1e-8, 1e-9))
    assert response.status == Status.MAX_CYCLES
    assert response.cycles == cycles
    assert end == plain_end(CHAOTIC, CHAOTIC.rest(), cycles)


SUBHARMONIC = (
    (11.0, 0.3, 0.30000000000000004),
    (4.5, 0.675, 0.6750000000000002),
)


@pytest.mark.parametrize(("clearance", "friction", "beside"), SUBHARMONIC)
def test_a_subharmonic_and_its_mirror_image_have_the_same_measures(
    clearance: float, friction: float, beside: float
) -> None:
    """Which of the two is met is decided by a last bit of the friction, or by the sign of the start."""
    one = Point(0.0038, 1.0, friction, Particle(clearance, 0.47, 0.1))
    first, end = solved(one)
    assert first.period > 1
    mirrored = end._replace(v=-end.v, w=-end.w, slip=-end.slip, wall=-end.wall, p_rate=-end.p_rate)
    # the mirror image of a state at phase 0 moves under −s: half a cycle later the base is there
    second, _ = solved(Point(0.0038, 1.0, beside, one.particle))
    third, _ = solved(one, start=mirrored)
    for other in (second, third):
        if other.period != first.period:
            continue  # the mirrored state at this phase belongs to another basin
        for name in (
            "amplitude_ratio",
            "amplitude_ratio_max",
            "amplitude_ratio_rms",
            "relative_amplitude_ratio",
            "impacts_per_cycle",
            "impact_speed_max",
            "dissipation_impact",
        ):
            assert getattr(other, name) == pytest.approx(getattr(first, name), rel=1e-10), name
    assert second.period == first.period


CHAOTIC_OF_FIGURE_11 = (
    (10.0, 0.3),
    (14.0, 0.2),
    (16.0, 0.35),
    (18.0, 0.4),
    (19.0, 0.2),
    (21.0, 0.05),
    (24.0, 0.3),
)


def test_a_run_ends_soon_after_its_error_is_small_enough() -> None:
    """A look lies at most a quarter beyond the one before, so a run hardly spends a quarter more than its error asks for."""
    spent = asked = 0.0
    for clearance, friction in CHAOTIC_OF_FIGURE_11:
        point = Point(0.0038, 1.0, friction, Particle(clearance, 0.47, 0.1))
        response, _ = solved(point)
        assert response.status == Status.CONVERGED
        assert response.response_class == ResponseClass.CHAOTIC
        measured = response.cycles - 0.73 * point.frequency_ratio / point.damping_ratio
        share = response.amplitude_error / (SETTINGS.tolerance * response.amplitude_ratio)
        spent += measured
        asked += max(FEWEST_MEASURED, measured * share**2)
    assert spent <= 1.25 * asked


def test_the_error_of_impacts_per_cycle_and_of_shares_is_that_of_runs_elsewhere_on_the_attractor() -> None:
    """Sixteen stretches of one chaotic attractor scatter by what each states; the spread of 16 is known to 18 %."""
    state = CHAOTIC.rest()
    runs = []
    for _ in range(16):
        response, state = solved(CHAOTIC, Settings(1400, 1e-8, 1e-9), state)
        assert response.response_class == ResponseClass.CHAOTIC
        runs.append(response)
    for name, error in (("impacts_per_cycle", "impacts_error"), ("dissipation_impact", "dissipation_error")):
        scatter = float(np.std([getattr(run, name) for run in runs], ddof=1))
        stated = float(np.mean([getattr(run, error) for run in runs]))
        assert 0.4 * stated <= scatter <= 1.8 * stated, name


def test_impacts_without_end_are_bounded_by_a_count_of_events() -> None:
    """d/Z 1e-6, e = 1: a million impacts each half cycle. The same number of events is allowed on every machine."""
    response, _ = solved(Point(0.0038, 1.0, 0.6, Particle(1e-6, 1.0, 0.1)))
    assert response.status == Status.TOO_MANY_EVENTS
    assert response.cycles <= 16
