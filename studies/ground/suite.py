"""A ground-motion suite: a study over records, scale factors and design parameters, all in physical units."""

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.axes import AxisSpec, Coordinates, Range, axis_count, axis_values
from damperlab.studies.cavity import Cavity, cavity_of
from damperlab.studies.choices import Contact
from damperlab.studies.digest import feed
from damperlab.studies.faults import Fault, StudyFaults
from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.ground.source import RecordSource
from damperlab.studies.ground.variables import DIMENSIONS, RECORD, VARIABLES
from damperlab.studies.variables import MADE_BY, Variable

AXES: tuple[str, ...] = tuple(name for name in DIMENSIONS if name != RECORD)
"""Quantities that a suite varies in addition to its records."""

NUMBERS = ("mass_kg", "tail_s", "perturbation_m", *MADE_BY.values())

_SCHEME = b"damperlab survey 1"
"""Change it only if the same suite is computed or stored differently: every stored digest begins with it."""


@dataclass(frozen=True)
class Suite:
    """A ground-motion suite: a grid of responses to records. Made by `read_suite`; an instance is always valid.

    Parameters
    ----------
    name : str
        Free text.
    records : tuple of RecordSource
        Sorted by id, because their order has no meaning; the values of every axis are sorted for the same reason.
    axes : dict of AxisSpec
        The values of each of `AXES`.
    numbers : dict of float
        The values of `NUMBERS`; friction and tilt of the cavity only if they are not 0.
    starts, seed : int
        Perturbed starts of each point in addition to the one at rest, and the seed of their draw.
    contact : Contact
        The model of an impact.
    metrics : tuple of str
        Names of the stored variables.
    motions : mapping of GroundMotion
        The records' samples by id, if available: a submitted suite has them, a suite read from a store does not.
    """

    name: str
    records: tuple[RecordSource, ...]
    axes: dict[str, AxisSpec]
    numbers: dict[str, float]
    starts: int
    seed: int
    contact: Contact
    metrics: tuple[str, ...]
    motions: Mapping[str, GroundMotion] = field(default_factory=dict, compare=False, repr=False)

    @cached_property
    def coordinates(self) -> Coordinates:
        """The dimensions in the cube's order: record as text, the others float64; read-only."""
        axes = {name: axis_values(self.axes[name]) for name in AXES}
        return Coordinates({RECORD: np.array([record.id for record in self.records]), **axes})

    @property
    def identities(self) -> dict[str, NDArray[Any]]:
        """The coordinates, with each record identified by its samples, because after an update an id may name other
        samples.
        """
        told = np.array([f"{record.id} {record.sha256}" for record in self.records])
        return self.coordinates | {RECORD: told}

    @property
    def cavity(self) -> Cavity:
        """Tilt of the cavity, and friction of the particle in it."""
        return cavity_of(self.numbers)

    @property
    def labels(self) -> dict[str, dict[str, str]]:
        """``units`` and ``long_name`` of the dimensions."""
        return {name: {"units": unit, "long_name": words} for name, (unit, words) in DIMENSIONS.items()}

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of records, then of values along each of `AXES`."""
        return (len(self.records), *(axis_count(self.axes[name]) for name in AXES))

    @property
    def points(self) -> int:
        """Number of points: every record with every combination of values of `AXES`."""
        return math.prod(self.shape)

    @property
    def variables(self) -> dict[str, Variable]:
        """Every variable of a suite, in the cube's order."""
        return VARIABLES

    @property
    def whole_rows(self) -> bool:
        """Whether a point continues from another one; none does."""
        return False

    @cached_property
    def digest(self) -> str:
        """SHA-256 over the content, records by their samples and axes by their values, in hexadecimal."""
        content = hashlib.sha256(_SCHEME)
        for name, values in self.identities.items():
            text = values.dtype.kind == "U"
            feed(content, name, "\n".join(values).encode() if text else values.astype("<f8").tobytes())
        settings = self.settings() | {"metrics": self.metrics}
        feed(content, "settings", json.dumps(settings, sort_keys=True).encode())
        return content.hexdigest()

    def settings(self) -> dict[str, Any]:
        """Give everything that a point's values depend on except its coordinates."""
        settings = {"contact": self.contact.model_dump(mode="json"), "starts": self.starts, **self.numbers}
        if self.starts:
            return settings | {"seed": self.seed}
        del settings["perturbation_m"]
        return settings

    @property
    def attached(self) -> dict[str, str]:
        """SHA-256 of each record, by the name of its file in the cube."""
        return {record.key: record.sha256 for record in self.records}

    def attachments(self) -> dict[str, bytes]:
        """Give the records' samples, which are stored with the definition so that every worker finds them.

        Raises
        ------
        StudyFaults
            If they are not available.
        """
        lost = [record.id for record in self.records if record.id not in self.motions]
        if lost:
            advice = "upload the record again"
            raise StudyFaults(
                Fault(
                    "records",
                    f"{each}, whose samples are gone",
                    "a record whose samples are stored",
                    advice,
                    f"The samples of record {each} are no longer stored.",
                )
                for each in lost
            )
        return {record.key: self.motions[record.id].content for record in self.records}

    def document(self) -> dict[str, Any]:
        """Give the suite as JSON-able data that parses back to an equal suite."""
        axes = {
            name: spec.model_dump() if isinstance(spec, Range) else spec for name, spec in self.axes.items()
        }
        return {
            "name": self.name,
            "records": [record.document() for record in self.records],
            "axes": {name: list(spec) if isinstance(spec, tuple) else spec for name, spec in axes.items()},
            **self.numbers,
            "starts": self.starts,
            "seed": self.seed,
            "contact": self.contact.model_dump(mode="json"),
            "metrics": list(self.metrics),
        }


def windows_of(
    source: RecordSource, natural_frequency_hz: NDArray[np.float64] | float, tail_s: float
) -> NDArray[np.float64]:
    """Estimate the number of steps of a run: the steps of the record, subdivided if the natural frequency is high."""
    shortest = np.minimum(source.step_s, 0.4 / (2.0 * math.pi * np.asarray(natural_frequency_hz)))
    return np.asarray((source.duration_s + tail_s) / shortest)
