"""Observables of a particle with friction in its cavity, on one segment."""

from damperlab.worker.jit import inlined
from damperlab.worker.solver.observe.meter import PARTICLE_LOSS, SLIDING, WORK_IN, Meter
from damperlab.worker.solver.regime import Segment
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.sliding import with_pull


@inlined
def measure_rubbing(meter: Meter, segment: Segment, scene: Scene) -> None:
    """Add the sliding time and the friction loss of a particle that slides in its cavity.

    The work of a shaken base is integrated from the offset of the spring centre, which includes the pull of the
    particle. The spring does not transmit this pull, so the work of the pull is added here, for a slipping and for a
    sticking mass.
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
