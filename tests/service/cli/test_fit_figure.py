"""The legend of a fit's figure names the conditions of the measured rows; their colours can be told apart."""

from itertools import combinations

import numpy as np
from docs.console import ROOT, TITLED
from matplotlib.colors import to_rgb
from tests.studies.fit.estimates import estimate

from damperlab.service.figures.fit import draw_fit
from damperlab.studies.fit.asking import make_question
from damperlab.studies.fit.fitted import Fitted
from damperlab.studies.fit.measured import parse_measurement
from damperlab.worker.fit.curve import Curve

TOLD_APART = 0.25
"""Distance of two colours, of √3 from black to white."""


def test_the_seven_peaks_of_the_paper_have_seven_colours_and_no_cavity_where_there_was_no_particle() -> None:
    tables = dict(TITLED.findall((ROOT / "docs/how-to/fit.md").read_text()))
    measured = parse_measurement(tables["peaks.csv"])
    known = {
        "damping_ratio": 0.0038,
        "axes": {"restitution": 0.47},
        "physical": {"natural_frequency_hz": 2.5},
    }
    question = make_question(measured, known, {"friction_ratio": (0.0, 0.78)})
    same = np.ones(measured.rows)
    found = estimate("friction_ratio", 0.4, 0.3, 0.5)
    fitted = Fitted(
        question,
        (found,),
        np.eye(1),
        measured.amplitude,
        0.1 * same,
        0.1 * same,
        same,
        same,
        np.ones(7, int),
        1,
    )
    band = np.array([2.4, 2.6])
    figure = draw_fit(fitted, [Curve(band, np.full(2, 5.0 + at)) for at in range(7)])
    (legend,) = figure.legends
    texts = [text.get_text() for text in legend.get_texts()]
    assert texts.count(r"$β$ = 0") == 1
    assert not [text for text in texts if "$β$ = 0," in text and "$d/Z$" in text]
    colours = [np.array(to_rgb(line.get_color())) for line in legend.get_lines()]
    assert len(colours) == 7
    assert min(np.linalg.norm(one - other) for one, other in combinations(colours, 2)) > TOLD_APART
