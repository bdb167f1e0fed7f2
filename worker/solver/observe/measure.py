"""Accumulation of observables on a segment without compliant contact."""

from damperlab.worker.jit import inlined
from damperlab.worker.solver.excitation.excitation import expand_base
from damperlab.worker.solver.excitation.record_base import RecordBase
from damperlab.worker.solver.observe.acceleration import measure_acceleration
from damperlab.worker.solver.observe.energies import measure_energies
from damperlab.worker.solver.observe.measure_rubbing import measure_rubbing
from damperlab.worker.solver.observe.measure_sine import (
    find_peaks,
    measure_part,
    measure_window,
    peaks_at_ends,
)
from damperlab.worker.solver.observe.meter import Meter
from damperlab.worker.solver.observe.peaks import raise_peaks
from damperlab.worker.solver.regime import Segment
from damperlab.worker.solver.scene import Curves, Scene


@inlined
def measured_at_ends(meter: Meter | None, segment: Segment, scene: Scene) -> bool:
    """Measure a panel without events from its end states alone; return False if polynomials are needed."""
    if meter is None:
        return True
    if isinstance(scene.base, RecordBase):
        return False
    if meter.acceleration is not None:  # u'' is computed from polynomials
        return False
    if peaks_at_ends(meter, segment, scene):
        measure_rubbing(meter, segment, scene)
        measure_window(meter, segment, scene)
        return True
    return False


@inlined
def measure(meter: Meter | None, segment: Segment, whole: bool, scene: Scene, curves: Curves) -> None:
    """Measure one segment from its polynomials; `whole` is True for a complete panel without events.

    The coefficients of the excitation are overwritten.
    """
    if meter is not None:
        measure_rubbing(meter, segment, scene)
        if isinstance(scene.base, RecordBase):
            regime, t = segment.regime, segment.time
            expand_base(scene.base, segment.phase, curves.excitation)
            moved = segment.end.v - segment.start.v
            measure_energies(meter, moved, t, 1.0 / regime.motion.compliance, None, regime, scene, curves)
            raise_peaks(meter, t, regime.offset, scene, curves)
        else:
            if whole:
                measure_window(meter, segment, scene)
            else:
                measure_part(meter, segment, scene, curves)
            if not peaks_at_ends(meter, segment, scene):
                find_peaks(meter, segment, scene, curves)
        measure_acceleration(meter, segment.time, curves.absolute, curves.excitation, curves.scratch)
