"""Inputs of questions about a study, as frozen dataclasses. Every interface offers the fields of these classes."""

from dataclasses import MISSING, dataclass

from damperlab.studies.field import NONE, At, Range, Ranges, asked, asked_at
from damperlab.studies.ground.variables import RECORD
from damperlab.studies.kinds import EVERY_DIMENSION, EVERY_VARIABLE
from damperlab.studies.unit_names import COORDINATES, RESULTS
from damperlab.studies.variables import DIMENSIONS, VARIABLES
from damperlab.studies.vocabulary import (
    CASES,
    CRITERIA,
    OBJECTIVES,
    RESPECTS,
    Criterion,
    Excitation,
    Method,
    Objective,
    Reduction,
)

EVERY_AXIS: tuple[str, ...] = tuple(dict.fromkeys((*EVERY_DIMENSION, *COORDINATES)))
"""All names that may locate a point: dimensions, and coordinates of studies in SI units."""
EVERY_METRIC: tuple[str, ...] = (*EVERY_VARIABLE, *RESULTS)
"""All results that may be shown, as ratios or in units."""
RANGED: tuple[str, ...] = (
    *(name for name in EVERY_AXIS if name != RECORD),
    *(name for name, variable in VARIABLES.items() if variable.flags is None),
    *RESULTS,
)
"""All names that may be limited to a range: numeric dimensions, and all results except codes."""
MOST_DESIGNS = 10_000
"""Largest number of designs in one answer."""
FINEST = 1e-9
"""Smallest allowed step of a search for a parameter."""
MOST_ABSORBER_MASS = 10.0
"""Largest mass ratio of a tuned mass damper."""
MOST_DETUNING = 10.0
MOST_STARTS = 256
"""Largest number of initial states of one request."""
MOST_SEED = 2**63 - 1

_WITH = ("--with",)


@dataclass(frozen=True)
class Judging:
    """Criterion and constraints for ranking designs, common to all kinds of ranking."""

    objective: Objective | None = asked(
        None,
        "Criterion of the ranking; peak by default, resonance if the study has one frequency.",
        meanings=OBJECTIVES,
    )
    band: Range | None = asked(None, "Consider only frequency ratios in this band.", form="LO,HI")
    exclude_locked: bool = asked(
        False,
        "Exclude designs in which friction locks the mass to its base near resonance: at the considered "
        "frequency ratio nearest 1 and, if the base amplitude varies, at every amplitude. Designs locked "
        "only at other frequencies stay.",
    )
    max_impact_speed: float | None = asked(
        None,
        "Exclude designs with impacts faster than this speed, in units of Z·ω_n. For a limit in m/s, give a "
        "range of "
        "impact_speed_max_m_per_s.",
        least=0,
    )
    ranges: Ranges = asked(
        NONE,
        "Keep only designs with a dimension or a result, for example stick_fraction, in this range; a "
        "result must lie in "
        "it at every considered frequency. The impact speed of a response without impacts counts as 0. A "
        "response that "
        "does not repeat has no Floquet multiplier, so any range of the multiplier excludes it.",
        form="NAME=LO,HI",
        options=("--within",),
    )


@dataclass(frozen=True)
class Listed:
    """The number of designs that a ranking lists."""

    top: int = asked(10, "Number of designs to list.", least=1, most=MOST_DESIGNS)


@dataclass(frozen=True)
class Ranking(Listed):
    """Further fields of a ranking, and the included follow-up studies."""

    pareto: tuple[str, ...] | None = asked(
        None,
        f"List the Pareto-optimal designs in two or three of these quantities, separated by commas: {', '.join(RESPECTS)}. A "
        "minus in front of a name means that larger is better.",
        form="A,B[,C]",
        example="amplitude,mass",
    )
    with_: tuple[str, ...] = asked(
        (),
        "Rank the designs of this follow-up study as well.",
        form="ID",
        options=_WITH,
        studies=True,
    )
    metric: str | None = asked(
        None,
        "Result whose worst case ranks the dampers; by default peak_relative_displacement_m for a "
        "ground-motion "
        "suite, and amplitude_m over base amplitudes.",
        allowed=EVERY_VARIABLE,
    )
    records: tuple[str, ...] | None = asked(
        None,
        "Consider only this record of a ground-motion suite; all records by default.",
        form="ID",
        key="record",
        options=("--record",),
    )


@dataclass(frozen=True)
class Selection:
    """The result to show, and the point or slice of the study."""

    metric: str | None = asked(
        None,
        "Result variable to show; amplitude_ratio by default, amplitude_m over base amplitudes, "
        "peak_relative_displacement_m for a ground-motion suite.",
        allowed=EVERY_METRIC,
    )
    at: At = asked_at()


@dataclass(frozen=True)
class Followed(Selection):
    """The result to show as a function of the frequency, and the design."""

    metric: str | None = asked(
        None,
        "Result variable to show; amplitude_ratio by default, amplitude_m over base amplitudes.",
        allowed=EVERY_METRIC,
    )


@dataclass(frozen=True)
class Plane:
    """The two dimensions of a map, and the treatment of a third dimension."""

    x: str | None = asked(
        None, "Dimension on the horizontal axis.", allowed=EVERY_AXIS, example="friction_ratio"
    )
    y: str | None = asked(
        None, "Dimension on the vertical axis.", allowed=EVERY_AXIS, example="frequency_ratio"
    )
    over: str | None = asked(None, "A third dimension, over which the result is reduced.", allowed=EVERY_AXIS)
    reduce: Reduction | None = asked(None, "How the third dimension is reduced; max by default.")


@dataclass(frozen=True)
class Fragile:
    """Inputs of a fragility curve: a result, its limit, and the damper of a ground-motion suite."""

    threshold: float = asked(
        MISSING, "Limit that the result exceeds, in its SI unit; 0.02 for 20 mm.", above=0
    )
    metric: str | None = asked(
        None,
        "Result that exceeds the limit; peak_relative_displacement_m by default.",
        allowed=EVERY_VARIABLE,
    )
    quantile: float = asked(
        0.9,
        "Also give the value below which this share of the records stays.",
        least=0.01,
        most=0.99,
    )
    at: At = asked_at()


@dataclass(frozen=True)
class Window:
    """The visible part of a map."""

    x_range: Range | None = asked(None, "Show only this range of the horizontal axis.", doors=("http",))
    y_range: Range | None = asked(None, "Show only this range of the vertical axis.", doors=("http",))
    most: int | None = asked(
        None,
        "Largest number of values along x and along y. If there are more, evenly spaced ones are shown.",
        least=2,
        most=2000,
        doors=("http",),
    )


@dataclass(frozen=True)
class Second:
    """A second study for comparison."""

    with_: str | None = asked(
        None,
        "A second study to compare with, for example the downward continuation of a hysteresis.",
        form="ID",
        options=_WITH,
        studies=True,
    )


@dataclass(frozen=True)
class Subtracted:
    """A second study whose map is subtracted from the map of the first study."""

    minus: str | None = asked(
        None,
        "A second study with the same axes, shown next to the first and subtracted from it.",
        form="ID",
        studies=True,
    )


@dataclass(frozen=True)
class Tuning:
    """The tuned mass damper for comparison with a design."""

    criterion: Criterion = asked("minimax", "How the tuned mass damper is tuned.", meanings=CRITERIA)
    mass_ratio: float | None = asked(
        None,
        "Mass ratio of the tuned mass damper and of the design; the design takes the nearest value of the grid.",
        least=0,
        most=MOST_ABSORBER_MASS,
    )
    detuning: float = asked(
        0.0,
        "Relative error of the tuned mass damper's frequency, 0.05 for 5 %.",
        above=-1,
        most=MOST_DETUNING,
    )
    damping_detuning: float = asked(
        0.0, "Relative error of the tuned mass damper's damping.", above=-1, most=MOST_DETUNING
    )
    excitation: Excitation | None = asked(
        None,
        "Excitation: base motion, or a force on the structure (X over its static displacement); by default as in the study.",
    )
    tmd_mass_ratio: float | None = asked(
        None,
        "Mass ratio μ of the tuned mass damper alone; by default equal to that of the design.",
        above=0,
        most=MOST_ABSORBER_MASS,
    )


@dataclass(frozen=True)
class FollowUps:
    """Finished follow-up studies, and the choice whether to compute further studies."""

    with_: tuple[str, ...] = asked(
        (),
        "Id of a follow-up study that is done.",
        form="ID",
        options=_WITH,
        studies=True,
        # the command itself computes the follow-up studies and finds finished studies
        doors=("http", "client"),
    )
    dry_run: bool = asked(False, "Report known results and the next points; compute nothing.")


@dataclass(frozen=True)
class Step:
    """Steps of the search for a parameter."""

    tolerance: float = asked(1e-3, "Grid step down to which each parameter is refined.", least=FINEST)


@dataclass(frozen=True)
class Search(Step):
    """Extent of a refinement."""

    value_tolerance: float = asked(
        0.01, "Smallest relative improvement that is worth searching for.", least=1e-6, most=0.5
    )
    budget: int = asked(
        20_000, "Largest total number of points of all follow-up studies.", least=0, most=10**9
    )


@dataclass(frozen=True)
class Design:
    """Coordinates of what is compared: a design, or a point of a study."""

    at: At = asked_at()


@dataclass(frozen=True)
class Boundary:
    """The dimension for locating a change of the response class, and the values of the other dimensions."""

    along: str | None = asked(
        None,
        "Locate where the response class changes along this dimension, instead of the optimum.",
        allowed=DIMENSIONS,
        form="DIMENSION",
        options=("--boundary",),
    )
    at: At = asked_at()


@dataclass(frozen=True)
class Compared:
    """The record for a comparison of dampers, and the settings of the comparison.

    The parameters of structure and dampers are in `ground.quantities.QUANTITIES`.
    """

    record: str = asked(
        "loma-prieta",
        "Ground-motion record: the name of an earthquake, or the id of a record.",
        # in the command, the record is an argument, which may also be a file
        doors=("http", "client"),
    )
    tmd_criterion: Criterion = asked("den_hartog", "How the tuned mass damper is tuned.", meanings=CRITERIA)
    cases: tuple[str, ...] | None = asked(
        None,
        f"Compare only this damper: {', '.join(f'{name} ({words})' for name, words in CASES.items())}; all by default.",
        allowed=tuple(CASES),
        options=("--case",),
        form="NAME",
    )
    starts: int = asked(
        16,
        "Number of perturbed initial states that show how sensitive the response is; 0 for none.",
        least=0,
        most=MOST_STARTS,
    )
    seed: int = asked(0, "Seed of the perturbed initial states.", least=0, most=MOST_SEED)


@dataclass(frozen=True)
class Simulated:
    """Settings for the computation of one design point. The ratios of the point have the same names as in a study."""

    cycles: int | None = asked(
        None,
        "Integrate from rest for exactly this many excitation cycles; the steady response by default.",
        least=1,
    )
    method: Method = asked(
        "event", "Integration method: event-driven, or the paper's Runge–Kutta scheme with fixed steps."
    )
    history: int | None = asked(
        None, "Length of the time history, in excitation cycles before the end.", least=0, form="CYCLES"
    )
    samples: int | None = asked(
        None,
        "Largest number of samples of the time history.",
        least=2,
        # a file contains all samples
        doors=("http", "client"),
    )
    excitation: Excitation = asked(
        "base",
        "Excitation: base motion, or a force on the structure. With a force, its static displacement F₀/k takes the "
        "place of Z in the ratios.",
    )
    starts: int = asked(
        0,
        "Number of initial states whose steady responses are compared; the first is rest.",
        least=0,
        most=MOST_STARTS,
    )
    seed: int = asked(0, "Seed of the random initial states.", least=0, most=2**32 - 1)
