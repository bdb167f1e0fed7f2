"""The vector field of a segment, as the linearised motion asks for it at events."""

from damperlab.worker.jit import kernel
from damperlab.worker.solver.contact.media import medium_of


@kernel
def relative_acceleration(v, w, slip, riding, sine, base, free, loaded, friction, particle):
    """v'' in the regime of a segment, without the force of a compliant wall."""
    r = base.frequency_ratio
    offset = 0.0
    if friction is not None:
        if slip == 0.0:
            return 0.0
        offset = slip * friction
    compliance = free.compliance
    if particle is not None:
        compliance = medium_of(free, loaded, riding, particle.wall).compliance
    return r * r * sine - compliance * (base.two_zeta * w + v + offset)
