"""The report on accuracy: references, orders and cases at the edge."""

from math import pi

import pytest
from tests.reference.make_accuracy import point_of
from tests.reference.simulator import simulate as simulate_in_digits
from tests.worker.plain_python import plainly

from damperlab.worker.accuracy.cases import SCENES, references
from damperlab.worker.accuracy.extremes import extreme_cases
from damperlab.worker.accuracy.methods import METHODS, Method
from damperlab.worker.accuracy.report import advantages
from damperlab.worker.accuracy.stability import Row, run_case
from damperlab.worker.accuracy.work_precision import Measurement, measure_method, observed_order

NAMES = ("u", "u_rate", "p", "p_rate")
BY_NAME = {scene.name: scene for scene in SCENES}
PAPER = METHODS[-1]


def test_every_scene_has_a_reference() -> None:
    assert set(references()) == set(BY_NAME)


@pytest.mark.parametrize("name", ["friction", "hybrid"])
def test_kept_references_are_what_the_reference_simulator_computes(name: str) -> None:
    point = point_of(BY_NAME[name])
    scene = (point.damping_ratio, point.frequency_ratio, point.friction_ratio, point.particle)
    truth = simulate_in_digits(*scene, cycles=point.cycles, digits=30)
    assert references()[name].state == tuple(float(truth[one]) for one in NAMES)


@pytest.mark.night
@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.name)
@pytest.mark.parametrize("method", METHODS[:2], ids=lambda method: method.name)
def test_event_driven_march_is_exact_up_to_amplified_rounding(method: Method, scene: object) -> None:
    (point,) = measure_method(method, scene).points  # type: ignore[arg-type]
    assert point.error < 1e-13 * max(1.0, references()[scene.name].amplification)  # type: ignore[attr-defined]


def test_order_of_the_paper_method_without_and_with_events() -> None:
    smooth = Method(PAPER.name, PAPER.setting, (50, 100, 200, 400), PAPER.march)
    order = measure_method(smooth, BY_NAME["linear"]).order
    assert order == pytest.approx(4.0, abs=0.1)  # the next term of the error is smaller by 2π/50
    stepped = Method(PAPER.name, PAPER.setting, (400, 800, 1600, 3200, 6400), PAPER.march)
    order = measure_method(stepped, BY_NAME["chatter"]).order
    assert order == pytest.approx(
        1.0, abs=0.35
    )  # noticed up to a step late: first order, scattered by a random share


def test_order_is_the_slope_and_leaves_rounding_out() -> None:
    exact = [Measurement(n, 3.0 * n**-2.0, 1.0) for n in (10, 20, 40, 80)]
    assert observed_order(exact) == pytest.approx(2.0)
    floored = [*exact, Measurement(160, 1e-15, 1.0), Measurement(320, None, 1.0)]
    assert observed_order(floored) == pytest.approx(2.0)
    assert observed_order(floored[3:]) is None


def computed() -> dict[str, Row]:
    """Rows of the cases at a tie, and of one case twice, the second time with a limit that no residual keeps."""
    cases = extreme_cases(100)
    rows = {case.name: run_case(case) for case in cases if case.name.startswith(("graz", "chatter end"))}
    case = next(one for one in cases if one.name == "e = 1, hybrid")
    strict = type(case)(case.name, case.design, case.cycles, residual_limit=-1.0)
    return rows | {"kept": run_case(case), "exceeded": run_case(strict)}


@pytest.fixture(scope="module")
def rows() -> dict[str, Row]:
    """Computed in plain Python: compiling the kernels takes longer."""
    found: dict[str, Row]
    (found,) = plainly(computed, [()])
    return found


def test_extreme_cases_that_are_built_hit_their_tie(rows: dict[str, Row]) -> None:
    """Grazing: no impact just outside, at least one just inside. Chatter: one attachment more on one side."""
    graze = {name: row.impacts for name, row in rows.items() if name.startswith("graz")}
    assert graze["grazing impact, d/Z = peak (1 + 1e-13)"] == 0
    assert graze["grazing impact, d/Z = peak (1 − 1e-6)"] > 0
    before, after = (rows[f"chatter ending just {side} release"] for side in ("before", "after"))
    assert before.attachments > after.attachments
    assert all(rows[name].passed for name in (*graze, before.name, after.name))


def test_residual_above_its_limit_fails_a_case(rows: dict[str, Row]) -> None:
    assert rows["kept"].passed
    assert not rows["exceeded"].passed


def test_advantage_is_over_the_slower_of_ours_and_only_where_ours_is_no_worse() -> None:
    from damperlab.worker.accuracy.work_precision import Curve, Diagram

    ours = (
        Curve("a", "", (Measurement(0, 1e-14, 1.0),), None),
        Curve("b", "", (Measurement(0, 1e-13, 2.0),), None),
    )
    rough = Curve("rough", "steps", (Measurement(1, 1e-2, 5.0), Measurement(2, 1e-3, 10.0)), None)
    finer = Curve("finer", "steps", (Measurement(1, 1e-16, 3.0),), None)
    lost = Curve("lost", "steps", (Measurement(1, None, pi),), None)
    found = advantages(Diagram("s", "s", 1, (*ours, rough, finer, lost)))
    assert found["rough"]["times_slower"] == 5.0
    assert found["finer"]["times_slower"] is None
    assert "lost" not in found
