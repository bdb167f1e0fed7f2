"""Observables on one segment in contact with a compliant wall, or in flight with residual penetration."""

from damperlab.worker.jit import kernel
from damperlab.worker.solver.compliant_regime import AnyRegime, buffers_of
from damperlab.worker.solver.motion.compliant_motion import Buffers
from damperlab.worker.solver.motion.taylor import slope
from damperlab.worker.solver.observe.acceleration import measure_acceleration
from damperlab.worker.solver.observe.energies import (
    GAUSS,
    GAUSS_NODES,
    GAUSS_WEIGHTS,
    measure_energies,
)
from damperlab.worker.solver.observe.meter import IMPACT_LOSS, STUCK, Meter
from damperlab.worker.solver.observe.peaks import raise_peaks
from damperlab.worker.solver.scene import Curves, Scene


@kernel
def measure_contact(
    meter: Meter, moved: float, t: float, damping: float, regime: AnyRegime, scene: Scene
) -> None:
    """Measure a segment of length t from its polynomials; v changes by `moved` over the segment.

    `damping` is C while the wall pushes, and 0 after detachment.
    """
    buffers = buffers_of(scene)
    curves = curves_in_contact(buffers)
    integrate_contact(meter, moved, t, damping, regime, scene)
    raise_peaks(meter, t, regime.offset, scene, curves)
    measure_acceleration(meter, t, buffers.absolute, buffers.rate, buffers.scratch)


@kernel
def integrate_contact(
    meter: Meter, moved: float, t: float, damping: float, regime: AnyRegime, scene: Scene
) -> None:
    """Add a segment to energies, squares and the sticking time (see `measure_contact`)."""
    buffers = buffers_of(scene)
    if meter.energies is not None:
        curves = curves_in_contact(buffers)
        measure_energies(meter, moved, t, 1.0, buffers.wall_force, regime, scene, curves)
        struck = 0.0
        for i in range(GAUSS):
            y_rate = slope(buffers.y, GAUSS_NODES[i] * t)
            struck += GAUSS_WEIGHTS[i] * y_rate * y_rate
        meter.sums[IMPACT_LOSS] += t * damping * struck
    elif regime.sticks:
        meter.sums[STUCK] += t


@kernel
def curves_in_contact(buffers: Buffers) -> Curves:
    """Polynomials of a segment in contact, as `Curves`."""
    return Curves(buffers.relative, buffers.absolute, buffers.excitation, buffers.scratch)
