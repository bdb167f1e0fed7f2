"""A study, as validated data."""

import math
from collections.abc import Mapping
from functools import cached_property
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import (
    ConfigDict,
    Field,
    ModelWrapValidatorHandler,
    ValidationError,
    model_validator,
)

from damperlab.studies.amplitudes import AMPLITUDE, AT_NATURAL, RATIOS_OF, STATIC
from damperlab.studies.amplitudes import DIMENSIONS as AMPLITUDE_DIMENSIONS
from damperlab.studies.axes import (
    AxisSpec,
    ClearanceRatio,
    Coordinates,
    DampingRatio,
    FrequencyRatio,
    FrictionRatio,
    MassRatio,
    Restitution,
    along,
    axis_values,
)
from damperlab.studies.base_motion import named_after_motion
from damperlab.studies.choices import (
    Choice,
    Contact,
    Continuation,
    Ensemble,
    EventSolver,
    ExcitationField,
    InstantContact,
    Rk4Solver,
    Solver,
    Start,
    Steady,
)
from damperlab.studies.consistency import assumed, compliant_fault, faults_between, with_defaults
from damperlab.studies.contact import KEYS as CONTACT_KEYS
from damperlab.studies.digest import study_digest
from damperlab.studies.examples import EXAMPLES
from damperlab.studies.faults import Fault, StudyFaults, describe
from damperlab.studies.ground.shelf import Shelf
from damperlab.studies.ground.suite import Suite
from damperlab.studies.ground.suite_reading import read_suite
from damperlab.studies.guard import guard, refuse_the_other
from damperlab.studies.html import card
from damperlab.studies.metrics import read_metrics
from damperlab.studies.physical import Physical, derivations, derived_faults
from damperlab.studies.pydantic_faults import faults_of
from damperlab.studies.quantity import GRAVITY_RATIO, PARTICLE_FRICTION_RATIO
from damperlab.studies.reads import Reads
from damperlab.studies.static_displacement import (
    force_faults,
    named_after_force,
    with_static_displacement,
    without_force,
)
from damperlab.studies.variables import (
    BEFORE,
    DIMENSION_LONG_NAMES,
    DIMENSIONS,
    MADE_BY,
    STANDARD,
    VARIABLES,
    Variable,
    dimensions_of,
)
from damperlab.studies.vocabulary import OF_PARTICLE

MAX_NAME = 200
"""Largest number of characters of a study's name."""


def _read_name(raw: object) -> str:
    allowed = f"a text of at most {MAX_NAME} printable characters"
    if not isinstance(raw, str) or len(raw) > MAX_NAME or not raw.isprintable():
        raise StudyFaults(
            [Fault("", describe(raw), allowed, "write a short text on one line, or leave it out")]
        )
    return raw.strip()


def _read_particle(raw: object) -> bool:
    if not isinstance(raw, bool):
        advice = "write false for a scene without a particle"
        raise StudyFaults([Fault("", describe(raw), "true or false", advice)])
    return raw


def _read_metrics(raw: object) -> tuple[str, ...]:
    return read_metrics(raw, VARIABLES)


class Axes(Choice):
    """The varied quantities. Each quantity is a number, a list of numbers, or ``{start, stop, num, spacing}``."""

    restitution: Restitution = None
    mass_ratio: MassRatio = None
    clearance_ratio: ClearanceRatio = None
    friction_ratio: FrictionRatio = None
    frequency_ratio: FrequencyRatio = None


class Study(Choice):
    """A study: a grid of design points, the method of computation, and the results to store.

    ``Study(name=…, axes={…})`` checks the definition like `parse_study`, and raises `StudyFaults` with every fault. So
    an instance is always valid. A ratio is None if the physical block determines the ratio, or if there is no particle.
    """

    model_config = ConfigDict(
        json_schema_extra={
            "description": "A grid of design points, how each is computed, and what is stored.",
            "examples": list(EXAMPLES),
        }
    )

    name: Annotated[
        str,
        Reads(
            _read_name, {"type": "string", "maxLength": MAX_NAME, "default": "", "description": "free text"}
        ),
    ] = ""
    damping_ratio: DampingRatio = None
    particle_friction_ratio: Annotated[AxisSpec | None, along(PARTICLE_FRICTION_RATIO)] = None
    gravity_ratio: Annotated[AxisSpec | None, along(GRAVITY_RATIO)] = None
    axes: Axes = Field(default_factory=Axes)
    particle: Annotated[
        bool,
        Reads(
            _read_particle,
            {"type": "boolean", "default": True, "description": "false: a scene without a particle"},
        ),
    ] = True
    excitation: ExcitationField = None
    contact: Contact = InstantContact()
    metrics: Annotated[
        tuple[str, ...],
        Reads(
            _read_metrics,
            {
                "type": "array",
                "items": {"type": "string", "enum": list(VARIABLES)},
                "minItems": 1,
                "uniqueItems": True,
                "description": (
                    "variables to store, always with status; by default all of the start option except those "
                    "of the acceleration"
                ),
            },
        ),
    ] = STANDARD
    steady: Steady = Steady()
    solver: Solver = EventSolver()
    start: Start = "rest"
    physical: Physical | None = None

    def __init__(self, **document: Any) -> None:
        """Check a definition given by keywords."""
        try:
            super().__init__(**document)
        except ValidationError as error:
            raise StudyFaults(faults_of(error, KEYS, document)) from None

    # without this flag, pydantic would validate through this method and check documents twice
    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]

    @model_validator(mode="wrap")
    @classmethod
    def _every_fault(cls, raw: Any, handler: ModelWrapValidatorHandler["Study"]) -> "Study":
        """Validate the fields and the rules between them, and raise all faults together."""
        if isinstance(raw, Study):
            return raw
        given, faults = guard(raw)
        document = with_static_displacement(given)
        study: Study | None = None
        try:
            study = handler(with_defaults(document))
        except ValidationError as error:
            faults.extend(named_after_force(faults_of(error, KEYS, given), given))
        faults.extend(named_after_force(faults_between(without_force(document)), given))
        faults = list(named_after_motion(faults, given))
        faults.extend(force_faults(document))
        if study is not None and study.physical is not None and not faults:
            faults.extend(
                derived_faults(study.physical, study.particle, study.coordinates["frequency_ratio"])
            )
        if study is not None and study.particle and not faults and study.contact.model == "compliant":
            fault = compliant_fault(float(study.coordinates["restitution"][0]), "axes.restitution")
            faults.extend([fault] if fault else [])
        if study is None or faults:
            raise StudyFaults(faults)
        # stored as a cached property instead of a field, because equal studies may have different `assumed`
        study.__dict__["assumed"] = assumed(given)
        return study

    @cached_property
    def assumed(self) -> tuple[str, ...]:
        """Dimensions that have default values because the document omits them."""
        return ()

    @cached_property
    def coordinates(self) -> Coordinates:
        """The values of the dimensions in the cube's order: read-only, float64, 1-D and increasing.

        A fixed dimension has length 1. The arrays are cached, because an axis may have a million values.
        """
        given = self.physical.values() if self.physical is not None else {}
        made = {d.ratio: d for d in derivations(given, self.particle)}
        names = tuple(AMPLITUDE_DIMENSIONS) if self.over_amplitudes else DIMENSIONS
        if self.particle and not self.over_amplitudes:
            names = (*(name for name in BEFORE if name in made or getattr(self, name) is not None), *names)
        values: dict[str, NDArray[np.float64]] = {}
        for name in names:
            if RATIOS_OF.get(name, name) in OF_PARTICLE and not self.particle:
                values[name] = np.zeros(1)
            elif name in DIMENSION_LONG_NAMES:
                values[name] = made[name].values(given) if name in made else axis_values(self._spec(name))
            else:
                values[name] = given.get(name, np.zeros(1))
        return Coordinates(values)

    @cached_property
    def over_amplitudes(self) -> bool:
        """Whether the base amplitude is a dimension; see `damperlab.studies.amplitudes`."""
        return self.physical is not None and self.physical.over_amplitudes(self.particle)

    def ratios(self, points: Mapping[str, NDArray[Any]]) -> Mapping[str, NDArray[Any]]:
        """Return the coordinates of points together with all six ratios. All arrays have the same shape."""
        if not self.over_amplitudes or self.physical is None:
            return points
        return {**points, **self.physical.ratios_at(points, self.particle)}

    @property
    def labels(self) -> dict[str, dict[str, str]]:
        """``units`` and ``long_name`` of the dimensions."""
        named = {name: ("1", DIMENSION_LONG_NAMES[name]) for name in dimensions_of(self.coordinates)}
        if self.over_amplitudes:
            named = AMPLITUDE_DIMENSIONS
            if self.physical is not None and self.physical.constant is not None:
                named = named | {AMPLITUDE: (named[AMPLITUDE][0], AT_NATURAL)}
            if self.forced:
                named = named | {AMPLITUDE: (named[AMPLITUDE][0], STATIC)}
        return {name: {"units": unit, "long_name": words} for name, (unit, words) in named.items()}

    @property
    def forced(self) -> bool:
        """Whether the excitation is a force on the structure instead of a shaken base."""
        return self.excitation == "force"

    @property
    def identities(self) -> Coordinates:
        """The coordinates, which also identify a point across studies."""
        return self.coordinates

    @property
    def variables(self) -> dict[str, Variable]:
        """Every variable of a study of this kind, in the cube's order."""
        return VARIABLES

    @property
    def whole_rows(self) -> bool:
        """Whether a block must contain all frequencies, because each response starts from the previous response."""
        return isinstance(self.start, Continuation)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values along each dimension."""
        return tuple(len(values) for values in self.coordinates.values())

    @property
    def points(self) -> int:
        """Number of design points."""
        return math.prod(self.shape)

    @cached_property
    def digest(self) -> str:
        """SHA-256 hash of the content of the study, 64 hexadecimal digits; see `damperlab.studies.digest`."""
        return study_digest(self)

    def settings(self) -> dict[str, Any] | None:
        """Return all settings that affect the results at given coordinates; None if `start` is not rest."""
        if self.start != "rest":
            return None
        settings: dict[str, Any] = self.model_dump(
            mode="json", include={"particle", "contact", "steady", "solver"}
        )
        if not self.particle:
            del settings["contact"]
        if self.forced:
            settings["excitation"] = self.excitation
        if before := [name for name in BEFORE if name in self.coordinates]:
            settings["before"] = before  # points with different dimensions are different points
        if self.over_amplitudes and self.physical is not None:
            # the ratios also depend on the structure and on the cavity
            given = self.physical.values()
            structure = {name: given.get(name) for name in ("mass_kg", "natural_frequency_hz")}
            structure |= {name: given[name] for name in MADE_BY.values() if name in given}
            settings |= {name: None if found is None else found.tolist() for name, found in structure.items()}
            if self.physical.constant is not None:
                settings["constant"] = self.physical.constant
        return settings

    @property
    def attached(self) -> dict[str, str]:
        """An empty mapping, because workers need no files besides the definition."""
        return {}

    def attachments(self) -> dict[str, bytes]:
        """Return an empty mapping, because the study has no attached files."""
        return {}

    def _repr_html_(self) -> str:
        """Return HTML for a notebook, with the varied quantities and the number of points."""
        sizes = [(name, _spelled(values)) for name, values in self.coordinates.items()]
        return card(f"Study {self.name}".strip(), [("points", f"{self.points:,}"), *sizes])

    def document(self) -> dict[str, Any]:
        """Return the study as JSON-able data. Parsing the data gives an equal study."""
        dumped: dict[str, Any] = self.model_dump(mode="json", exclude_none=True)
        return dumped

    def _spec(self, name: str) -> AxisSpec:
        # a ratio is None only if the physical block determines the ratio, or if the particle is missing
        spec: AxisSpec = getattr(self.axes if name in Axes.model_fields else self, name)
        return spec


def _spelled(values: NDArray[np.float64]) -> str:
    if len(values) == 1:
        return f"{values[0]:g}"
    return f"{values[0]:g} to {values[-1]:g}, {len(values)} values"


def parse_study(document: object, shelf: Shelf | None = None) -> Study | Suite:
    """Validate a study. A document with the key `records` is a ground-motion suite.

    Parameters
    ----------
    document : object
        The study as read from JSON or YAML.
    shelf : Shelf, optional
        Store with the records of a suite; not needed for a stored definition.

    Returns
    -------
    Study or Suite
        The valid study, with all defaults.

    Raises
    ------
    StudyFaults
        If the document has faults; the error lists every fault.
    """
    if isinstance(document, Suite):
        return document
    refuse_the_other(document, "study")
    if isinstance(document, dict) and "records" in document:
        return read_suite(document, shelf)
    return parse_harmonic(document)


def parse_harmonic(document: object) -> Study:
    """Validate a study of steady responses to a harmonic excitation. Faults are raised as by `parse_study`."""
    try:
        return Study.model_validate(document)
    except ValidationError as error:
        raise StudyFaults(faults_of(error, KEYS, document)) from None


KEYS: dict[str, tuple[str, ...]] = {
    "": tuple(Study.model_fields),
    "axes": tuple(Axes.model_fields),
    "physical": tuple(Physical.model_fields),
    "steady": tuple(Steady.model_fields),
    **CONTACT_KEYS,
    "solver.event": tuple(EventSolver.model_fields),
    "solver.rk4": tuple(Rk4Solver.model_fields),
    "start.ensemble": tuple(Ensemble.model_fields),
    "start.continuation": tuple(Continuation.model_fields),
}
"""The keys that each mapping of a study may have."""
