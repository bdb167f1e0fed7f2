"""The motion of a structure without a damper, which has no events, as one linear map over half a cycle."""

from damperlab.worker.jit import kernel
from damperlab.worker.solver.excitation.sine import Sine
from damperlab.worker.solver.linear_motion import LinearMotion
from damperlab.worker.solver.state import State


@kernel
def march_alone(state: State, halves: int, base: Sine, free: LinearMotion) -> State:
    """Integrate the structure alone over half cycles, mirrored as in `integrate.half_cycle`.

    The maps of all panels are composed once. Each half cycle is then one map (v, w) → −(P (v, w) + g).

    Parameters
    ----------
    state : State
        State at phase 0.
    halves : int
        Number of half cycles.
    base, free : Sine, LinearMotion
        The excitation and the motion of the primary mass.

    Returns
    -------
    state : State
        State at the end, at phase 0 of the mirrored base.
    """
    vv, vw, wv, ww = 1.0, 0.0, 0.0, 1.0
    v_push, w_push = 0.0, 0.0
    for k in range(base.windows):
        sine = base.sine[k]
        cosine = base.cosine[k]
        vv, wv = free.xx * vv + free.xw * wv, free.wx * vv + free.ww * wv
        vw, ww = free.xx * vw + free.xw * ww, free.wx * vw + free.ww * ww
        v_push, w_push = (
            (free.xx * v_push + free.xw * w_push) + (free.xs * sine + free.xc * cosine),
            (free.wx * v_push + free.ww * w_push) + (free.ws * sine + free.wc * cosine),
        )
    v, w = state.v, state.w
    for _ in range(halves):
        v, w = -((vv * v + vw * w) + v_push), -((wv * v + ww * w) + w_push)
    sign = -1.0 if halves % 2 == 1 else 1.0
    return State(
        v=v,
        w=w,
        slip=state.slip,
        wall=sign * state.wall,
        gap=state.gap,
        p_rate=sign * state.p_rate,
        riding=state.riding,
        slip_order=0,
        gap_order=0,
        dwell=state.dwell,
        slide=state.slide,
    )
