"""Figure of the displacements of a structure under one record, with each of several dampers."""

from matplotlib.figure import Figure

from damperlab.service.figures.style import BLUE, GREY, STYLE, VERMILION, styled
from damperlab.service.histories import histories_of
from damperlab.studies.ground.motion import STANDARD_GRAVITY
from damperlab.studies.ground.question import Earthquake
from damperlab.studies.vocabulary import CASES


def draw_earthquake(asked: Earthquake) -> Figure:
    """Draw the base acceleration and, for each damper, the displacement relative to the base.

    Grey curves show the displacement without a damper.

    Parameters
    ----------
    asked : Earthquake
        The record, the structure and the compared dampers.
    """
    factor = asked.values["scale"]
    histories = histories_of(asked)
    none = histories.get("none")
    shown = [case for case in asked.cases if case != "none"] or ["none"]
    with styled():
        figure = Figure(figsize=(6.6, 1.5 + 1.15 * len(shown)), layout="constrained")
        panels = figure.subplots(len(shown) + 1, 1, sharex=True)
        motion = asked.motion
        time = [k * motion.step_s for k in range(motion.acceleration_m_s2.size)]
        panels[0].plot(time, factor * motion.acceleration_m_s2 / STANDARD_GRAVITY, color="black", lw=0.5)
        panels[0].set_ylabel("Base [g]")
        for panel, case in zip(panels[1:], shown, strict=True):
            if none is not None and case != "none":
                panel.plot(
                    none["time_s"],
                    1e3 * none["relative_displacement_m"],
                    color=GREY,
                    lw=0.5,
                    label=CASES["none"],
                )
            history = histories[case]
            colour = VERMILION if case == "hybrid" else BLUE
            panel.plot(
                history["time_s"],
                1e3 * history["relative_displacement_m"],
                color=colour,
                lw=0.7,
                label=CASES[case],
            )
            panel.legend(loc="lower right", bbox_to_anchor=(1.0, 0.86), ncols=2, borderaxespad=0.0)
            panel.set_ylabel("$x - z$ [mm]")
        limit = max(max(abs(end) for end in panel.get_ylim()) for panel in panels[1:])
        for panel in panels[1:]:
            panel.set_ylim(-limit, limit)
        for panel in panels:
            panel.margins(x=0.005)
        panels[-1].set_xlabel("Time [s]")
        title = asked.motion.name if factor == 1.0 else f"{asked.motion.name}, times {factor:g}"
        figure.suptitle(title, x=0.02, ha="left", fontsize=STYLE["axes.titlesize"])
    return figure
