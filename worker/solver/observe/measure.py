"""Accumulation of observables on a segment without compliant contact."""

from damperlab.worker.jit import inlined
from damperlab.worker.solver.excitation.excitation import expand_base
from damperlab.worker.solver.excitation.record_base import RecordBase
from damperlab.worker.solver.observe.acceleration import measure_acceleration
from damperlab.worker.solver.observe.energies import measure_energies
from damperlab.worker.solver.observe.measure_sine import (
    find_peaks,
    measure_part,
    measure_window,
    peaks_at_ends,
)
from damperlab.worker.solver.observe.meter import PARTICLE_LOSS, SLIDING, WORK_IN, Meter
from damperlab.worker.solver.observe.peaks import raise_peaks
from damperlab.worker.solver.regime import Segment
from damperlab.worker.solver.scene import Curves, Scene
from damperlab.worker.solver.sliding import with_pull


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
        _measure_rubbing(meter, segment, scene)
        measure_window(meter, segment, scene)
        return True
    return False


@inlined
def measure(meter: Meter | None, segment: Segment, whole: bool, scene: Scene, curves: Curves) -> None:
    """Measure one segment from its polynomials; `whole` is True for a complete panel without events.

    The coefficients of the excitation are overwritten.
    """
    if meter is not None:
        _measure_rubbing(meter, segment, scene)
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


@inlined
def _measure_rubbing(meter: Meter, segment: Segment, scene: Scene) -> None:
    """Add the sliding time and the friction loss of a particle that slides in its cavity.

    The work of a shaken base is integrated from the offset of the spring centre, which includes the pull of
    the particle. The spring does not transmit the pull of the particle, so the work of this pull is added
    here, whether the mass slips or sticks.
    """
    if scene.particle is not None:
        if scene.particle.friction is not None:
            start, end = segment.start, segment.end
            if start.riding == 0.0:
                meter.sums[SLIDING] += segment.time
            if meter.energies is not None:
                rubs = scene.particle.mass_ratio * scene.particle.friction
                if start.riding == 0.0:
                    meter.sums[PARTICLE_LOSS] += rubs * abs(end.gap - start.gap)
                pull = with_pull(0.0, start, scene.particle)
                meter.sums[WORK_IN] += pull * (segment.phase_end.position - segment.phase.position)
