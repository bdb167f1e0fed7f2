"""A march begun anew just after one of its events, as if nothing had been before, comes to the same end."""

from collections.abc import Callable
from itertools import product
from math import ceil, pi

import numpy as np
import pytest
from hypothesis import given, reject, settings
from hypothesis import strategies as st
from tests.properties.designs import (
    compliant,
    damping_ratios,
    dragged,
    dwelling,
    frequency_ratios,
    friction_ratios,
    particles,
)
from tests.worker.forms import night

from damperlab.worker.point import Design
from damperlab.worker.solver.events import ARRIVED, BUDGET, NOTHING
from damperlab.worker.solver.excitation.excitation import next_half_start
from damperlab.worker.solver.excitation.sine import make_sine
from damperlab.worker.solver.integrate import half_cycle
from damperlab.worker.solver.motion.quadratic_forms import base_forms
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.scene import scene_on
from damperlab.worker.solver.segment_log import Logged, empty_log, stored_rows
from damperlab.worker.solver.state import State
from damperlab.worker.steady.section.coordinates import coordinates, state_at
from damperlab.worker.steady.start import at_rest

HALVES = 6
STEP = 1e-8
"""Of the perturbations that show how a march amplifies, relative."""
MOST = 1e6
"""Largest amplification, of the way to the restart times that from it: beyond, few digits are left to compare."""
ROUNDING = 1e-14
"""Relative: 1e-16 of each of the segments, of which there may be a hundred, without order."""
SHORTEST = 1e-6
"""Segment worth a restart [1/ω_n]: in a shorter one a flight has few digits."""


class March:
    """The march of a design through any part of a half cycle."""

    def __init__(self, design: Design) -> None:
        self.design = design
        self.friction = design.friction_ratio if design.friction_ratio > 0.0 else None
        self.base = make_sine(design.damping_ratio, design.frequency_ratio, True)
        self.half = pi / design.frequency_ratio
        self.log = empty_log(4096)

    def through(self, state: State, begin: float, end: float) -> State:
        """From one time of a half cycle to another, in windows of its own, so that nothing is known of another march."""
        r = self.design.frequency_ratio
        count = max(1, ceil((end - begin) / self.base.window))
        phases = r * np.linspace(begin, end, count + 1)
        sine, cosine = np.sin(phases), np.cos(phases)
        if end == self.half:
            sine[-1], cosine[-1] = 0.0, -1.0
        window = (end - begin) / count
        base = self.base._replace(
            window=window, windows=count, sine=sine, cosine=cosine, forms=base_forms(self.base.rows, window)
        )
        scene = scene_on(base, self.friction, self.design.particle, True)
        scene.counts[BUDGET] = 100_000
        self.log.cursor[0] = 0
        state, outcome = half_cycle(state, scene, None, self.log)
        assert outcome == ARRIVED
        return next_half_start(base, state)

    def on(self, state: State, halves: int) -> State:
        """Through whole half cycles."""
        for _ in range(halves):
            state = next_half_start(self.base, self.through(state, 0.0, self.half))
        return state

    def point(self, state: State) -> np.ndarray:
        """v, w, p, p' less those of the base."""
        out = np.zeros(4)
        coordinates(state._replace(riding=0.0), self.design.particle, out)
        return out

    def amplification(self, way: Callable[[State], State], start: State) -> float:
        """How far apart, over what they were, motions end that start a little beside one, where its regime allows it."""
        end = self.point(way(start))
        out = np.zeros(4)
        coordinates(start, self.design.particle, out)
        most = 1.0
        for i, sign in product(range(4), (1.0, -1.0)):
            moved = out.copy()
            moved[i] += sign * STEP * (1.0 + abs(moved[i]))
            other, possible = state_at(moved, start, self.design.particle)
            if possible and not (i == 1 and self.friction is not None and start.slip == 0.0):
                most = max(most, np.abs(self.point(way(other)) - end).max() / STEP)
        return most


def comes_to_the_same_end(design: Design, which: int, share: float) -> None:
    march = March(design)
    before = march.on(at_rest(design.frequency_ratio, march.friction, design.particle), HALVES)
    march.through(before, 0.0, march.half)
    logged = Logged(*stored_rows(march.log).T.copy())
    assert march.log.cursor[0] <= march.log.capacity
    after = np.flatnonzero((logged.event[:-1] != NOTHING) & (logged.duration[1:] > SHORTEST)) + 1
    if after.size == 0:
        reject()
    following = after[which % after.size]
    restart = float(logged.start[following] + share * logged.duration[following])

    def to_restart(state: State) -> State:
        return march.through(state, 0.0, restart)

    def to_end(state: State) -> State:
        return march.on(next_half_start(march.base, march.through(state, restart, march.half)), 2)

    middle = to_restart(before)
    assert (middle.slip_order, middle.gap_order) == (0, 0)  # nothing of the event is left in it
    end = march.on(before, 3)
    again = to_end(middle)
    grown = march.amplification(to_restart, before) * march.amplification(to_end, middle)
    if grown > MOST:
        reject()
    scale = 1.0 + np.abs(march.point(before)).max()
    assert np.abs(march.point(again) - march.point(end)).max() <= ROUNDING * grown * scale


SCENES = {
    "friction alone": st.none(),
    "instant": particles,
    "dwell": dwelling,
    "compliant": compliant,
    "rubbing": dragged,
}
RESTARTS = (st.integers(0, 1000), st.floats(1e-3, 0.999))
FEW = settings(max_examples=25, deadline=None)


@pytest.mark.parametrize(
    ("scene", "friction"),
    [
        ("friction alone", True),
        ("instant", False),
        ("instant", True),
        *(
            night(scene, friction)
            for scene in ("dwell", "compliant", "rubbing")
            for friction in (False, True)
        ),
    ],
)
def test_restart_after_any_event_comes_to_the_same_end(scene: str, friction: bool) -> None:
    frictions = friction_ratios if friction else st.just(0.0)

    @FEW
    @given(st.builds(Design, damping_ratios, frequency_ratios, frictions, SCENES[scene]), *RESTARTS)
    def holds(design: Design, which: int, share: float) -> None:
        comes_to_the_same_end(design, which, share)

    holds()


@pytest.mark.night
def test_a_touch_without_speed_holds_nothing() -> None:
    """A particle that rode on a held mass is released where the base is fastest: at the end of a half cycle, or just before."""
    particle = Particle(1.0, 0.0, 0.1, contact_time=0.5)
    comes_to_the_same_end(Design(0.5, 0.5, 0.4, particle), 0, 0.001953125)
