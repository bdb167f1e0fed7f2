"""Integrates the contact model `dwell` with the Taylor steps of `compliant_wall`, and imports nothing from the project.

Sustained contact is not supported: the integration then raises an error.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from tests.oracles import compliant_wall


@dataclass(frozen=True)
class Scene:
    """Ratios of a design point, and the contact time of the particle.

    The friction ratio may be 0. The excitation is a motion of the base or, if `forced`, a force on the structure.
    """

    damping_ratio: float
    frequency_ratio: float
    friction_ratio: float
    clearance_ratio: float
    restitution: float
    mass_ratio: float
    contact_time: float
    forced: bool = False


class Dwelling(compliant_wall.Accelerated):
    """An integration in which the particle flies, or moves with the mass at a wall (`side`) until a time."""

    def __init__(self, scene: Scene) -> None:
        ratios = scene.damping_ratio, scene.frequency_ratio, scene.friction_ratio, scene.clearance_ratio
        super().__init__(compliant_wall.Scene(*ratios, scene.mass_ratio, 1.0, 0.0, scene.forced))
        self.contact_step = self.free_step
        self.restitution, self.contact_time = scene.restitution, scene.contact_time
        self.speed = self.until = 0.0

    def _expand(self) -> tuple[list[Any], list[Any], list[Any], list[Any]]:
        """Return the Taylor coefficients of u, p, the base displacement and the force that moves the particle."""
        if not self.side:
            return super()._expand()
        base, pull_on, u, force = self._base(), self._force(), [self.u, self.u_rate], []
        for n in range(self.numbers.terms - 2):
            below = (n + 1) * (n + 2)
            pull = pull_on[n] - 2 * self.zeta * (n + 1) * (u[n + 1] - base[n + 1]) - (u[n] - base[n])
            pull -= self.slip * self.gamma if n == 0 else 0
            u.append(base[n + 2] if self.held else pull / ((1 + self.beta) * below))
            force.append(self.side * self.beta * below * u[n + 2])
        return u, [u[0] - self.side * self.d, *u[1:]], base, force

    def _judge(self, force: Any) -> None:
        """Decide whether a mass at rest on the base sticks: it would carry the particle with it."""
        super()._judge(self.side * self.beta * 2 * self._base()[2] if self.side else force)

    def _watches(self, *motion: list[Any]) -> dict[str, Callable[[Any], Any]]:
        found = super()._watches(*motion)
        return {name: found[name] for name in found.keys() & {"onset", "turn"}} if self.side else found

    def step_to(self, end: Any) -> None:
        """Take one step up to `end`, to the end of a contact or to the first event, and apply the event."""
        joined, impacts = self.side != 0, self.impacts
        super().step_to(min(end, self.until) if joined else end)
        if self.impacts > impacts:
            self.speed = self.side * (self.u_rate - self.p_rate)
            together = (self.u_rate + self.beta * self.p_rate) / (1 + self.beta)
            self.u_rate, self.p_rate, self.p = together, together, self.u - self.side * self.d
            self.until = self.t + self.contact_time
        elif joined and self.t >= self.until:
            apart = self.side * self.restitution * self.speed / (1 + self.beta)
            if apart == 0.0:
                raise ValueError("the particle would have to ride on")
            self.u_rate, self.p_rate = self.u_rate - self.beta * apart, self.p_rate + apart
            self.side, self.pushed = 0, False
        else:
            return
        if self.gamma:
            self.held, self.slip = False, 1 if self.u_rate > self._base()[1] else -1


def end_state(
    scene: Scene, cycles: int, start: Sequence[float] = (0.0, 0.0, 0.0, 0.0)
) -> tuple[list[float], Dwelling]:
    """Return u, u', p, p' after whole cycles, and the integration.

    The initial state is rest by default. In any other initial state, the particle must touch no wall.
    """
    march = Dwelling(scene)
    march.begin(start)
    march.run(cycles)
    return [march.u, march.u_rate, march.p, march.p_rate], march
