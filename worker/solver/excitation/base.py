"""Where the base is and what it does next: shaken as a sine, or as a record that is linear from sample to sample.

The march asks the functions here alone. Each has a form for either kind of base, and the compiler sees only the one for
the kind that it is given, so that a kernel of a sine holds nothing of records.
"""

from typing import Any, NamedTuple

from numba import types
from numpy.typing import NDArray

from damperlab.worker.jit import by_type, inlined
from damperlab.worker.solver.memory import address
from damperlab.worker.solver.motion.propagator import Base, point_base
from damperlab.worker.solver.motion.taylor import TERMS, slope, value
from damperlab.worker.solver.state import State


class RecordBase(NamedTuple):
    """A base whose acceleration is linear in every window.

    Attributes
    ----------
    two_zeta, window : float
        2ζ and the length of a window [1/ω_n].
    windows : int
        Windows of the whole record.
    acceleration, jerk : array, shape (windows,)
        s'' at the start of each window, and its constant rate.
    rate, position : array, shape (windows + 1,)
        s' and s at the window ends.
    most : array, shape (windows,)
        Largest |s''| of each window.
    largest : float
        Largest |s''| of the record.
    rows : array, shape (2 · TERMS,)
        Taylor coefficients of s, less its start and its tangent, for s'' = 1 and for s''' = 1.
    """

    two_zeta: float
    window: float
    windows: int
    acceleration: NDArray[Any]
    jerk: NDArray[Any]
    rate: NDArray[Any]
    position: NDArray[Any]
    most: NDArray[Any]
    largest: float
    rows: NDArray[Any]


class Phase(NamedTuple):
    """The base at one instant.

    Attributes
    ----------
    first, second : float
        What its rows are multiplied by: sin φ and cos φ, or s'' and s'''.
    position, rate : float
        s and s'.
    push : float
        −s'', the force of inertia on a unit mass that moves with the base.
    most : float
        Bound on |s''| until the end of the window.
    """

    first: float
    second: float
    position: float
    rate: float
    push: float
    most: float


@inlined
def phase_of_sine(sine, cosine, r):
    """Phase of a base s = sin φ whose sine and cosine are given."""
    return Phase(sine, cosine, sine, r * cosine, r * r * sine, r * r)


@inlined
def _sine_at(base, k):
    return phase_of_sine(base.sine[k], base.cosine[k], base.frequency_ratio)


@inlined
def _record_at(base, k):
    acceleration = base.acceleration[k]
    return Phase(acceleration, base.jerk[k], base.position[k], base.rate[k], -acceleration, base.most[k])


@inlined
def _record_until(base, k):
    acceleration = base.acceleration[k] + base.jerk[k] * base.window
    return Phase(
        acceleration, base.jerk[k], base.position[k + 1], base.rate[k + 1], -acceleration, base.most[k]
    )


@inlined
def _sine_until(base, k):
    return phase_of_sine(base.sine[k + 1], base.cosine[k + 1], base.frequency_ratio)


@inlined
def _sine_after(base, phase, shaken, t):
    r = base.frequency_ratio
    return phase_of_sine(value(shaken, t), slope(shaken, t) / r, r)


@inlined
def _record_after(base, phase, shaken, t):
    acceleration = phase.first + phase.second * t
    return Phase(acceleration, phase.second, value(shaken, t), slope(shaken, t), -acceleration, phase.most)


@inlined
def _expand_sine(base, phase, out):
    for n in range(TERMS):
        out[n] = phase.first * base.rows[n] + phase.second * base.rows[TERMS + n]


@inlined
def _expand_record(base, phase, out):
    for n in range(TERMS):
        out[n] = phase.first * base.rows[n] + phase.second * base.rows[TERMS + n]
    out[0] = phase.position
    out[1] = phase.rate


@inlined
def _carry_nothing(base, phase, out):
    return


@inlined
def _carry_record(base, phase, out):
    out[0] += phase.position
    out[1] += phase.rate


@inlined
def _sine_travel(base, phase, end):
    return end.position - phase.position


@inlined
def _record_travel(base, phase, end):
    t = base.window  # not the difference of positions, which may be far from where they started
    return (phase.rate + (phase.first / 2.0 + phase.second * t / 6.0) * t) * t


@inlined
def _push_sine(base, phase, factor, out):
    r = base.frequency_ratio
    scale = factor * (r * r)
    for n in range(TERMS):
        out[n] = scale * (phase.first * base.rows[n] + phase.second * base.rows[TERMS + n])


@inlined
def _push_record(base, phase, factor, out):
    for n in range(TERMS):
        out[n] = 0.0
    out[0] = -factor * phase.first
    out[1] = -factor * phase.second


@inlined
def _sine_bend(base, phase, order):
    r = base.frequency_ratio
    if order == 2:
        return r * r
    if order == 3:
        return r * r * r
    if order == 4:
        return r * r * r * r
    return r * r * r * r * r


@inlined
def _record_bend(base, phase, order):
    if order == 2:
        return phase.most
    if order == 3:
        return abs(phase.second)
    return 0.0


@inlined
def _mirror(state):
    return State(
        -state.v,
        -state.w,
        -state.slip,
        -state.wall,
        state.gap,
        -state.p_rate,
        state.riding,
        state.slip_order,
        state.gap_order,
        state.dwell,
    )


@inlined
def _sine_scale(base):
    return base.frequency_ratio * base.frequency_ratio


@inlined
def _record_scale(base):
    return base.largest


@inlined
def _point_record(base):
    return RecordBase(
        base.two_zeta,
        base.window,
        base.windows,
        address(base.acceleration, 0),
        address(base.jerk, 0),
        address(base.rate, 0),
        address(base.position, 0),
        address(base.most, 0),
        base.largest,
        address(base.rows, 0),
    )


def is_record(base: Any) -> bool:
    """Whether a base is a record, asked of the base itself or of its type in the compiler."""
    if isinstance(base, types.BaseNamedTuple):
        return base.instance_class is RecordBase
    return isinstance(base, RecordBase)


def phase_at(base: Any, k: int) -> Any:
    """Phase at the start of window k."""
    return _record_at(base, k) if is_record(base) else _sine_at(base, k)


@by_type(phase_at)
def _phase_at(base, k):
    if is_record(base):
        return lambda base, k: _record_at(base, k)
    return lambda base, k: _sine_at(base, k)


def phase_until(base: Any, k: int) -> Any:
    """Phase at the end of window k, as window k sees it: a record may jump there."""
    return _record_until(base, k) if is_record(base) else _sine_until(base, k)


@by_type(phase_until)
def _phase_until(base, k):
    if is_record(base):
        return lambda base, k: _record_until(base, k)
    return lambda base, k: _sine_until(base, k)


def phase_after(base: Any, phase: Phase, shaken: Any, t: float) -> Any:
    """Phase a time t later in the same window, from the polynomial of `expand_base`."""
    return _record_after(base, phase, shaken, t) if is_record(base) else _sine_after(base, phase, shaken, t)


@by_type(phase_after)
def _phase_after(base, phase, shaken, t):
    if is_record(base):
        return lambda base, phase, shaken, t: _record_after(base, phase, shaken, t)
    return lambda base, phase, shaken, t: _sine_after(base, phase, shaken, t)


def expand_base(base: Any, phase: Phase, out: Any) -> None:
    """Coefficients of the base displacement s from a phase on."""
    if is_record(base):
        _expand_record(base, phase, out)
    else:
        _expand_sine(base, phase, out)


@by_type(expand_base)
def _expand_base(base, phase, out):
    if is_record(base):
        return lambda base, phase, out: _expand_record(base, phase, out)
    return lambda base, phase, out: _expand_sine(base, phase, out)


def travel(base: Any, phase: Phase, end: Phase) -> float:
    """Way of the base through a whole window."""
    return float(_record_travel(base, phase, end) if is_record(base) else _sine_travel(base, phase, end))


@by_type(travel)
def _travel(base, phase, end):
    if is_record(base):
        return lambda base, phase, end: _record_travel(base, phase, end)
    return lambda base, phase, end: _sine_travel(base, phase, end)


def carry(base: Any, phase: Phase, out: Any) -> None:
    """Add to coefficients of u what the rows of a record lack: start and tangent of the base."""
    if is_record(base):
        _carry_record(base, phase, out)


@by_type(carry)
def _carry(base, phase, out):
    if is_record(base):
        return lambda base, phase, out: _carry_record(base, phase, out)
    return lambda base, phase, out: _carry_nothing(base, phase, out)


def push_into(base: Any, phase: Phase, factor: float, out: Any) -> None:
    """Coefficients of `factor` times the push −s''."""
    if is_record(base):
        _push_record(base, phase, factor, out)
    else:
        _push_sine(base, phase, factor, out)


@by_type(push_into)
def _push_into(base, phase, factor, out):
    if is_record(base):
        return lambda base, phase, factor, out: _push_record(base, phase, factor, out)
    return lambda base, phase, factor, out: _push_sine(base, phase, factor, out)


def base_bend(base: Any, phase: Phase, order: int) -> float:
    """Bound on the derivative of s of an order from 2 to 5 until the end of the window."""
    return float(_record_bend(base, phase, order) if is_record(base) else _sine_bend(base, phase, order))


@by_type(base_bend)
def _base_bend(base, phase, order):
    if is_record(base):
        return lambda base, phase, order: _record_bend(base, phase, order)
    return lambda base, phase, order: _sine_bend(base, phase, order)


def acceleration_scale(base: Any) -> float:
    """Largest |s''| of the whole motion: what rounding of the forces is measured by."""
    return float(_record_scale(base) if is_record(base) else _sine_scale(base))


@by_type(acceleration_scale)
def _acceleration_scale(base):
    if is_record(base):
        return lambda base: _record_scale(base)
    return lambda base: _sine_scale(base)


def point_at(base: Base | RecordBase) -> Any:
    """The same base with addresses for arrays; the arrays must outlive it."""
    return _point_record(base) if is_record(base) else point_base(base)


@by_type(point_at)
def _point_at(base):
    if is_record(base):
        return lambda base: _point_record(base)
    return lambda base: point_base(base)


def mirrored(base: Any, state: State) -> State:
    """Return the state that a march hands on: after half a cycle all signs flip, so that the phase is 0 again."""
    return state if is_record(base) else State(*_mirror(state))


@by_type(mirrored)
def _mirrored(base, state):
    if is_record(base):
        return lambda base, state: state
    return lambda base, state: _mirror(state)
