"""A general-purpose integrator with events, on the model written a second time, comes to the same states."""

import pytest
from tests.benchmarks._peers import scipy_method

from damperlab.worker.accuracy.cases import SCENES, Scene, references
from damperlab.worker.accuracy.methods import METHODS

TOLERANCE = 1e-10
EVENT = METHODS[0]


@pytest.mark.parametrize(
    "scene",
    [one if one.name == "hybrid" else pytest.param(one, marks=pytest.mark.night) for one in SCENES],
    ids=lambda scene: scene.name,
)
def test_dop853_with_events_agrees(scene: Scene) -> None:
    """Its error per unit of time is about its tolerance, over 60 to 70 units of time, and amplified on the way."""
    found = scipy_method("DOP853", (TOLERANCE,)).march(scene.design, scene.cycles, 1.0 / TOLERANCE)
    ours = EVENT.march(scene.design, scene.cycles, 0.0)
    assert found is not None
    assert ours is not None
    reference = references()[scene.name]
    allowed = 100.0 * TOLERANCE * max(1.0, reference.amplification) * max(abs(x) for x in reference.state)
    for one, other in zip(found, ours, strict=True):
        assert one == pytest.approx(other, rel=0.0, abs=allowed)
