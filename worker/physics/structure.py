"""The primary structure on its own: a damped oscillator on a shaken base, in closed form."""

from math import hypot, inf

from damperlab.worker.jit import inlined


@inlined
def transmissibility(damping_ratio: float, frequency_ratio: float) -> float:
    """X/Z of the structure without damper: √[(1+(2ζr)²)/((1−r²)²+(2ζr)²)]; inf for ζ = 0 at r = 1."""
    loss = 2.0 * damping_ratio * frequency_ratio
    detuning = (1.0 - frequency_ratio) * (1.0 + frequency_ratio)  # accurate near r = 1
    bottom = hypot(detuning, loss)
    return hypot(1.0, loss) / bottom if bottom > 0.0 else inf


@inlined
def relative_transmissibility(damping_ratio: float, frequency_ratio: float) -> float:
    """|x − z|/Z of the structure without damper: r²/√[(1−r²)²+(2ζr)²]; inf for ζ = 0 at r = 1."""
    detuning = (1.0 - frequency_ratio) * (1.0 + frequency_ratio)
    bottom = hypot(detuning, 2.0 * damping_ratio * frequency_ratio)
    return frequency_ratio * frequency_ratio / bottom if bottom > 0.0 else inf
