"""Taylor polynomials of a segment without compliant contact, and the motion of the mass from the polynomials."""

from damperlab.worker.jit import inlined
from damperlab.worker.solver.addresses import Floats
from damperlab.worker.solver.excitation.excitation import Phase, add_start_of_base, expand_base
from damperlab.worker.solver.linear_motion import LinearMotion
from damperlab.worker.solver.motion.taylor import TERMS, change, combine, slope, stick
from damperlab.worker.solver.observe.meter import Meter
from damperlab.worker.solver.regime import Regime
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.state import State


@inlined
def expand_motion(
    state: State,
    phase: Phase,
    regime: Regime,
    scene: Scene,
    meter: Meter | None,
    relative: Floats,
    absolute: Floats,
) -> None:
    """Write the Taylor coefficients of x and, if a particle or a meter needs them, of x + s."""
    base = scene.base
    if regime.sticks:
        expand_base(base, phase, absolute)
        stick(state.v, relative, absolute)
    else:
        x = state.v + regime.offset
        if scene.particle is None and meter is None:
            combine(x, state.w, phase.first, phase.second, regime.motion.relative_rows, relative)
        else:
            _combine_both(x, state.w, phase, regime.motion, relative, absolute)
            add_start_of_base(base, phase, absolute)


@inlined
def _combine_both(
    x: float, w: float, phase: Phase, motion: LinearMotion, relative: Floats, absolute: Floats
) -> None:
    """Write the coefficients of x and of x + s, which share the rows for the initial x and w."""
    rows, absolute_rows, first, second = motion.relative_rows, motion.absolute_rows, phase.first, phase.second
    for n in range(TERMS):
        free = x * rows[n] + w * rows[TERMS + n]
        relative[n] = free + (first * rows[2 * TERMS + n] + second * rows[3 * TERMS + n])
        absolute[n] = free + (first * absolute_rows[2 * TERMS + n] + second * absolute_rows[3 * TERMS + n])


@inlined
def mass_at(state: State, t: float, sticks: bool, relative: Floats) -> tuple[float, float]:
    """Displacement v and velocity w of the mass at time t after `state`, from the polynomial of x."""
    if sticks:
        return state.v, 0.0
    return state.v + change(relative, t), slope(relative, t)
