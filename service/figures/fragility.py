"""A fragility curve, and the results under the records to which the curve was fitted."""

import xarray as xr
from matplotlib.figure import Figure

from damperlab.service.figures.style import BLUE, GREY, MILLIMETRES, VERMILION, drawn, styled
from damperlab.studies.answers.phrases import TERMS


def draw_fragility(answer: xr.Dataset) -> Figure:
    """Draw the results over the scale of the records, and below them the probability of exceeding the limit.

    Parameters
    ----------
    answer : Dataset
        The answer of `damperlab.studies.answers.fragility`.
    """
    scale = answer["scale"].values
    found = dict(answer.attrs)
    if answer["median"].attrs["units"] == "m":
        answer = drawn(answer)
        found["threshold"] *= MILLIMETRES
    metric = TERMS.get(found["metric"], found["metric"])
    units = answer["median"].attrs["units"]
    unit = "" if units == "1" else f" {units}"
    with styled():
        figure = Figure(figsize=(6.0, 5.4), layout="constrained")
        above, below = figure.subplots(2, 1, sharex=True)
        above.fill_between(
            scale, answer["lowest"].values, answer["highest"].values, color=GREY, alpha=0.3, lw=0
        )
        above.plot(
            scale,
            answer["median"].values,
            "o-",
            color=BLUE,
            ms=3.5,
            label="median; shaded: smallest to largest",
        )
        above.axhline(
            found["threshold"], color=VERMILION, lw=1, ls="--", label=f"limit {found['threshold']:g}{unit}"
        )
        above.set(ylabel=f"{metric}{f' [{units}]' if unit else ''}", ylim=(0, None))
        above.legend()
        below.plot(
            scale,
            answer["exceeded"].values,
            "o",
            color=BLUE,
            ms=4.5,
            label=f"share of {found['records']} records",
        )
        if "median_scale" in found:
            low, high = found["median_scale_interval"]
            label = f"median {found['median_scale']:.3g} (95 %: {low:.3g} to {high:.3g}), dispersion {found['dispersion']:.2g}"
            below.plot(scale, answer["probability"].values, color=VERMILION, label=label)
        below.set(xlabel="factor on the records", ylabel="probability of exceeding", ylim=(-0.03, 1.03))
        below.legend()
    return figure
