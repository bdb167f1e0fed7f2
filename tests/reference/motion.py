"""Closed-form motion of the primary mass between two events."""

from __future__ import annotations

from tests.reference.numbers import Numbers, Real

Sample = tuple[list[Real], list[Real], list[Real]]  # v, the base s and the push, each with four derivatives


class Motion:
    """Solution of mu v'' + 2 zeta v' + v + load = P sin(r t) from a state at t = start_time.

    The push P sin(r t) is the inertia of what moves with a shaken base, P = mu r^2, or a force, P = 1, with the base at rest.

    v is the displacement relative to the base s = sin(r t); mu is 1, or 1 + beta while the particle
    rides on a wall; load is the friction force (constant while slipping). The solution is
    particular + homogeneous, v = A sin rt + B cos rt - load + exp(-a h)(P cos wh + Q sin wh), with
    h = t - start_time. At undamped resonance (zeta = 0, mu r^2 = 1, so P = 1) the particular part is -(r/2) t cos rt.

    A motion with ``stuck=True`` is v = constant: the mass moves with the base.
    """

    ORDERS = 5  # v and four derivatives: what event location needs

    def __init__(
        self,
        numbers: Numbers,
        zeta: Real,
        r: Real,
        mu: Real,
        load: Real,
        start_time: Real,
        start: tuple[Real, Real],
        stuck: bool = False,
        forced: bool = False,
    ) -> None:
        self._numbers = numbers
        self._r = r
        self._start_time = start_time
        self._stuck = stuck
        self._load = load
        self.mu = mu
        self.forced = forced
        self._push = 1 + 0 * r if forced else mu * r * r
        v, v_rate = start
        self._v = v
        if stuck:
            return
        stiffness = 1 - mu * r * r
        drag = 2 * zeta * r
        determinant = stiffness * stiffness + drag * drag
        # Below this the two parts of the closed form would cancel to nothing; the secular form is then
        # as exact: it differs by (1 - mu r^2) t^2.
        self._secular = determinant < numbers.rounding**2
        if self._secular:
            self._steady = self._secular_orders(r)
        else:
            a = self._push * stiffness / determinant
            b = -self._push * drag / determinant
            self._steady = []
            for _ in range(self.ORDERS):
                self._steady.append((a, 0, b, 0))
                a, b = -r * b, r * a
        decay = zeta / mu
        omega = numbers.sqrt(1 / mu - decay * decay)
        self._decay, self._omega = decay, omega
        cos_base, sin_base = numbers.cos_sin(r * start_time)
        p = v - self._steady_value(0, start_time, sin_base, cos_base) + load
        q = (v_rate - self._steady_value(1, start_time, sin_base, cos_base) + decay * p) / omega
        self._free = []
        for _ in range(self.ORDERS):
            self._free.append((p, q))
            p, q = -decay * p + omega * q, -omega * p - decay * q

    def _secular_orders(self, r: Real) -> list[tuple[Real, Real, Real, Real]]:
        """Return (a0, a1, b0, b1) of (a0 + a1 t) sin rt + (b0 + b1 t) cos rt for v and its derivatives."""
        a0, a1, b0, b1 = 0 * r, 0 * r, 0 * r, -r / 2
        orders = []
        for _ in range(self.ORDERS):
            orders.append((a0, a1, b0, b1))
            a0, a1, b0, b1 = a1 - r * b0, -r * b1, b1 + r * a0, r * a1
        return orders

    def _steady_value(self, order: int, time: Real, sin_base: Real, cos_base: Real) -> Real:
        a0, a1, b0, b1 = self._steady[order]
        if self._secular:
            return (a0 + a1 * time) * sin_base + (b0 + b1 * time) * cos_base
        return a0 * sin_base + b0 * cos_base

    def at(self, h: Real) -> Sample:
        """Return v, the base s and the push, each with four derivatives, at h after the start of the motion."""
        time = self._start_time + h
        r = self._r
        cos_base, sin_base = self._numbers.cos_sin(r * time)
        base = [sin_base, r * cos_base]
        for order in range(2, self.ORDERS):
            base.append(-r * r * base[order - 2])
        push = [self._push * x for x in base]
        if self.forced:
            base = [0 * x for x in base]
        if self._stuck:
            return [self._v] + [0 * self._v] * (self.ORDERS - 1), base, push
        shrink = self._numbers.exp(-self._decay * h)
        cos_free, sin_free = self._numbers.cos_sin(self._omega * h)
        cos_free, sin_free = shrink * cos_free, shrink * sin_free
        v = [
            self._steady_value(order, time, sin_base, cos_base) + p * cos_free + q * sin_free
            for order, (p, q) in enumerate(self._free)
        ]
        v[0] -= self._load
        return v, base, push
