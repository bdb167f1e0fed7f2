"""Figures of a design: alternatives over the band, responses under several amplitudes, and response over the mass."""

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from numpy.typing import NDArray

from damperlab.service.figures.style import BLUE, COLOURS, GREY, VERMILION, styled, ticks_1_2_5
from damperlab.studies.design.absorber import curve as absorber_curve
from damperlab.studies.design.build import Build
from damperlab.studies.design.found import Found
from damperlab.studies.design.spelling import level
from damperlab.studies.specification.specification import Specification
from damperlab.studies.tmd.absorber import Absorber

Floats = NDArray[np.float64]
GREEN = "#009e73"
"""Green of the Okabe-Ito palette."""
DEEPEST = 300.0
"""Largest ratio of the highest peak to the lower end of the axis."""
SAMPLES = 801
"""Number of points of a curve that has a closed form."""


def draw_alternatives(found: Found, called: str) -> Figure:
    """Draw the responses over the band at the largest amplitude, with the best damper found and each alternative.

    Parameters
    ----------
    found : Found
        The findings of the search.
    called : str
        Name of the best damper found, see `damperlab.studies.design.verdict.called_of`.
    """
    asked, largest = found.asked, found.binding.largest
    with styled():
        figure, axes = _canvas(asked)
        r = np.linspace(found.binding.low, found.binding.high, SAMPLES)
        _line(axes, asked, r, absorber_curve(asked, largest, Absorber(0.0, 1.0, 1.0), r), GREY, "no damper")
        if found.absorber is not None:
            beside = absorber_curve(asked, largest, found.absorber.absorber, r)
            _line(axes, asked, r, beside, VERMILION, "tuned mass damper")
        for name, colour, label in (
            ("friction_alone", GREEN, "friction alone"),
            ("particle_alone", "#cc79a7", "particle alone"),
        ):
            if name in found.others:
                _line(axes, asked, *_known(found, found.others[name].build), colour, label)
        _line(axes, asked, *_known(found, found.build), BLUE, called, marker="o", ms=2.2)
        axes.set_yscale("log")
        ticks_1_2_5(axes.yaxis)
        axes.set_ylabel(_label(asked, asked.measure.words))
        axes.legend()
    return figure


def draw_amplitudes(found: Found) -> Figure:
    """For each base amplitude, draw the response with the best damper found. Draw a curve through the peaks."""
    asked = found.asked
    norm = LogNorm(found.shown[0].reference_m, found.shown[-1].reference_m)
    colours = colormaps[COLOURS]
    peaks: list[tuple[float, float]] = []
    with styled():
        figure, axes = _canvas(asked)
        for amplitude in found.shown:
            curve = found.book.curve(found.build, amplitude)
            r, values = curve.r, curve.measured / curve.base_m / curve.rate**asked.measure.order
            name = level(asked, amplitude) if asked.in_units else f"{amplitude.reference_m:.3g}"
            place = int(values.argmax())
            held = (
                values[place] == 0.0
            )  # friction holds the structure, and a logarithmic axis cannot show zero
            colour = colours(norm(amplitude.reference_m))
            axes.plot(_frequencies(asked, r), values, color=colour, label=f"{name}, held" if held else name)
            if not held:
                peaks.append((float(_frequencies(asked, r)[place]), float(values[place])))
        if peaks:
            if not asked.measure.mean:  # an rms over the band has no frequency
                axes.plot(*np.transpose(peaks), color="black", ls=":", marker="o", ms=3)
            axes.set_yscale("log")
            ticks_1_2_5(axes.yaxis)
            # the tiny values of a sticking mass would dominate a logarithmic axis
            axes.set_ylim(bottom=max(axes.get_ylim()[0], max(top for _, top in peaks) / DEEPEST))
        force = found.shown[0].excitation.motion.force
        over = f"{'static displacement' if force else 'base amplitude'}{' times $ω_n^2$' if asked.measure.order else ''}"
        axes.set_ylabel(f"Response over {over}")
        figure.legend(title=found.shown[0].excitation.motion.words, ncols=4, loc="outside lower center")
    return figure


def draw_front(found: Found) -> Figure:
    """Draw the best response over the particle mass, and the response with a tuned mass damper of equal mass."""
    asked, size = found.asked, _size(found.asked)
    share = 1.0 if asked.in_units else asked.structure.mass_kg
    with styled():
        figure = Figure(figsize=(6.6, 4.2), layout="constrained")
        axes = figure.add_subplot()
        tuned = [
            (each.mass_kg / share, size * each.absorber) for each in found.front if each.absorber is not None
        ]
        if tuned:
            axes.plot(
                *np.transpose(tuned), color=VERMILION, marker="s", ms=4, ls="--", label="tuned mass damper"
            )
        drawn = [(each.mass_kg / share, size * each.score.value) for each in found.front]
        axes.plot(*np.transpose(drawn), color=BLUE, marker="o", ms=4, label="best found, as drawn")
        axes.grid(color="#dddddd", lw=0.5)
        axes.set_ylim(bottom=0.0)
        axes.legend()
        axes.set(
            xlabel="Mass of the particle [kg]" if asked.in_units else "Mass ratio $β$",
            ylabel=_label(
                asked, asked.measure.judged if asked.measure.mean else f"largest {asked.measure.judged}"
            ),
        )
    return figure


def _label(asked: Specification, words: str) -> str:
    """Return a short label of an axis, without "of the structure", which applies to every quantity in these figures."""
    words = words.replace(" of the structure", "")
    return f"{words[:1].upper()}{words[1:]} [{_unit(asked)}]"


def _canvas(asked: Specification) -> tuple[Figure, Axes]:
    figure = Figure(figsize=(6.6, 4.2), layout="constrained")
    axes = figure.add_subplot()
    axes.grid(color="#dddddd", lw=0.5)
    axes.set_axisbelow(True)
    axes.set_xlabel("Excitation frequency [Hz]" if asked.in_units else "Frequency ratio $r$")
    axes.margins(x=0.01)
    return figure, axes


def _line(
    axes: Axes,
    asked: Specification,
    r: Floats,
    values: Floats,
    colour: str,
    name: str,
    marker: str = "",
    ms: float = 0.0,
) -> None:
    finite = np.where(np.isfinite(values), values, np.nan)
    axes.plot(
        _frequencies(asked, r), _size(asked) * finite, color=colour, label=name, marker=marker, markersize=ms
    )


def _known(found: Found, build: Build) -> tuple[Floats, Floats]:
    """Return the computed frequency ratios and responses of a build, under the binding excitation."""
    curve = found.book.curve(build, found.binding.largest)
    return curve.r, curve.measured


def _frequencies(asked: Specification, r: Floats) -> Floats:
    return r * asked.structure.natural_frequency_hz if asked.in_units else r


def _size(asked: Specification) -> float:
    return 1e3 if asked.unit == "m" else 1.0


def _unit(asked: Specification) -> str:
    return {"m": "mm", "1": "$Zω_n^2$" if asked.measure.order else "$Z$"}.get(asked.unit, asked.unit)
