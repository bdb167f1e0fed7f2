"""What a meter reads on the way, by the kind of base: a record's response is asked for more than a sine's."""

from typing import Any

from numba import types

from damperlab.worker.jit import by_type, inlined, kernel
from damperlab.worker.solver.detection.bounds import u_bend, w_bend
from damperlab.worker.solver.excitation.base import base_bend, expand_base, is_record
from damperlab.worker.solver.motion.extrema import raised
from damperlab.worker.solver.motion.propagator import GAUSS, GAUSS_NODES, GAUSS_WEIGHTS
from damperlab.worker.solver.motion.taylor import ORDER, rate_into, slope, value
from damperlab.worker.solver.observe.harmonic import (
    Curves,
    Segment,
    find_peaks,
    measure_part,
    measure_window,
    peaks_at_ends,
)
from damperlab.worker.solver.state import (
    FRICTION_LOSS,
    METERS,
    PEAK,
    RELATIVE_PEAK,
    SQUARE,
    STUCK,
    VISCOUS_LOSS,
    WORK_IN,
    Meter,
)

# What the meter of a record has besides.
RELATIVE_SQUARE = METERS  # ∫ v² dτ
ACCELERATION_SQUARE = METERS + 1  # ∫ u''² dτ
ACCELERATION_PEAK = METERS + 2  # largest |u''|
RECORD_METERS = METERS + 3


def energies_of(meter: Meter | None) -> bool | None:
    """Whether integrals are asked for: True, or None."""
    return None if meter is None else meter.energies


@by_type(energies_of)
def _energies_of(meter):
    if isinstance(meter, types.NoneType):
        return lambda meter: None
    return lambda meter: meter.energies


@inlined
def _sine_quiet(meter, segment, base, medium, friction):
    """Whether a quiet window could be measured without its polynomials."""
    if peaks_at_ends(meter.sums, segment, friction, base.frequency_ratio):
        measure_window(meter.sums, meter.energies, segment, base, medium, friction)
        return True
    return False


@inlined
def _sine_segment(meter, segment, whole, base, medium, friction, curves):
    if whole:
        measure_window(meter.sums, meter.energies, segment, base, medium, friction)
    else:
        measure_part(meter.sums, meter.energies, segment, base, medium, friction, curves)
    if not peaks_at_ends(meter.sums, segment, friction, base.frequency_ratio):
        find_peaks(meter.sums, segment, base, medium, friction, curves)


@kernel
def _record_segment(meter, segment, whole, base, medium, friction, curves):
    """Energies, squares and true peaks of one segment, from its polynomials."""
    state, crossed, phase, held, offset, t = (
        segment.start,
        segment.end,
        segment.phase,
        segment.held,
        segment.offset,
        segment.span,
    )
    w_most, u2_most = segment.w_most, segment.u2_most
    relative, absolute, shaken, scratch = curves.relative, curves.absolute, curves.shaken, curves.scratch
    sums = meter.sums
    expand_base(base, phase, shaken)
    work = 0.0
    loss = 0.0
    square = 0.0
    relative_square = 0.0
    acceleration_square = 0.0
    for i in range(GAUSS):
        at = GAUSS_NODES[i] * t
        x = relative[0]
        w = 0.0
        acceleration = phase.first + phase.second * at
        if not held:
            x = value(relative, at)
            w = slope(relative, at)
            acceleration = -medium.compliance * (base.two_zeta * w + x)
        v = x - offset
        u = v + value(shaken, at)
        work += GAUSS_WEIGHTS[i] * acceleration * slope(shaken, at)
        loss += GAUSS_WEIGHTS[i] * w * w
        square += GAUSS_WEIGHTS[i] * u * u
        relative_square += GAUSS_WEIGHTS[i] * v * v
        acceleration_square += GAUSS_WEIGHTS[i] * acceleration * acceleration
    sums[WORK_IN] += t * work / medium.compliance  # the base moves the riding particle too
    sums[VISCOUS_LOSS] += t * base.two_zeta * loss
    sums[SQUARE] += t * square
    sums[RELATIVE_SQUARE] += t * relative_square
    sums[ACCELERATION_SQUARE] += t * acceleration_square
    if friction is not None:
        if held:
            sums[STUCK] += t
        else:
            sums[FRICTION_LOSS] += friction * abs(crossed.v - state.v)  # w keeps its sign on a segment
    bulge = 0.125 * t * t
    ends = max(abs(state.v + phase.position), abs(crossed.v + value(shaken, t)))
    peak = max(sums[PEAK], ends)
    if ends + bulge * u2_most > peak and abs(absolute[1]) <= t * u2_most:
        rate_into(absolute, 0, scratch)
        most = u_bend(3, held, w_most, u2_most, base, phase, medium.compliance)
        peak = raised(peak, absolute, offset, scratch, t, most)
    sums[PEAK] = peak
    ends = max(abs(state.v), abs(crossed.v))
    peak = max(sums[RELATIVE_PEAK], ends)
    if friction is None:  # with friction, |v| peaks only where a segment ends
        w1 = u2_most + base_bend(base, phase, 2)
        if ends + bulge * w1 > peak and abs(relative[1]) <= t * w1:
            rate_into(relative, 0, scratch)
            most = w_bend(0, w_most, u2_most, base, phase, medium.compliance)
            peak = raised(peak, relative, 0.0, scratch, t, most)
    sums[RELATIVE_PEAK] = peak
    first = phase.first
    last = phase.first + phase.second * t
    if not held:
        first = -medium.compliance * (base.two_zeta * state.w + relative[0])
        last = -medium.compliance * (base.two_zeta * crossed.w + value(relative, t))
    ends = max(abs(first), abs(last))
    peak = max(sums[ACCELERATION_PEAK], ends)
    if not held:
        most = u_bend(4, held, w_most, u2_most, base, phase, medium.compliance)
        if ends + bulge * most > peak:
            # −κ(2ζ w + x) as a polynomial of the relative motion, which is zero where the base would dominate
            for n in range(ORDER):
                shaken[n] = -medium.compliance * (base.two_zeta * (n + 1) * relative[n + 1] + relative[n])
            shaken[ORDER] = 0.0
            rate_into(shaken, 0, scratch)
            most = u_bend(5, held, w_most, u2_most, base, phase, medium.compliance)
            peak = raised(peak, shaken, 0.0, scratch, t, most)
    sums[ACCELERATION_PEAK] = peak


def measure_quiet(meter: Any, segment: Segment, base: Any, medium: Any, friction: float | None) -> bool:
    """Measure a whole quiet window if that can be done without its polynomials; whether it was done."""
    return not is_record(base) and bool(_sine_quiet(meter, segment, base, medium, friction))


@by_type(measure_quiet)
def _measure_quiet(meter, segment, base, medium, friction):
    if is_record(base):
        return lambda meter, segment, base, medium, friction: False
    return lambda meter, segment, base, medium, friction: _sine_quiet(meter, segment, base, medium, friction)


def measure(
    meter: Any, segment: Segment, whole: bool, base: Any, medium: Any, friction: float | None, curves: Curves
) -> None:
    """Measure one segment, `whole` where it is a whole window; its polynomials are given."""
    chosen = _record_segment if is_record(base) else _sine_segment
    chosen(meter, segment, whole, base, medium, friction, curves)


@by_type(measure)
def _measure(meter, segment, whole, base, medium, friction, curves):
    if is_record(base):

        def segment_of_record(meter, segment, whole, base, medium, friction, curves):
            _record_segment(meter, segment, whole, base, medium, friction, curves)

        return segment_of_record

    def segment_of_sine(meter, segment, whole, base, medium, friction, curves):
        _sine_segment(meter, segment, whole, base, medium, friction, curves)

    return segment_of_sine
