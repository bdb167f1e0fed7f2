"""The kinds of study, and their differences in questions and storage."""

from collections.abc import Collection, Container, Mapping
from dataclasses import dataclass
from typing import Any

from damperlab.studies.amplitudes import AMPLITUDE, over_amplitudes
from damperlab.studies.amplitudes import DAMPER as RAY_DAMPER
from damperlab.studies.amplitudes import DIMENSIONS as AMPLITUDE_DIMENSIONS
from damperlab.studies.ground.variables import DAMPER as SUITE_DAMPER
from damperlab.studies.ground.variables import DIMENSIONS as SUITE_DIMENSIONS
from damperlab.studies.ground.variables import RECORD
from damperlab.studies.ground.variables import VARIABLES as SUITE_VARIABLES
from damperlab.studies.unit_names import COORDINATE_SOURCES
from damperlab.studies.variables import BEFORE, DIMENSIONS, MADE_BY, VARIABLES, Variable


@dataclass(frozen=True)
class Kind:
    """Properties of every study of a kind.

    Parameters
    ----------
    words : str
        Name of the kind in a sentence.
    dimensions : tuple of str
        Dimensions of the cube, in order.
    variables : mapping of Variable
        Every result variable that a study may store, by name.
    metric : str
        The result that a question uses by default.
    designs : tuple of str
        Dimensions that a designer chooses. The other dimensions are conditions.
    uncontrolled : str
        Dimension that no designer controls. If a question does not fix this dimension, the answer is the worst value
        along it.
    worst : str
        Sentence that describes the worst value along the uncontrolled dimension. The placeholders are ``{count}``, the
        number of values of this dimension, and ``{band}``, the range of frequencies.
    also : tuple of str
        Further dimensions that no designer controls. By default, a map shows the worst value along these dimensions.
    axes : tuple of str
        Dimensions that become axes of a map by default, in order of preference. Dimensions with one value come last.
    ranking : frozenset of str
        Fields of `Judging` and `Ranking` that apply to studies of this kind.
    instead : str
        Advice if a question has a field that does not apply to this kind.
    """

    words: str
    dimensions: tuple[str, ...]
    variables: Mapping[str, Variable]
    metric: str
    designs: tuple[str, ...]
    uncontrolled: str
    worst: str
    also: tuple[str, ...]
    axes: tuple[str, ...]
    ranking: frozenset[str]
    instead: str


_WORST_FREQUENCY = "The largest value over the study's {count} frequencies from {band}."
HARMONIC = Kind(
    words="a harmonic study",
    dimensions=DIMENSIONS,
    variables=VARIABLES,
    metric="amplitude_ratio",
    designs=tuple(name for name in DIMENSIONS if name != "frequency_ratio"),
    uncontrolled="frequency_ratio",
    worst=_WORST_FREQUENCY,
    also=(),
    axes=(
        "clearance_ratio",
        "friction_ratio",
        "frequency_ratio",
        "mass_ratio",
        "restitution",
        "damping_ratio",
    ),
    ranking=frozenset(
        {"objective", "band", "exclude_locked", "max_impact_speed", "ranges", "top", "pareto", "with_"}
    ),
    instead="leave it out, or use `objective`, `band` and ranges of its dimensions and results",
)
SUITE = Kind(
    words="a ground-motion suite",
    dimensions=tuple(SUITE_DIMENSIONS),
    variables=SUITE_VARIABLES,
    metric="peak_relative_displacement_m",
    designs=SUITE_DAMPER,
    uncontrolled=RECORD,
    worst="The largest value over the {count} records of the suite.",
    also=(),
    axes=(
        "clearance_m",
        "friction_force_n",
        "scale",
        "particle_mass_kg",
        "natural_frequency_hz",
        "restitution",
        "damping_ratio",
    ),
    ranking=frozenset({"metric", "records", "ranges", "top"}),
    instead="leave it out: dampers are ranked by `metric`, in their worst case over records, scales and structures",
)
AMPLITUDES = Kind(
    words="a study over base amplitudes",
    dimensions=tuple(AMPLITUDE_DIMENSIONS),
    variables=VARIABLES,
    metric="amplitude_m",
    designs=RAY_DAMPER,
    uncontrolled="frequency_ratio",
    worst=_WORST_FREQUENCY,
    also=(AMPLITUDE,),
    axes=(
        "clearance_m",
        "friction_force_n",
        "frequency_ratio",
        AMPLITUDE,
        "mass_ratio",
        "restitution",
        "damping_ratio",
    ),
    ranking=frozenset({"metric", "ranges", "top", "exclude_locked", "with_"}),
    instead="leave it out: dampers are ranked by `metric`, in their worst case over base amplitudes and frequencies",
)
KINDS: tuple[Kind, ...] = (HARMONIC, SUITE, AMPLITUDES)

EVERY_DIMENSION: tuple[str, ...] = tuple(
    dict.fromkeys((*(name for kind in KINDS for name in kind.dimensions), *BEFORE))
)
EVERY_VARIABLE: tuple[str, ...] = tuple(dict.fromkeys(name for kind in KINDS for name in kind.variables))


def kind_of(dimensions: Container[Any]) -> Kind:
    """Return the kind of a study from the dimensions of its cube. Only a ground-motion suite has records."""
    if RECORD in dimensions:
        return SUITE
    return AMPLITUDES if AMPLITUDE in dimensions else HARMONIC


def kind_of_definition(definition: Mapping[str, Any]) -> Kind:
    """Return the kind of a study from its definition. Only a ground-motion suite has the key `records`."""
    if "records" in definition:
        return SUITE
    crossed = over_amplitudes(definition.get("physical"), definition.get("particle", True) is not False)
    return AMPLITUDES if crossed else HARMONIC


def before_of(definition: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the optional dimensions that come first in the cube of a harmonic study, from its definition."""
    physical = definition.get("physical")
    given = physical if isinstance(physical, Mapping) else {}
    if definition.get("particle", True) is False:
        return ()
    return tuple(
        name for name in BEFORE if definition.get(name) is not None or given.get(MADE_BY[name]) is not None
    )


def dimensions_of_definition(definition: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the dimensions of the cube of a study, from its definition."""
    kind = kind_of_definition(definition)
    return (*before_of(definition), *kind.dimensions) if kind is HARMONIC else kind.dimensions


def shown_axes(
    sizes: Mapping[str, int], x: str | None, y: str | None, taken: Collection[str | None]
) -> tuple[str, str]:
    """Return the two axes of a map. A missing axis is chosen among the unused dimensions.

    Parameters
    ----------
    sizes : mapping of int
        Points along each dimension.
    x, y : str, optional
        Axes that the question names: names of ratios, or of quantities in units.
    taken : collection of str
        Dimensions that the question uses for another purpose: names of ratios, or of quantities in units.
    """
    favourites = [name for name in kind_of(sizes).axes if name in sizes]
    used = {
        name if name is None or name in sizes else COORDINATE_SOURCES.get(name, name)
        for name in (*taken, x, y)
    }
    free = [name for name in favourites if name not in used]
    free.sort(key=lambda name: sizes[name] == 1)
    # if no unused dimension remains, both axes get the same dimension, and the caller refuses the question
    free += favourites
    return x or free.pop(0), y or free.pop(0)
