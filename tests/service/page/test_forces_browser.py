"""Forces on the structure as the page draws them: together they are what accelerates it."""

from collections.abc import Callable
from typing import Any

import httpx
import numpy as np
import pytest

pytestmark = pytest.mark.night

FORCES = """async ([history, r, damper, module]) => {
  const { History } = await import(module.replace("main.js", "history.js"));
  const { forcesOn } = await import(module.replace("main.js", "forces.js"));
  return forcesOn(new History(history, r), damper);
}"""
MODULE = "document.querySelector('script[type=module]').src"


@pytest.mark.parametrize(
    ("point", "held"),
    [
        ({"frequency_ratio": 0.45, "friction_ratio": 0.15, "particle": False}, True),
        ({"frequency_ratio": 1.0, "friction_ratio": 0.3, "particle": False}, False),
        ({"frequency_ratio": 1.0, "friction_ratio": 0.3, "clearance_ratio": 6.0}, False),
        ({"frequency_ratio": 0.45, "friction_ratio": 0.6, "particle": False, "excitation": "force"}, True),
        (
            {"frequency_ratio": 1.0, "friction_ratio": 0.3, "clearance_ratio": 6.0, "excitation": "force"},
            False,
        ),
    ],
)
def test_the_forces_accelerate_the_structure(
    open_page: Callable[..., Any], client: httpx.Client, point: dict[str, Any], held: bool
) -> None:
    of_particle = {"restitution": 0.5, "mass_ratio": 0.1} if "clearance_ratio" in point else {}
    asked = {"damping_ratio": 0.02, **of_particle, **point, "history": 4, "samples": 20_000}
    history = client.post("/api/v1/simulate", json=asked, timeout=300.0).raise_for_status().json()["history"]
    page = open_page().go("")
    clearance = asked.get("clearance_ratio")
    damper = {
        "damping": asked["damping_ratio"],
        "friction": asked["friction_ratio"],
        "mass": asked.get("mass_ratio", 0),
        "clearance": clearance,
        "forced": asked.get("excitation") == "force",
    }
    forces = page.evaluate(FORCES, [history, asked["frequency_ratio"], damper, page.evaluate(MODULE)])
    sums = np.sum([forces[name] for name in ("spring", "damping", "friction", "force")], axis=0)
    time, rate = np.array(history["time"]), np.array(history["u_rate"])
    slip, struck = np.array(history["v_rate"]), np.array(history["impact"]) > 0
    step = np.diff(time)
    # by trapezoids; a step in which something strikes, turns, sticks or slips away has no smooth force
    jumps = np.abs(np.diff(forces["friction"])) > 0.5 * asked["friction_ratio"]
    smooth = (step > 0) & ~struck[1:] & ~struck[:-1] & ~jumps & (slip[1:] * slip[:-1] >= 0)
    gained = np.diff(rate)[smooth]
    given = (0.5 * (sums[1:] + sums[:-1]) * step)[smooth]
    # of a trapezoid the error is h³/12 of the second derivative, which the largest force bounds several times over
    bound = step[smooth] ** 3 * np.abs(sums).max() + 1e-9 * np.abs(rate).max()
    assert smooth.mean() > 0.6
    assert np.mean(np.abs(gained - given) <= bound) > 0.99
    stuck = np.abs(slip) <= 1e-9 * np.abs(slip).max()
    # at a turn a sample or two is at rest, too
    assert (step[stuck[1:] & stuck[:-1]].sum() > 0.02 * step.sum()) == held
    assert np.all(np.abs(forces["friction"]) <= asked["friction_ratio"])
