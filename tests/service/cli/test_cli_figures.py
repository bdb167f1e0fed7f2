"""Figures of answers and fits whose content is known."""

import json
from concurrent.futures import ThreadPoolExecutor
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from docs.console import ROOT, TITLED
from matplotlib.colors import to_rgb
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.path import Path as Path2D
from tests.studies.fit.estimates import estimate

from damperlab.service.figures.comparison import draw_comparison
from damperlab.service.figures.fit import draw_fit, title_of
from damperlab.service.figures.resonance_map import draw_map
from damperlab.service.figures.style import is_logarithmic, save
from damperlab.studies.answers.optimal_designs import optimal_designs
from damperlab.studies.answers.quantities import in_quantities, with_quantities
from damperlab.studies.answers.resonance_map import resonance_map
from damperlab.studies.answers.tmd_comparison import tmd_comparison
from damperlab.studies.fit.asking import FREE, make_question
from damperlab.studies.fit.fitted import Estimate, Fitted
from damperlab.studies.fit.history.asking import FREE as FREE_OF_HISTORY
from damperlab.studies.fit.measured import parse_measurement
from damperlab.studies.questions import Selection, Tuning
from damperlab.studies.variables import DIMENSION_LONG_NAMES, DIMENSIONS, VARIABLES, ResponseClass, Status
from damperlab.worker.fit.model import FittedCurve

X, Y = np.linspace(1.0, 12.0, 12), np.linspace(0.0, 0.9, 10)


def cube(
    values: np.ndarray,
    kinds: np.ndarray | None = None,
    status: np.ndarray | None = None,
    also: dict[str, np.ndarray] | None = None,
) -> xr.Dataset:
    """Put arrays over clearance and friction, or frequencies as well, into a cube; of symmetric responses unless told."""
    kinds = symmetric(values) if kinds is None else kinds
    status = np.zeros(values.shape, np.int8) if status is None else status
    axes = dict.fromkeys(DIMENSIONS, np.ones(1)) | {"clearance_ratio": X, "friction_ratio": Y} | (also or {})
    arrays = {"amplitude_ratio": values, "response_class": kinds, "status": status}
    shape = tuple(axes[name].size for name in DIMENSIONS)
    return xr.Dataset(
        {
            name: (DIMENSIONS, array.reshape(shape), {"long_name": VARIABLES[name].long_name, "units": "1"})
            for name, array in arrays.items()
        },
        {
            name: (name, axis, {"long_name": DIMENSION_LONG_NAMES[name], "units": "1"})
            for name, axis in axes.items()
        },
    )


def symmetric(values: np.ndarray) -> np.ndarray:
    return np.full(values.shape, int(ResponseClass.SYMMETRIC), np.int8)


def a_map(study: xr.Dataset, metric: str = "amplitude_ratio", over: str | None = None) -> xr.Dataset:
    return resonance_map(study, "clearance_ratio", "friction_ratio", Selection(metric), over)


def known_map() -> xr.Dataset:
    """A bowl whose lowest point is locked, the second lowest has no impacts, the third has; one point failed, one waits."""
    values = 5.0 + (X[:, None] - 6.0) ** 2 + 50.0 * (Y[None, :] - 0.5) ** 2
    kinds, status = symmetric(values), np.zeros(values.shape, np.int8)
    for place, value, kind in (
        ((2, 3), 1.0, ResponseClass.LOCKED),
        ((7, 8), 2.0, ResponseClass.NO_IMPACT),
        ((9, 1), 3.0, ResponseClass.MODULATED),
    ):
        values[place], kinds[place] = value, kind
    values[0, 0], status[0, 0] = np.nan, Status.TOO_MANY_EVENTS
    values[11, 9], status[11, 9] = np.nan, Status.NOT_COMPUTED
    return a_map(cube(values, kinds, status))


def labels(figure: Figure) -> list[str]:
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def test_stars_stand_at_the_best_design_and_the_best_with_impacts_and_odd_points_are_told_apart() -> None:
    figure = draw_map(known_map(), "amplitude_ratio")
    stars = [line for line in figure.axes[0].lines if line.get_marker() == "*"]
    places = [(float(star.get_xdata()[0]), float(star.get_ydata()[0])) for star in stars]
    np.testing.assert_allclose(places, [(X[7], Y[8]), (X[9], Y[1])])
    assert labels(figure)[0].startswith("optimum: 2 at")
    assert labels(figure)[1].startswith("best with impacts: 3 at")
    assert labels(figure)[2:] == ["locked to the base", "failed", "not computed"]


def test_the_second_star_of_a_map_over_the_frequency_says_that_it_knows_the_worst_frequency_alone() -> None:
    """The optimum strikes at r = 1 and is largest without impacts at r = 1.1: to `optimum` it is one with impacts."""
    values = np.stack([np.full((X.size, Y.size), 1.0), 5.0 + (X[:, None] - 6.0) ** 2 + 0 * Y], axis=-1)
    kinds = symmetric(values)
    kinds[5, :, 1] = ResponseClass.NO_IMPACT
    study = cube(values, kinds, also={"frequency_ratio": np.array([1.0, 1.1])})
    assert optimal_designs(study).attrs["best_with_impacts"]["value"] == 5.0
    over = a_map(study, over="frequency_ratio")
    first, second = labels(draw_map(over, "amplitude_ratio"))
    assert first.startswith("optimum: 5 at")
    assert second.startswith("best that strikes where it is largest: 6 at")


def test_a_map_of_a_study_without_a_particle_has_no_star_of_impacts() -> None:
    values = 5.0 + (X[:, None] - 6.0) ** 2 + 50.0 * (Y[None, :] - 0.5) ** 2
    kinds = np.full(values.shape, int(ResponseClass.MODULATED), np.int8)  # friction alone, not resolved
    kinds[5, 5] = ResponseClass.NO_IMPACT
    drawn = draw_map(a_map(cube(values, kinds, also={"mass_ratio": np.zeros(1)})), "amplitude_ratio")
    assert [label.partition(":")[0] for label in labels(drawn)] == ["optimum"]


def test_a_design_is_hatched_as_locked_only_where_its_largest_value_is() -> None:
    """Of equal values, as those without an impact, one at which the mass moves stands for all."""
    values = np.zeros((X.size, Y.size, 2))
    kinds = np.full(values.shape, int(ResponseClass.LOCKED), np.int8)
    kinds[:5, :, 1] = ResponseClass.NO_IMPACT  # locked at the first frequency alone
    values[5, :, 0] = 1.0
    kinds[5, :, 1] = ResponseClass.SYMMETRIC  # largest where it is locked
    study = cube(values, kinds, also={"frequency_ratio": np.array([0.9, 1.0])})
    over = a_map(study, over="frequency_ratio")
    locked = over["response_class"].values.T == ResponseClass.LOCKED
    np.testing.assert_array_equal(locked, np.repeat(np.arange(X.size) >= 5, Y.size).reshape(X.size, Y.size))
    assert "locked to the base where it is largest" in labels(draw_map(over, "amplitude_ratio"))


@pytest.mark.parametrize(
    ("metric", "title"),
    [
        ("impact_speed_max", "Largest impact speed over $Z$·$ω_n$"),
        ("amplitude_ratio", "Amplitude ratio $X/Z$"),
        ("impact_speed_max_m_per_s", "Largest approach speed at an impact [m/s]"),
    ],
)
def test_the_scale_of_colours_says_its_unit_or_what_it_is_over(metric: str, title: str) -> None:
    values = np.random.default_rng(1).uniform(1, 2, (X.size, Y.size))
    study = cube(values)
    study["impact_speed_max"] = study["amplitude_ratio"].copy()
    study["impact_speed_max"].attrs = {"units": "1", "long_name": "largest impact speed"}
    study["amplitude_ratio"].attrs = {"units": "1", "long_name": "amplitude ratio X/Z"}
    study.attrs["study"] = json.dumps(
        {"physical": {"mass_kg": 2.0, "natural_frequency_hz": 4.0, "base_amplitude_m": 0.001}}
    )
    assert draw_map(a_map(study, metric), metric).axes[1].get_ylabel() == title


def test_a_map_over_the_friction_of_the_particle_in_units_names_its_coefficient() -> None:
    study = cube(np.tile(2.0 - Y, (X.size, 1))).rename(friction_ratio="particle_friction_ratio")
    study = study.expand_dims(friction_ratio=[1.0])
    structure = {"mass_kg": 2.0, "natural_frequency_hz": 4.0, "base_amplitude_m": 0.001}
    study.attrs["study"] = json.dumps({"physical": structure})
    found = resonance_map(study, "clearance_m", "particle_friction_coefficient", Selection("amplitude_ratio"))
    least = float(found["particle_friction_coefficient"].values[-1])
    assert labels(draw_map(found, "amplitude_ratio")) == [f"optimum: 1.1 at $μ_i$ = {least:.4g}, any $d$"]


def test_an_optimum_that_a_whole_row_shares_is_said_to_be_one() -> None:
    figure = draw_map(a_map(cube(np.tile(2.0 - Y, (X.size, 1)))), "amplitude_ratio")
    assert labels(figure) == ["optimum: 1.1 at $γ_F$ = 0.9, any $d/Z$"]
    # at the first of them, which is the design that the ranking names
    (star,) = (line for line in figure.axes[0].lines if line.get_marker() == "*")
    assert (star.get_xdata()[0], star.get_ydata()[0]) == (X[0], Y[-1])


def test_no_number_of_a_contour_line_stands_on_a_line_or_on_another_number() -> None:
    values = 3.0 + (X[:, None] / 4.0) * (1.0 + Y[None, :])
    values[:, -1], values[6:, -2] = (
        0.8,
        30.0,
    )  # the lines of 1, 2, 5, 10 and 20 lie side by side below the last row
    figure = draw_map(a_map(cube(values)), "amplitude_ratio")
    figure.canvas.draw()
    axes = figure.axes[0]
    numbers = [text for text in axes.texts if text.get_text()]
    assert numbers
    assert len({text.get_text() for text in numbers}) == len(numbers)
    boxes = [text.get_window_extent() for text in numbers]
    assert not any(one.overlaps(other) for at, one in enumerate(boxes) for other in boxes[:at])
    lines = [each for each in axes.collections if isinstance(each, ContourSet)]
    corners = [
        axes.transData.transform(piece)
        for line in lines
        for path in line.get_paths()
        for piece in path.to_polygons(closed_only=False)
    ]
    for box in boxes:
        # the middle of a number, which the line that it names is cut for
        middle = box.expanded(0.5, 0.5)
        assert not any(Path2D(piece).intersects_bbox(middle, filled=False) for piece in corners)


def test_codes_are_named_on_their_scale() -> None:
    figure = draw_map(known_map(), "response_class")
    names = [text.get_text() for text in figure.axes[1].get_yticklabels()]
    assert names == [kind.name.lower().replace("_", " ") for kind in ResponseClass]
    assert not [line for line in figure.axes[0].lines if line.get_marker() == "*"]


def test_an_axis_is_logarithmic_where_its_values_are() -> None:
    assert is_logarithmic(np.geomspace(0.01, 100, 9))
    assert not is_logarithmic(np.linspace(0.01, 100, 9))
    assert not is_logarithmic(np.geomspace(0.8, 1.25, 9))


def comparison(values: np.ndarray) -> xr.Dataset:
    """Compare a design with a tuned mass damper over a band around r = 1."""
    r = np.linspace(0.8, 1.2, values.size)
    axes = dict.fromkeys(DIMENSIONS, np.full(1, 0.1)) | {"frequency_ratio": r}
    shape = tuple(axes[name].size for name in DIMENSIONS)
    arrays = {"amplitude_ratio": values.reshape(shape), "status": np.zeros(shape, np.int8)}
    return tmd_comparison(
        xr.Dataset({name: (DIMENSIONS, array) for name, array in arrays.items()}, axes), Tuning(detuning=0.05)
    )


def test_a_comparison_draws_three_curves_and_shades_where_the_study_is_better() -> None:
    # worse than a tuned mass damper at r = 1 alone
    answer = comparison(np.array([0.5, 0.5, 0.5, 0.5, 50.0, 0.5, 0.5, 0.5, 0.5]))
    (axes,) = draw_comparison(answer).axes
    names = [text.get_text() for text in axes.get_legend().get_texts()]
    assert names[0] == "study's damper better"
    assert "+0.05 in frequency" in names[2]
    curves = {line.get_label(): line for line in axes.lines}
    np.testing.assert_array_equal(curves["study's damper"].get_ydata(), answer["hybrid"])
    for label, name in ((names[2], "tmd"), ("no damper", "no_damper")):
        x, y = curves[label].get_data()
        np.testing.assert_array_equal(y[np.isin(x, answer["frequency_ratio"])], answer[name])
    spans = [(p.get_x(), p.get_x() + p.get_width()) for p in axes.patches]
    # below and above r = 1, where the study's 50 is the worse
    np.testing.assert_allclose(spans, answer.attrs["hybrid_better"])
    assert [round(edge, 3) for span in spans for edge in span] == [0.8, 0.95, 1.05, 1.2]


def test_threads_draw_the_same_bytes(tmp_path: Path) -> None:
    answer = comparison(np.array([2.8, 2.3]))

    def draw(index: int) -> bytes:
        path = tmp_path / f"{index}.svg"
        save(draw_comparison(answer), path)
        return path.read_bytes()

    with ThreadPoolExecutor(4) as pool:
        assert len(set(pool.map(draw, range(4)))) == 1


def test_nothing_is_shaded_where_a_peak_may_lie_between_the_frequencies() -> None:
    """At r = 0.8 and 1.2 the structure alone has 2.8 and 2.3, and 132 between them."""
    answer = comparison(np.array([2.8, 2.3]))
    assert answer.attrs["hybrid_better"]
    (axes,) = draw_comparison(answer).axes
    assert not axes.patches
    curves = {line.get_label(): line.get_ydata() for line in axes.lines}
    tuned = next(curve for label, curve in curves.items() if label.startswith("tuned mass damper"))
    assert tuned.max() == pytest.approx(answer.attrs["tmd_peak"], rel=1e-12)
    # at r = 1 the closed form of a shaken base, √(1 + 4 ζ²)/(2 ζ), which no frequency of the study is near
    doubled = 2 * float(answer["damping_ratio"])
    assert curves["no damper"].max() >= np.hypot(1, doubled) / doubled * (1 - 1e-12)


def test_the_title_of_a_fit_names_whatever_can_be_estimated_by_its_symbol_and_lengths_in_mm() -> None:
    titles = {name: title_of([Estimate(name, 0.0123, *[0.0] * 6, 1.0)]) for name in {*FREE, *FREE_OF_HISTORY}}
    assert not [title for name, title in titles.items() if name in title]
    assert titles["clearance_m"] == "$d$ = 12.3 mm"
    assert titles["friction_ratio"] == "$γ_F$ = 0.0123"
    assert titles["natural_frequency_hz"] == "$f_n$ = 0.0123 Hz"


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
        question=question,
        estimates=(found,),
        correlation=np.eye(1),
        model=measured.amplitude,
        model_error=0.1 * same,
        deviation=0.1 * same,
        impacts_per_cycle=same,
        stick_fraction=same,
        response_class=np.ones(7, int),
        evaluations=1,
    )
    band = np.array([2.4, 2.6])
    figure = draw_fit(fitted, [FittedCurve(band, np.full(2, 5.0 + at)) for at in range(7)])
    (legend,) = figure.legends
    texts = [text.get_text() for text in legend.get_texts()]
    assert texts.count(r"$β$ = 0") == 1
    assert not [text for text in texts if "$β$ = 0," in text and "$d/Z$" in text]
    colours = [np.array(to_rgb(line.get_color())) for line in legend.get_lines()]
    assert len(colours) == 7
    assert min(np.linalg.norm(one - other) for one, other in combinations(colours, 2)) > TOLD_APART


def test_a_map_in_units_has_all_in_units_and_its_legend_inside_the_figure() -> None:
    values = np.stack([np.full((X.size, Y.size), 1.0), 5.0 + (X[:, None] - 6.0) ** 2 + 0 * Y], axis=-1)
    kinds = symmetric(values)
    kinds[5, :, 1] = ResponseClass.NO_IMPACT
    study = cube(values, kinds, also={"frequency_ratio": np.array([1.0, 1.1])})
    physical = {"mass_kg": 2.0, "natural_frequency_hz": 4.0, "base_amplitude_m": 0.0004}
    answer = with_quantities(a_map(study, over="frequency_ratio"), {"physical": physical})
    figure = draw_map(*in_quantities(answer, "amplitude_ratio"))
    figure.canvas.draw()
    (axes, colours), (legend,) = figure.axes, figure.legends
    assert "[mm]" in axes.get_xlabel()
    assert "[N]" in axes.get_ylabel()
    assert "[mm]" in colours.get_ylabel()
    assert labels(figure)[0].startswith("optimum: 2 mm at $d$ = 2.4 mm, any")
    assert legend.get_window_extent().x0 >= 0.0
    assert legend.get_window_extent().x1 <= figure.bbox.x1
