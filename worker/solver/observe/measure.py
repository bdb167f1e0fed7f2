"""Accumulation of observables on a segment."""

from damperlab.worker.jit import inlined
from damperlab.worker.solver.excitation.record_base import RecordBase
from damperlab.worker.solver.observe.measure_record import measure_segment
from damperlab.worker.solver.observe.measure_sine import (
    find_peaks,
    measure_part,
    measure_window,
    peaks_at_ends,
)
from damperlab.worker.solver.observe.measure_sine_acceleration import measure_acceleration
from damperlab.worker.solver.observe.meter import Meter
from damperlab.worker.solver.regime import Segment
from damperlab.worker.solver.scene import Curves, Scene


@inlined
def measured_at_ends(meter: Meter | None, segment: Segment, scene: Scene) -> bool:
    """Measure a panel without events from its end states, if possible; return whether the measurement is complete."""
    if meter is None:
        return True
    if isinstance(scene.base, RecordBase):
        return False
    if meter.acceleration is not None:  # u'' is computed from polynomials
        return False
    if peaks_at_ends(meter, segment, scene):
        measure_window(meter, segment, scene)
        return True
    return False


@inlined
def measure(meter: Meter | None, segment: Segment, whole: bool, scene: Scene, curves: Curves) -> None:
    """Measure one segment from its polynomials; `whole` is True for a complete panel without events."""
    if meter is not None:
        if isinstance(scene.base, RecordBase):
            measure_segment(meter, segment, scene, curves)
        else:
            if whole:
                measure_window(meter, segment, scene)
            else:
                measure_part(meter, segment, scene, curves)
            if not peaks_at_ends(meter, segment, scene):
                find_peaks(meter, segment, scene, curves)
            if meter.acceleration is not None:
                measure_acceleration(meter, segment, scene, curves)
