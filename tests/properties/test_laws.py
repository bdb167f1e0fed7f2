"""Laws of the model, on any design point, through what a user calls: `simulate`."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from tests.properties.designs import (
    CYCLES,
    alone,
    any_design,
    hybrid,
    particles,
    rubbing,
    slipping,
    with_particle,
)

from damperlab.studies.variables import ResponseClass, Status
from damperlab.worker.point import Design
from damperlab.worker.simulate import simulate
from damperlab.worker.solver.particle import Particle

FEW = settings(max_examples=25, deadline=None)
ROUNDING = 1e-12
"""Relative, of positions and velocities that a time history is put together from."""


def arrived(design: Design, cycles: int = CYCLES, history: int = 0) -> Any:
    found = simulate(design, cycles, history=history)
    assert found.metrics["status"] == Status.MAX_CYCLES, found.metrics
    assert found.cycles == cycles
    return found


def size(history: dict[str, NDArray[np.float64]]) -> float:
    return 1.0 + float(np.abs(history["u"]).max())


@FEW
@given(any_design)
def test_work_in_is_lost_or_stored(design: Design) -> None:
    metrics = arrived(design).metrics
    assert metrics["energy_residual"] <= 1e-9
    shares = [metrics[f"dissipation_{kind}"] for kind in ("viscous", "friction", "impact")]
    assert all(0.0 <= share <= 1.0 + ROUNDING for share in shares)
    assert abs(sum(shares) - 1.0) < 1e-9


@FEW
@given(with_particle)
def test_the_particle_stays_between_its_walls(design: Design) -> None:
    history = arrived(design, history=CYCLES).history
    assert design.particle is not None
    gap = np.abs(history["u"] - history["p"])
    assert gap.max() <= design.particle.clearance_ratio + ROUNDING * size(history)


@FEW
@given(st.one_of(alone, rubbing), particles, st.one_of(st.just(0.5), st.floats(0.01, 0.95)))
def test_impacts_conserve_momentum_and_obey_restitution(
    bare: Design, particle: Particle, share: float
) -> None:
    # until the first impact the structure moves as without the particle: within its peak there is one
    clearance = share * arrived(bare).metrics["amplitude_ratio_max"]
    design = replace(bare, particle=particle._replace(clearance_ratio=clearance))
    history = arrived(design, history=CYCLES).history
    assert design.particle is not None
    e, beta = design.particle.restitution, design.particle.mass_ratio
    before = np.flatnonzero(history["impact"][:-1] == 1.0)
    assert before.size > 0
    after = before + 1
    u, p = history["u_rate"], history["p_rate"]
    scale = size({"u": u}) * (1.0 + beta) + beta * float(np.abs(p).max())
    assert np.abs((u[after] - u[before]) + beta * (p[after] - p[before])).max() <= ROUNDING * scale
    approach, leaving = np.abs(u[before] - p[before]), np.abs(u[after] - p[after])
    # An impact either rebounds with e, or ends a chatter and joins the two: then e times nearly nothing is left out.
    joined = leaving <= ROUNDING * scale
    off = np.abs(leaving - e * approach)
    assert (off[~joined] <= ROUNDING * scale).all()
    assert (off[joined] <= 1e-6 * scale).all()


STICKING = Design(0.05, 1.0, 0.7), Design(0.1, 0.5, 0.2), Design(0.05, 0.6, 0.3, Particle(2.0, 0.47, 0.1))


def held_in(history: dict[str, NDArray[np.float64]]) -> NDArray[np.bool_]:
    """From which samples to the next friction holds the mass."""
    rests = history["v_rate"] == 0.0
    # Both ends of a short slip are at rest too, but not in one place.
    held: NDArray[np.bool_] = (
        rests[:-1] & rests[1:] & (np.diff(history["v"]) == 0.0) & (np.diff(history["time"]) > 0.0)
    )
    return held


@pytest.mark.parametrize("design", STICKING)
def test_friction_holds_for_a_while_and_lets_go(design: Design) -> None:
    held = held_in(arrived(design, history=CYCLES).history)
    assert held.any()
    assert not held.all()


@FEW
@given(st.one_of(rubbing, hybrid))
@example(STICKING[0])
@example(STICKING[1])
@example(STICKING[2])
def test_friction_holds_only_what_it_can(design: Design) -> None:
    """While v' = 0 the force |inertia · r² sin rτ − v| is at most γ_F; the inertia is 1 + β with the particle riding."""
    history = arrived(design, history=CYCLES).history
    r = design.frequency_ratio
    held = held_in(history)
    inertia = np.ones(held.size)
    if design.particle is not None:
        same = (
            np.abs(history["u_rate"] - history["p_rate"])[:-1]
            + np.abs(history["u_rate"] - history["p_rate"])[1:]
        )
        # a particle that passes the mass's velocity in flight does not ride
        at_wall = np.abs(history["u"] - history["p"])[:-1] >= design.particle.clearance_ratio * (
            1.0 - ROUNDING
        )
        inertia[at_wall & (same <= ROUNDING * size({"u": history["u_rate"]}))] += design.particle.mass_ratio
    for end in (slice(None, -1), slice(1, None)):
        force = inertia * r * r * np.sin(r * history["time"][end]) - history["v"][end]
        assert np.abs(force[held]).max(initial=0.0) <= design.friction_ratio + 1e-9 * (1.0 + r * r)


@FEW
@given(st.one_of(rubbing, hybrid))
def test_friction_above_every_force_stops_the_mass_for_good(design: Design) -> None:
    """γ_F beyond r² and the spring: the initial speed −r is braked away, and nothing moves the mass again."""
    held = Design(design.damping_ratio, design.frequency_ratio, 2.0 * design.frequency_ratio**2 + 20.0)
    history = arrived(held, history=CYCLES).history
    # The initial speed −r is stopped within r²/(2 γ_F) and then nothing moves again.
    assert np.abs(history["v"]).max() <= held.frequency_ratio**2 / (
        2.0 * (held.friction_ratio - held.frequency_ratio**2)
    )
    late = history["time"] > 2.0 * np.pi / held.frequency_ratio
    assert np.abs(history["v_rate"][late]).max() == 0.0


@FEW
@given(slipping)
def test_half_a_period_later_the_settled_motion_is_its_mirror_image(design: Design) -> None:
    """A transient dies as exp(−ζτ): with ζ ≥ 0.05 and r ≤ 4 it is below 1e-13 after 400 cycles."""
    history = arrived(design, 400, history=1).history
    half = history["time"].size // 2
    assert history["time"].size == 2 * half
    for name in ("u", "v", "u_rate", "v_rate"):
        column = history[name]
        assert np.abs(column[:half] + column[half:]).max() <= 1e-9 * (1.0 + np.abs(column).max()), name


def comes_to_the_same(design: Design, bare: Design) -> Any:
    """Compare where two designs arrive, but for rounding; give what is known of the first."""
    found, known = arrived(design), arrived(bare)
    scale = 1.0 + abs(known.state["u"]) + abs(known.state["u_rate"])
    for name in ("u", "u_rate"):
        off = abs(found.state[name] - known.state[name])
        assert off <= 1e-11 * scale * max(1.0, design.frequency_ratio)
    return found


@FEW
@given(alone, st.floats(1e-3, 20.0), st.floats(0.0, 0.9))
def test_a_particle_without_mass_does_nothing(bare: Design, clearance: float, restitution: float) -> None:
    comes_to_the_same(replace(bare, particle=Particle(clearance, restitution, 0.0)), bare)


@FEW
@given(alone)
def test_friction_of_next_to_nothing_does_nothing(bare: Design) -> None:
    comes_to_the_same(replace(bare, friction_ratio=1e-14), bare)


@FEW
@given(rubbing)
def test_a_particle_far_from_its_walls_does_nothing(bare: Design) -> None:
    assert comes_to_the_same(replace(bare, particle=Particle(1e6, 0.47, 0.1)), bare).events["impacts"] == 0


@FEW
@given(slipping)
def test_friction_never_lets_the_mass_move_further_from_the_base(design: Design) -> None:
    """Relative to the base, the steady response with friction is no larger than without: friction only takes energy.

    At r ≥ 1/3 no superharmonic of the friction force meets the resonance (Den Hartog 1931), so this holds there.
    """
    design = replace(design, frequency_ratio=max(design.frequency_ratio, 0.5))
    rubbed = simulate(design).metrics
    bare = simulate(replace(design, friction_ratio=0.0)).metrics
    assert rubbed["status"] == Status.CONVERGED
    assert rubbed["response_class"] != ResponseClass.LOCKED
    assert rubbed["relative_amplitude_ratio"] <= bare["relative_amplitude_ratio"] * (1.0 + 1e-6) + 1e-6
