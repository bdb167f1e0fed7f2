"""The march from event to event: regimes, what ends them, and what happens then."""

from __future__ import annotations

from dataclasses import replace

from tests.reference.motion import Motion, Sample
from tests.reference.numbers import Numbers, Real
from tests.reference.observers import Observer
from tests.reference.roots import Triple, first_zero
from tests.reference.state import State
from tests.reference.watches import Watch, clearance, loose, release, turn

SAMPLES = 200  # scan steps per 2 pi / max(1, r)


class Simulation:
    """One run, from rest unless ``state`` is replaced. See `tests.reference.simulator.simulate`."""

    def __init__(
        self,
        numbers: Numbers,
        zeta: Real,
        r: Real,
        gamma: Real,
        particle: tuple[Real, Real, Real] | None,
        observers: tuple[Observer, ...] = (),
        forced: bool = False,
    ) -> None:
        convert = numbers.convert
        self.numbers = numbers
        self.zeta, self.r, self.gamma = convert(zeta), convert(r), convert(gamma)
        self.particle = particle is not None
        self.forced = forced
        self.delta, self.e, self.beta = (convert(x) for x in (particle or (1, 0, 0)))
        self.zero = convert(0)
        self.step = 2 * numbers.pi / SAMPLES / max(self.r, convert(1))
        # Chatter is cut where the rebound is this slow; the cut changes the answer by about its square.
        exponent = -numbers.digits * 3 // 8
        self.join_speed = convert(10) ** exponent * max(self.r, convert(1))
        self.tiny = numbers.rounding**3
        self.state = State(self.zero, self.zero, self.zero if forced else -self.r, self.zero, self.zero)
        # How many leading derivatives of a watched function vanish at the start of a segment.
        self.vanishing: dict[str, int] = {}
        self.slip = 0  # friction direction: sign of v', 0 while stuck or without friction
        self.impacts = self.turns = self.sticks = self.attachments = self.releases = 0
        self.stuck_time = self.zero
        self.observers = observers

    # ---- state ----------------------------------------------------------------------------------------

    def base(self) -> tuple[Real, Real]:
        """Return displacement and velocity of the base now."""
        if self.forced:
            return self.zero, self.zero
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

    def mass(self, wall: int) -> Real:
        """Return the moving mass: 1, or 1 + beta while attached."""
        return 1 + self.beta if wall else self.zero + 1

    def inertia_force(self, wall: int) -> tuple[Real, Real]:
        """Return the push less v and its rate at v' = 0: friction must balance it in stick."""
        cos_base, sin_base = self.numbers.cos_sin(self.r * self.state.time)
        scale = self.zero + 1 if self.forced else self.mass(wall) * self.r**2
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
            self.forced,
        )

    def noise(self, order: int) -> Real:
        """Return what counts as zero for a displacement and its derivatives."""
        scale = 1 + abs(self.state.v) + abs(self.gamma)
        return self.numbers.rounding * scale * max(self.r, self.zero + 1) ** order

    def settle(self) -> Motion:
        """Choose the regime in which to go on; let go of a particle that its wall would have to pull."""
        state = self.state
        if state.wall:
            slip, stuck, vanishing = self.friction_regime(state.wall)
            motion = self.motion(state.wall, slip, stuck)
            v, base, _ = motion.at(self.zero)
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
            self.vanishing["wall+" if state.wall > 0 else "wall-"] = 2 if abs(push[0]) > self.noise(2) else 3
            state.wall = 0
        self.slip, state.stuck, vanishing = self.friction_regime(0)
        self.vanishing.update(vanishing)
        return self.motion(0, self.slip, state.stuck)

    def watches(self, motion: Motion) -> list[Watch]:
        """Return the functions whose zeros end the present regime."""
        state = self.state
        found: list[Watch] = []
        if self.slip:
            found.append(turn(self.slip))
        if state.stuck:
            found += [loose(sign, self.gamma) for sign in (1, -1)]
        if state.wall:
            found.append(release(state.wall))
        elif self.particle:
            v, base, _ = motion.at(self.zero)
            flight = (state.gap, v[0] + base[0], state.p_rate)
            found += [clearance(sign, self.delta, *flight) for sign in (1, -1)]
        return found

    # ---- march ----------------------------------------------------------------------------------------

    def run_cycle(self) -> None:
        """March from phase 0 to the end of one excitation period, then set the time back to 0."""
        period = 2 * self.numbers.pi / self.r
        while period - self.state.time > self.numbers.rounding * period * 100:
            self.run_segment(period - self.state.time)
        self.state.time = self.zero
        for observer in self.observers:
            observer.end_cycle()

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
            for observer in self.observers:
                observer.observe(motion, (h, sample), (next_h, next_sample))
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
        v, base, _ = sample
        if state.stuck:
            self.stuck_time += h
        if not state.wall and self.particle:
            start_base, _ = self.base()
            state.gap += (v[0] + base[0] - state.v - start_base) - state.p_rate * h
        state.time += h
        state.v, state.v_rate = v[0], v[1]

    def carry_out(self, event: str) -> None:
        """Apply an event to the state."""
        state = self.state
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
            # Let go here: left to settle(), rounding of the vanished force could hold the particle.
            state.p_rate = self.absolute()[1]
            self.releases += 1
            self.vanishing["wall+" if state.wall > 0 else "wall-"] = 3
            state.wall = 0

    def _loose_position(self, sign: int) -> Real:
        """Return v, moved by rounding alone so that a stick ends exactly at the friction limit."""
        force, _ = self.inertia_force(self.state.wall)
        return self.state.v + force - sign * self.gamma

    def impact(self, wall: int) -> None:
        """Rebound at a wall (equations (7), (8)); join it where the rebound is too slow to matter."""
        state, e, beta = self.state, self.e, self.beta
        _, base_rate = self.base()
        u_rate = state.v_rate + base_rate
        approach = u_rate - state.p_rate
        self.impacts += 1
        state.gap = wall * self.delta
        reduced = beta / (1 + beta)
        if e < 1 and e * abs(approach) < self.join_speed:
            together = (u_rate + beta * state.p_rate) / (1 + beta)
            joined = replace(state, v_rate=together - base_rate, p_rate=together, wall=wall)
            if self._pushes(joined):
                self.state = joined
                self.attachments += 1
                return
        u_after = u_rate - reduced * (1 + e) * approach
        state.p_rate = u_after + e * approach
        state.v_rate = u_after - base_rate
        self.vanishing["wall+" if wall > 0 else "wall-"] = 1 if e * approach != 0 else 2

    def _pushes(self, joined: State) -> bool:
        """Return whether the wall would have to push the particle of a joined state."""
        kept, self.state = self.state, joined
        try:
            slip, stuck, _ = self.friction_regime(joined.wall)
            v, base, _ = self.motion(joined.wall, slip, stuck).at(self.zero)
            push = [joined.wall * (v[order] + base[order]) for order in (2, 3, 4)]
            return next((x > 0 for k, x in enumerate(push) if abs(x) > self.noise(2 + k)), False)
        finally:
            self.state = kept
