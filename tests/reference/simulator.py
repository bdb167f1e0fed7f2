"""Event-driven reference simulator of the hybrid damper, in as many digits as wanted.

It shares no code with the solver under test. Between events the state is the exact closed form
(`tests.reference.motion`); events are found by a dense scan that isolates extrema first
(`tests.reference.roots`). Slow and plain on purpose.

The model, dimensionless: v'' + 2 zeta v' + v + gamma Sgn(v') = r^2 sin(r tau), u = v + sin(r tau), p'' = 0,
|u - p| <= delta, with Newton's impact law (restitution e, mass ratio beta) at the walls.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from tests.reference.motion import Motion
from tests.reference.numbers import DoubleNumbers, ExtendedNumbers, Numbers, Real
from tests.reference.roots import Triple, first_zero, zero_between

SAMPLES = 200  # scan steps per 2 pi / max(1, r)
Sample = tuple[list[Real], list[Real]]


@dataclass
class State:
    """Where everything is: v relative to the base, gap = u - p; wall = +-1 while attached at gap = +-delta."""

    time: Real
    v: Real
    v_rate: Real
    gap: Real
    p_rate: Real
    wall: int = 0
    stuck: bool = False


@dataclass(frozen=True)
class Watch:
    """A function that is positive until its event: its value and two derivatives from a sample."""

    name: str
    triple: Callable[[Sample, Real], Triple]


class Simulation:
    """One run. See `simulate` for the parameters."""

    def __init__(
        self,
        numbers: Numbers,
        zeta: Real,
        r: Real,
        gamma: Real,
        particle: tuple[Real, Real, Real] | None,
        peaks: bool = False,
        energy: bool = False,
    ) -> None:
        convert = numbers.convert
        self.numbers = numbers
        self.zeta, self.r, self.gamma = convert(zeta), convert(r), convert(gamma)
        self.particle = particle is not None
        self.delta, self.e, self.beta = (convert(x) for x in (particle or (1, 0, 0)))
        self.zero = convert(0)
        self.step = 2 * numbers.pi / SAMPLES / max(self.r, convert(1))
        # Chatter is cut where the rebound is this slow; the cut changes the answer by about its square.
        exponent = -numbers.digits * 3 // 8
        self.join_speed = convert(10) ** exponent * max(self.r, convert(1))
        self.tiny = numbers.rounding**3
        self.state = State(self.zero, self.zero, -self.r, self.zero, self.zero)
        # How many leading derivatives of a watched function vanish at the start of a segment.
        self.vanishing: dict[str, int] = {}
        self.slip = 0  # friction direction: sign of v', 0 while stuck or without friction
        self.impacts = self.turns = self.sticks = self.attachments = self.releases = 0
        self.impact_loss = self.friction_loss = self.viscous_loss = self.work_in = self.zero
        self.stuck_time = self.zero
        self.peaks_wanted, self.energy_wanted = peaks, energy
        self.peak_u = self.peak_v = self.zero
        self.cycle_peaks: list[tuple[Real, Real]] = []
        self.max_impact_speed = self.zero
        self.events: list[tuple[Real, str]] = []

    # ---- state ----------------------------------------------------------------------------------------

    def base(self) -> tuple[Real, Real]:
        """Return displacement and velocity of the base now."""
        cos_base, sin_base = self.numbers.cos_sin(self.r * self.state.time)
        return sin_base, self.r * cos_base

    def absolute(self) -> tuple[Real, Real, Real, Real]:
        """Return u, u', p, p' now."""
        state = self.state
        base, base_rate = self.base()
        u, u_rate = state.v + base, state.v_rate + base_rate
        if not self.particle:
            return u, u_rate, self.zero, self.zero
        p_rate = u_rate if state.wall else state.p_rate
        return u, u_rate, u - state.gap, p_rate

    def stored_energy(self) -> Real:
        """Return kinetic + potential energy over k Z^2."""
        u, u_rate, p, p_rate = self.absolute()
        return (u_rate**2 + self.state.v**2 + self.beta * p_rate**2) / 2

    def mass(self, wall: int) -> Real:
        """Return the moving mass: 1, or 1 + beta while attached."""
        return 1 + self.beta if wall else self.zero + 1

    def inertia_force(self, wall: int) -> tuple[Real, Real]:
        """Return F = mu r^2 sin(r t) - v and its rate at v' = 0: friction must balance it in stick."""
        cos_base, sin_base = self.numbers.cos_sin(self.r * self.state.time)
        scale = self.mass(wall) * self.r**2
        return scale * sin_base - self.state.v, scale * self.r * cos_base

    # ---- regime ---------------------------------------------------------------------------------------

    def friction_regime(self, wall: int) -> tuple[int, bool, dict[str, int]]:
        """Return slip direction, stuck, and vanishing orders for the state taken as free or attached."""
        if self.gamma == 0:
            return 0, False, {}
        if self.state.v_rate != 0:
            return (1 if self.state.v_rate > 0 else -1), False, {}
        force, rate = self.inertia_force(wall)
        direction = 1 if force > 0 else -1
        excess = abs(force) - self.gamma
        if abs(excess) <= self.noise(0):
            if direction * rate > 0:
                return direction, False, {"turn": 2}
            return 0, True, {"loose+" if direction > 0 else "loose-": 1}
        if excess > 0:
            return direction, False, {"turn": 1}
        return 0, True, {}

    def motion(self, wall: int, slip: int, stuck: bool) -> Motion:
        """Return the closed form that continues the state in the given regime."""
        state = self.state
        return Motion(
            self.numbers,
            self.zeta,
            self.r,
            self.mass(wall),
            self.gamma * slip,
            state.time,
            (state.v, state.v_rate),
            stuck,
        )

    def noise(self, order: int) -> Real:
        """Return what counts as zero for a displacement and its derivatives."""
        scale = 1 + abs(self.state.v) + abs(self.gamma)
        return self.numbers.rounding * scale * max(self.r, self.zero + 1) ** order

    def settle(self) -> Motion:
        """Choose the regime in which the state goes on; releases a particle that its wall would have to pull."""
        state = self.state
        if state.wall:
            slip, stuck, vanishing = self.friction_regime(state.wall)
            motion = self.motion(state.wall, slip, stuck)
            v, base = motion.at(self.zero)
            push = [state.wall * (v[order] + base[order]) for order in (2, 3, 4)]
            held = next((x > 0 for k, x in enumerate(push) if abs(x) > self.noise(2 + k)), True)
            if held:
                self.slip, state.stuck = slip, stuck
                self.vanishing.update(vanishing)
                if abs(push[0]) <= self.noise(2):
                    self.vanishing["release"] = 1
                return motion
            state.p_rate = self.absolute()[1]
            self.releases += 1
            self.events.append((state.time, "release"))
            self.vanishing["wall+" if state.wall > 0 else "wall-"] = 2 if abs(push[0]) > self.noise(2) else 3
            state.wall = 0
        self.slip, state.stuck, vanishing = self.friction_regime(0)
        self.vanishing.update(vanishing)
        return self.motion(0, self.slip, state.stuck)

    def watches(self, motion: Motion) -> list[Watch]:
        """Return the functions whose zeros end the present regime."""
        state, slip = self.state, self.slip
        found: list[Watch] = []
        if slip:
            found.append(Watch("turn", lambda x, h: (slip * x[0][1], slip * x[0][2], slip * x[0][3])))
        if state.stuck:
            for name, sign in (("loose+", 1), ("loose-", -1)):
                found.append(Watch(name, self._loose(sign, motion.mu)))
        if state.wall:
            wall = state.wall
            found.append(
                Watch(
                    "release",
                    lambda x, h: (
                        wall * (x[0][2] + x[1][2]),
                        wall * (x[0][3] + x[1][3]),
                        wall * (x[0][4] + x[1][4]),
                    ),
                )
            )
        elif self.particle:
            v, base = motion.at(self.zero)
            u_start = v[0] + base[0]
            for name, sign in (("wall+", 1), ("wall-", -1)):
                found.append(Watch(name, self._clearance(sign, u_start, state.gap, state.p_rate)))
        return found

    def _loose(self, sign: int, mu: Real) -> Callable[[Sample, Real], Triple]:
        def triple(x: Sample, h: Real) -> Triple:
            v, base = x
            return (
                self.gamma - sign * (mu * self.r**2 * base[0] - v[0]),
                -sign * mu * self.r**2 * base[1],
                -sign * mu * self.r**2 * base[2],
            )

        return triple

    def _clearance(
        self, sign: int, u_start: Real, gap_start: Real, p_rate: Real
    ) -> Callable[[Sample, Real], Triple]:
        rest = self.delta - sign * gap_start  # exactly zero, or two delta, after an impact

        def triple(x: Sample, h: Real) -> Triple:
            v, base = x
            return (
                rest - sign * ((v[0] + base[0] - u_start) - p_rate * h),
                -sign * (v[1] + base[1] - p_rate),
                -sign * (v[2] + base[2]),
            )

        return triple

    # ---- march ----------------------------------------------------------------------------------------

    def run_cycle(self) -> None:
        """March from phase 0 to the end of one excitation period, then set the time back to 0."""
        period = 2 * self.numbers.pi / self.r
        self.peak_u = self.peak_v = self.zero
        while period - self.state.time > self.numbers.rounding * period * 100:
            self.run_segment(period - self.state.time)
        self.state.time = self.zero
        self.cycle_peaks.append((self.peak_u, self.peak_v))

    def run_segment(self, longest: Real) -> None:
        """March to the next event, at most `longest`, and carry it out."""
        motion = self.settle()
        watches = self.watches(motion)
        h, sample = self.zero, motion.at(self.zero)
        values = [self._at_start(watch, watch.triple(sample, h)) for watch in watches]
        due = [watch for watch, value in zip(watches, values, strict=True) if value[0] <= 0]
        self.vanishing = {}
        while not due and h < longest:
            next_h = min(h + self.step, longest)
            next_sample = motion.at(next_h)
            next_values = [watch.triple(next_sample, next_h) for watch in watches]
            first: Real | None = None
            for watch, old, new in zip(watches, values, next_values, strict=True):
                root = self._zero_of(watch, motion, h, old, next_h, new)
                if root is not None and (first is None or root < first):
                    first, due = root, [watch]
            if first is not None:
                next_h = first
                next_sample = motion.at(first)
            self._observe(motion, h, sample, next_h, next_sample)
            h, sample, values = next_h, next_sample, next_values
        self._arrive(h, sample)
        if due:
            self.carry_out(due[0].name)

    def _at_start(self, watch: Watch, value: Triple) -> Triple:
        """Replace by a positive trifle what is known to vanish, or is lost in rounding but grows."""
        order = self.vanishing.get(watch.name, 0)
        if order == 0 and abs(value[0]) <= self.noise(0):
            order = 1 if value[1] > 0 or (value[1] == 0 and value[2] >= 0) else 0
            if order == 0:
                return (-self.tiny, value[1], value[2])
        return tuple(self.tiny if k < order else x for k, x in enumerate(value))  # type: ignore[return-value]

    def _zero_of(
        self, watch: Watch, motion: Motion, h: Real, old: Triple, next_h: Real, new: Triple
    ) -> Real | None:
        width = next_h - h
        reach = width * (max(abs(old[1]), abs(new[1])) + 2 * width * max(abs(old[2]), abs(new[2])))
        if min(old[0], new[0]) > 2 * reach:
            return None
        noise = (self.noise(0), self.noise(1), self.noise(2))
        return first_zero(lambda x: watch.triple(motion.at(x), x), h, old, next_h, new, noise)

    def _arrive(self, h: Real, sample: Sample) -> None:
        state = self.state
        v, base = sample
        if state.stuck:
            self.stuck_time += h
        if not state.wall and self.particle:
            start_base, _ = self.base()
            state.gap += (v[0] + base[0] - state.v - start_base) - state.p_rate * h
        self.friction_loss += self.gamma * abs(v[0] - state.v)
        state.time += h
        state.v, state.v_rate = v[0], v[1]

    def carry_out(self, event: str) -> None:
        """Apply an event to the state."""
        state = self.state
        self.events.append((state.time, event))
        if event == "turn":
            self.turns += 1
            state.v_rate = self.zero
            if self.friction_regime(state.wall)[1]:
                self.sticks += 1
        elif event in ("loose+", "loose-"):
            state.stuck = False
            state.v = self._loose_position(1 if event == "loose+" else -1)
        elif event in ("wall+", "wall-"):
            self.impact(1 if event == "wall+" else -1)
        elif event == "release":
            # settle() sees the vanished force and lets go; it must not hold because of rounding.
            state.p_rate = self.absolute()[1]
            self.releases += 1
            self.vanishing["wall+" if state.wall > 0 else "wall-"] = 3
            state.wall = 0

    def _loose_position(self, sign: int) -> Real:
        """Return v moved by rounding alone, so that the friction limit is met exactly at the end of a stick."""
        force, _ = self.inertia_force(self.state.wall)
        return self.state.v + force - sign * self.gamma

    def impact(self, wall: int) -> None:
        """Rebound at a wall (equations (7), (8)); join it where the rebound is too slow to matter."""
        state, e, beta = self.state, self.e, self.beta
        _, base_rate = self.base()
        u_rate = state.v_rate + base_rate
        approach = u_rate - state.p_rate
        self.impacts += 1
        self.max_impact_speed = max(self.max_impact_speed, abs(approach))
        state.gap = wall * self.delta
        reduced = beta / (1 + beta)
        if e < 1 and e * abs(approach) < self.join_speed:
            together = (u_rate + beta * state.p_rate) / (1 + beta)
            joined = replace(state, v_rate=together - base_rate, p_rate=together, wall=wall)
            if self._pushes(joined):
                self.state = joined
                self.attachments += 1
                self.impact_loss += reduced * approach**2 / 2
                return
        u_after = u_rate - reduced * (1 + e) * approach
        state.p_rate = u_after + e * approach
        state.v_rate = u_after - base_rate
        self.impact_loss += reduced * (1 - e) * (1 + e) * approach**2 / 2
        self.vanishing["wall+" if wall > 0 else "wall-"] = 1 if e * approach != 0 else 2

    def _pushes(self, joined: State) -> bool:
        """Return whether the wall would have to push the particle of a joined state."""
        kept, self.state = self.state, joined
        try:
            slip, stuck, _ = self.friction_regime(joined.wall)
            v, base = self.motion(joined.wall, slip, stuck).at(self.zero)
            push = [joined.wall * (v[order] + base[order]) for order in (2, 3, 4)]
            return next((x > 0 for k, x in enumerate(push) if abs(x) > self.noise(2 + k)), False)
        finally:
            self.state = kept

    # ---- peaks and energy -----------------------------------------------------------------------------

    def _observe(self, motion: Motion, h: Real, sample: Sample, next_h: Real, next_sample: Sample) -> None:
        if self.peaks_wanted:
            self._observe_peaks(motion, h, sample, next_h, next_sample)
        if self.energy_wanted:
            self._observe_energy(motion, h, next_h)

    def _observe_peaks(
        self, motion: Motion, h: Real, sample: Sample, next_h: Real, next_sample: Sample
    ) -> None:
        for absolute in (True, False):

            def values(x: Sample, absolute: bool = absolute) -> list[Real]:
                return [a + b for a, b in zip(*x, strict=True)] if absolute else x[0]

            old, new = values(sample), values(next_sample)
            peak = max(abs(old[0]), abs(new[0]))
            if (old[1] > 0) != (new[1] > 0) and old[1] != 0:

                def slope(x: Real, values: Callable[[Sample], list[Real]] = values) -> tuple[Real, Real]:
                    y = values(motion.at(x))
                    return y[1], y[2]

                top = zero_between(slope, h, next_h, old[1] > 0, self.noise(1))
                peak = max(peak, abs(values(motion.at(top))[0]))
            if absolute:
                self.peak_u = max(self.peak_u, peak)
            else:
                self.peak_v = max(self.peak_v, peak)

    def _observe_energy(self, motion: Motion, h: Real, next_h: Real) -> None:
        """Add work of the base, int mu u'' s' dt, and viscous loss, int 2 zeta v'^2 dt (five-point Gauss)."""
        convert, sqrt = self.numbers.convert, self.numbers.sqrt
        middle, half = (h + next_h) / 2, (next_h - h) / 2
        root = 2 * sqrt(convert(10) / 7)
        wide = 13 * sqrt(convert(70))
        nodes = [(self.zero, convert(128) / 225)]
        for sign in (-1, 1):
            nodes.append((sign * sqrt(5 - root) / 3, (322 + wide) / 900))
            nodes.append((sign * sqrt(5 + root) / 3, (322 - wide) / 900))
        for node, weight in nodes:
            v, base = motion.at(middle + half * node)
            self.work_in += half * weight * motion.mu * (v[2] + base[2]) * base[1]
            self.viscous_loss += half * weight * 2 * self.zeta * v[1] ** 2


def simulate(
    zeta: object,
    r: object,
    gamma: object,
    particle: tuple[Any, Any, Any] | None = None,
    cycles: int = 10,
    *,
    digits: int | None = 40,
    start: State | None = None,
    peaks: bool = False,
    energy: bool = False,
) -> dict[str, Any]:
    """Simulate the hybrid damper from rest and return its state after whole excitation cycles.

    Parameters
    ----------
    zeta, r, gamma
        Damping, frequency and friction ratio. Floats are taken as the binary number that they hold.
    particle
        (clearance ratio delta, restitution e, mass ratio beta), or None.
    cycles
        Number of excitation periods 2 pi / r.
    digits
        Decimal digits of the arithmetic; None for double precision.
    start
        State at phase 0 to go on from (the result's ``end``); None for rest in the absolute frame.
    peaks
        Also return ``peaks``: the true extrema (max |u|, max |v|) of every cycle.
    energy
        Also return ``work_in, viscous, friction, impact, stored`` (over k Z^2) and ``energy_residual``.

    Returns
    -------
    dict
        ``u, u_rate, p, p_rate`` (absolute, dimensionless; p = p' = 0 without a particle), ``impacts, turns, sticks, attachments,
        releases`` (counts; a turn is v' = 0 in a scene with friction, whether the mass sticks or not),
        ``max_impact_speed``, ``stuck_time``, ``end`` (a `State`).
    """
    numbers: Numbers = DoubleNumbers() if digits is None else ExtendedNumbers(digits)
    run = Simulation(numbers, zeta, r, gamma, particle, peaks, energy)
    if start is not None:
        convert = numbers.convert
        run.state = replace(
            start,
            time=run.zero,
            v=convert(start.v),
            v_rate=convert(start.v_rate),
            gap=convert(start.gap),
            p_rate=convert(start.p_rate),
        )
    stored = run.stored_energy()
    for _ in range(cycles):
        run.run_cycle()
    u, u_rate, p, p_rate = run.absolute()
    result: dict[str, Any] = {
        "u": u,
        "u_rate": u_rate,
        "p": p,
        "p_rate": p_rate,
        "impacts": run.impacts,
        "turns": run.turns,
        "sticks": run.sticks,
        "attachments": run.attachments,
        "releases": run.releases,
        "max_impact_speed": run.max_impact_speed,
        "stuck_time": run.stuck_time,
        "end": replace(run.state),
    }
    if peaks:
        result["peaks"] = run.cycle_peaks
    if energy:
        gained = run.stored_energy() - stored
        lost = run.viscous_loss + run.friction_loss + run.impact_loss
        result |= {
            "work_in": run.work_in,
            "viscous": run.viscous_loss,
            "friction": run.friction_loss,
            "impact": run.impact_loss,
            "stored": gained,
            "energy_residual": abs(run.work_in - lost - gained) / max(abs(run.work_in), abs(gained)),
        }
    return result
