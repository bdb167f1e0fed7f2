"""General-purpose integrators with event location, as methods of the accuracy report: SciPy, SUNDIALS, heyoka."""

from collections.abc import Callable
from math import pi
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp  # type: ignore[import-untyped]
from tests.benchmarks._automaton import Mode, Model, Reached, Vector, march

from damperlab.worker.accuracy.cases import State
from damperlab.worker.accuracy.methods import Method
from damperlab.worker.point import Design

TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
STIFF_TOLERANCES = (1e-4, 1e-6)
SETTING = "1 / tolerance"
LONGEST_STEP = 0.125
"""In excitation periods. A stuck mass has no rate to control a step by, and a step over its release would be a miss."""


def longest_step(design: Design) -> float:
    """Largest step of a stepping integrator [1/ω_n]."""
    return LONGEST_STEP * 2.0 * pi / design.frequency_ratio


def scipy_method(name: str, tolerances: tuple[float, ...]) -> Method:
    """SciPy's solve_ivp with terminal events."""

    def run(design: Design, cycles: int, finesse: float) -> State | None:
        tolerance = 1.0 / finesse

        def advance(model: Model, mode: Mode, t: float, end: float, y: Vector) -> Reached:
            functions: list[Any] = [_falling(function) for function in model.events(mode)]
            found = solve_ivp(
                lambda time, state: model.rates(time, state, mode), (t, end), y, name,
                events=functions, rtol=max(tolerance, 3e-14), atol=tolerance, max_step=longest_step(design),
            )  # fmt: skip
            if found.status < 0:
                raise RuntimeError(found.message)
            hit = None
            if found.status == 1:
                hit = next(i for i, times in enumerate(found.t_events) if times.size)
            return float(found.t[-1]), tuple(found.y[:, -1].tolist()), hit  # type: ignore[return-value]

        return march(design, cycles, advance)

    return Method(f"SciPy {name}", SETTING, tuple(1.0 / one for one in tolerances), run)


def _falling(function: Callable[[float, Vector], float]) -> Callable[[float, Vector], float]:
    function.terminal, function.direction = True, -1.0  # type: ignore[attr-defined]
    return function


def cvode_method(kind: str, tolerances: tuple[float, ...]) -> Method:
    """SUNDIALS' CVODE through scikit-sundae, with its root finding."""
    from sksundae.cvode import CVODE  # type: ignore[import-not-found]

    def run(design: Design, cycles: int, finesse: float) -> State | None:
        tolerance = 1.0 / finesse

        def advance(model: Model, mode: Mode, t: float, end: float, y: Vector) -> Reached:
            functions = model.events(mode)

            def rates(time: float, state: Any, out: Any) -> None:
                out[:] = model.rates(time, tuple(state.tolist()), mode)  # type: ignore[arg-type]

            def events(time: float, state: Any, out: Any) -> None:
                now: Any = tuple(state.tolist())
                out[:] = [function(time, now) for function in functions]

            options: dict[str, Any] = {}
            if functions:
                events.terminal = [True] * len(functions)  # type: ignore[attr-defined]
                events.direction = [-1] * len(functions)  # type: ignore[attr-defined]
                options = {"eventsfn": events, "num_events": len(functions)}
            solver = CVODE(
                rates,
                method=kind,
                rtol=max(tolerance, 1e-15),
                atol=tolerance,
                max_num_steps=1_000_000,
                max_step=longest_step(design),
                **options,
            )
            found = solver.solve(np.array([t, end]), np.array(y))
            if not found.success and found.status < 0:
                raise RuntimeError(found.message)
            hit = None
            if functions and found.i_events is not None and len(found.i_events):
                hit = int(np.flatnonzero(np.asarray(found.i_events)[-1])[0])
            return float(found.t[-1]), tuple(np.asarray(found.y)[-1].tolist()), hit  # type: ignore[return-value]

        return march(design, cycles, advance)

    return Method(f"SUNDIALS CVODE {kind}", SETTING, tuple(1.0 / one for one in tolerances), run)


def heyoka_method(tolerances: tuple[float, ...]) -> Method:
    """heyoka's adaptive Taylor method; one compiled integrator a mode, with its default cool-down of events."""
    import heyoka as hy  # type: ignore[import-not-found]

    built: dict[Any, Any] = {}

    def build(design: Design, mode: Mode, tolerance: float) -> Any:
        v, w, p, q = hy.make_vars("v", "w", "p", "q")
        r, particle = design.frequency_ratio, design.particle
        shaking = r * r * hy.sin(r * hy.time)
        zero = hy.expression(0.0)
        depth = push = contact = zero
        compliant = particle is not None and particle.wall is not None
        riding = mode.wall != 0 and not compliant
        if particle is not None and particle.wall is not None and mode.wall:
            depth = mode.wall * (v + hy.sin(r * hy.time) - p) - particle.clearance_ratio
            rate = mode.wall * (w + r * hy.cos(r * hy.time) - q)
            push = particle.wall.stiffness * depth + particle.wall.damping * rate
            contact = mode.wall * push if mode.pushed else zero
        force = -2.0 * design.damping_ratio * w - v - design.friction_ratio * mode.slip - contact
        inertia = Model(design).inertia(mode) if riding else 1.0
        w_rate = zero if mode.stuck else force / inertia + shaking
        acceleration = w_rate - shaking
        q_rate = acceleration if riding else zero
        if compliant and particle is not None:
            q_rate = contact / particle.mass_ratio
        rates = [(v, zero if mode.stuck else w), (w, w_rate), (p, q), (q, q_rate)]
        hold = inertia * shaking - v - contact
        found = [mode.slip * w] if mode.slip else []
        if mode.stuck:
            found += [design.friction_ratio - hold, design.friction_ratio + hold]
        if riding:
            found.append(mode.wall * acceleration)
        elif mode.wall:
            found += [push] if mode.pushed else [depth, -push]
        elif particle is not None:
            gap = v + hy.sin(r * hy.time) - p
            found += [particle.clearance_ratio - gap, particle.clearance_ratio + gap]
        events = [hy.t_event(one, direction=hy.event_direction.negative) for one in found]
        return hy.taylor_adaptive(rates, [0.0] * 4, tol=tolerance, t_events=events)

    def run(design: Design, cycles: int, finesse: float) -> State | None:
        tolerance = 1.0 / finesse

        def advance(model: Model, mode: Mode, t: float, end: float, y: Vector) -> Reached:
            key = (design, mode, tolerance)
            if key not in built:
                built[key] = build(design, mode, tolerance)
            integrator = built[key]
            integrator.time = t
            integrator.state[:] = y
            if model.events(mode):
                integrator.reset_cooldowns()
            outcome = int(integrator.propagate_until(end)[0].value)
            state: Any = tuple(integrator.state.tolist())
            if not np.isfinite(state).all():
                raise ArithmeticError("not finite")
            if outcome == int(hy.taylor_outcome.time_limit.value):
                return float(integrator.time), state, None
            if outcome >= 0 or -outcome - 1 < len(model.events(mode)):
                return float(integrator.time), state, outcome if outcome >= 0 else -outcome - 1
            raise RuntimeError(str(outcome))

        return march(design, cycles, advance)

    return Method("heyoka Taylor", SETTING, tuple(1.0 / one for one in tolerances), run)


def peers() -> tuple[list[Method], list[str]]:
    """Methods that can be had here, and what is missing of the others, in words."""
    methods = [
        scipy_method("DOP853", TOLERANCES),
        scipy_method("LSODA", TOLERANCES),
        scipy_method("Radau", STIFF_TOLERANCES),
    ]
    missing = []
    for make, package in (
        (lambda: cvode_method("Adams", TOLERANCES), "scikit-sundae"),
        (lambda: heyoka_method((1e-8, 1e-12, 1e-15)), "heyoka"),
    ):
        try:
            methods.append(make())
        except ImportError:
            missing.append(f"{package} is not installed; the extra `bench` brings it")
    return methods, missing
